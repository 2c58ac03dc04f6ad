"""What is turned over along a crease lies turned when it is worn, after dressing, in a pose and at rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.cloth.topology import Topology
from garmentq.core.garment.creases import (
    CREASE_ANGLE,
    crease_angles,
    crease_edges,
    find_turned_panels,
    mark_edges,
)
from garmentq.core.garment.garment import Garment
from garmentq.core.garment.panel_selection import select_panels
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.garment.templates import load_template
from garmentq.core.geometry.connectivity import HalfEdges
from garmentq.core.geometry.geometry import unit
from garmentq.core.geometry.intersections import self_intersections
from garmentq.core.recover.drape.pbd import build_distance_constraints
from garmentq.core.recover.drape.stage import DrapeSettings, redrape
from garmentq.core.recover.drape.wearer import WearerGeometry
from garmentq.core.reuse.wear.worn import make_waist_target

CUTS = (
    "long_sleeve_tshirt+collar=shirt,front=buttons",
    "tshirt+collar=convertible,front=open",
    "tshirt+collar=polo",
    "long_sleeve_tshirt+collar=notched,front=buttons",
    "long_sleeve_tshirt+collar=shawl,front=open",
)

NODES = 1200
"""Edges of 2.5 cm: stand and fall are one or two triangles wide."""


def turns(garment: Garment) -> np.ndarray:
    """Return the angle between the normals on both sides of each edge of the creases [rad], negative where the outside
    of the cloth is inside the turn."""
    hinges = HalfEdges.of(garment.faces, len(garment.nodes)).hinge_vertices
    x = garment.nodes[hinges[mark_edges(hinges[:, :2], crease_edges(garment))]]
    along = x[:, 1] - x[:, 0]
    first, second = unit(np.cross(along, x[:, 2] - x[:, 0])), unit(np.cross(x[:, 3] - x[:, 0], along))
    return np.arctan2((np.cross(first, second) * unit(along)).sum(1), (first * second).sum(1))


def heights_over_crease(garment: Garment) -> np.ndarray:
    """Return how high each node of a fall's outer edge is above the nearest node of the crease on its panel [m]."""
    number = [panel.name for panel in garment.pattern.panels].index("collar_fall")
    edges = {ref.edge: line for ref, line in garment.edge_uv.items() if ref.panel == "collar_fall"}
    panel = garment.pattern.panels[number]
    outer, crease = (
        np.unique(np.concatenate([line for i, line in edges.items() if test(panel.edges[i])]))
        for test in (lambda edge: edge.contour == "neck", lambda edge: edge.label.startswith("fold."))
    )
    nearest = np.linalg.norm(garment.uv[outer, None] - garment.uv[crease], axis=2).argmin(axis=1)
    y = garment.nodes[garment.uv_node, 1]
    return y[np.setdiff1d(outer, crease)] - y[crease[nearest]][~np.isin(outer, crease)]


@pytest.mark.parametrize("name", CUTS)
def test_falls_and_lapels_are_what_is_turned(name: str) -> None:
    """Breaks where a crease's seam is not labelled, or the stand or the front is taken for the turned side."""
    expected = {"collar_fall"} | ({"lapel_left", "lapel_right"} if "notched" in name or "shawl" in name else set())
    pattern = load_template(name)
    assert find_turned_panels(pattern) == expected
    garment = mesh_pattern(pattern, NODES)
    worn, numbers = select_panels(garment, frozenset(panel.name for panel in pattern.panels) - expected)
    inside = np.array([panel.name not in expected for panel in pattern.panels])[garment.panel_of_face]
    np.testing.assert_array_equal(numbers[worn.faces], garment.faces[inside])
    np.testing.assert_array_equal(worn.uv_node[worn.uv_faces], worn.faces)
    assert not find_turned_panels(worn.pattern)


def test_only_creases_are_turned_at_rest() -> None:
    """Breaks where another hinge gets a rest angle, a crease gets none, or its sign turns it inwards."""
    garment = mesh_pattern(load_template(CUTS[0]), NODES)
    topology = Topology.from_garment(garment)
    creased = mark_edges(topology.hinges.nodes[:, :2], crease_edges(garment))
    assert 0 < creased.sum() == len(crease_edges(garment))
    np.testing.assert_array_equal(topology.hinges.angles, np.where(creased, -CREASE_ANGLE, 0.0))
    plain = mesh_pattern(load_template("tshirt"), NODES)
    assert crease_angles(plain) is None and not build_distance_constraints(plain).is_creased
    assert not Topology.from_garment(plain).hinges.angles.any()


@pytest.mark.nightly
@pytest.mark.parametrize("name", CUTS)
def test_a_turned_collar_is_turned_at_rest(name: str) -> None:
    """Breaks where a fall stands up, sinks through its stand, or opens when it comes to rest: its outer edge is then no
    longer below the crease, or a lapel no longer on the chest."""
    wearer = WearerGeometry(builtin_body("builtin:female,height=1.70,pose=A"))
    garment = mesh_pattern(load_template(name), NODES)
    settings = replace(DrapeSettings(self_contact=True), template_vertices=NODES)
    worn, drape = redrape(garment, wearer, get_fabric(), make_waist_target(None, "tshirt"), settings=settings)
    assert drape.at_rest
    assert len(self_intersections(worn.nodes, worn.faces)) == 0
    assert wearer.exposed.measure(worn.nodes)[0].min() >= -1e-3
    found, heights = turns(worn), heights_over_crease(worn)
    assert np.median(found) < -2.0 * np.pi / 3.0 and found.max() < 0.0
    assert np.median(heights) < -0.005 and np.quantile(heights, 0.9) < 0.0
    assert {"neck", "hem"} <= {contour.name for contour in worn.contours}
