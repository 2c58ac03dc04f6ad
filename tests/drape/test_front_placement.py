"""A front that is worn open hangs as far open as a scan shows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from garmentq.core.body.builtin import builtin_body
from garmentq.core.garment.garment import Garment
from garmentq.core.garment.templates import load_template
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.recover.drape.front_placement import FRONT_EDGES, pin_front
from garmentq.core.recover.drape.stage import DrapeSettings, drape_template
from garmentq.core.recover.drape.wearer import WearerGeometry
from garmentq.core.scan.contours.target import Target

SETTINGS = DrapeSettings(template_vertices=500)


def test_edges_hang_where_the_scan_shows_them() -> None:
    """Breaks where a front stays as far open as it was put on, is tied left to right, or follows a torn edge."""
    wearer = WearerGeometry(builtin_body("builtin:female,height=1.70"))
    pattern = load_template("long_sleeve_tshirt+front=open")
    worn = drape_template(pattern, wearer, settings=SETTINGS)
    seen = worn.nodes.copy()
    edges = [worn.contour(name) for name in FRONT_EDGES]
    for edge in edges:
        assert edge is not None
        seen[edge.vertices, 0] *= 0.2
    target = Target(seen, worn.faces, vertex_normals(seen, worn.faces), worn.contours, (), "long_sleeve_tshirt")
    again = drape_template(pattern, wearer, target, carry=True, settings=SETTINGS)

    def distance(garment: Garment) -> float:
        pins = pin_front(garment, target, wearer.body)
        assert pins is not None
        off = (pins.points - garment.nodes[pins.nodes])[:, [0, 2]]
        return float(np.sqrt((off**2).sum(axis=1).mean()))

    assert distance(again) < 0.2 * distance(worn)
    torn = replace(target, contours=tuple(replace(one, trusted=one.name != "front.left") for one in worn.contours))
    assert pin_front(worn, torn, wearer.body) is None
    lapped = target.vertices.copy()
    lapped[:, 0] *= -1.0
    pins = pin_front(worn, replace(target, vertices=lapped), wearer.body)
    assert pins is not None
    left = len(worn.contour("front.left").vertices)  # type: ignore[union-attr]
    assert pins.points[:left, 0].min() > 0.0 > pins.points[left:, 0].max()
