"""A drape that crosses itself is dressed anew from the pattern's rest placement, and any other is left alone."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.body import builtin_body
from garmentq.core.drape import WearerGeometry, drape_uncrossed
from garmentq.core.drape.shipped import WEARER
from garmentq.core.mesh import self_intersections
from garmentq.core.pattern import Garment, load_draped_template, mesh_pattern, resample
from garmentq.core.simulate import Drape, Outcome, get_fabric
from garmentq.core.wear.worn import hang_from

FABRIC = get_fabric("cotton_poplin")
ANYWHERE = hang_from(None, "tshirt")


@pytest.fixture(scope="module")
def wearer() -> WearerGeometry:
    return WearerGeometry(builtin_body(WEARER))


@pytest.fixture(scope="module")
def shirt() -> Garment:
    """Return a coarse T-shirt on the body that it was drafted for."""
    worn = load_draped_template("tshirt")
    mesh = mesh_pattern(worn.pattern, 1000)
    return mesh.at(resample(worn, worn.nodes, mesh))


def at_rest(nodes: np.ndarray) -> Drape:
    return Drape(nodes, 0.0, 1, 1.0, Outcome.CONVERGED, nodes)


def test_a_drape_without_crossings_stays(wearer, shirt):
    """Broken where a drape in order costs another one, or is replaced by it."""
    assert not len(self_intersections(shirt.nodes, shirt.faces))
    drape = at_rest(shirt.nodes)
    found = drape_uncrossed(shirt, drape, wearer, FABRIC, ANYWHERE)
    assert found[0] is shirt and found[1] is drape


def test_a_sleeve_inside_the_trunk_is_dressed_anew(wearer, shirt):
    """Broken where a sleeve that a scan shows grown together with the trunk stays in it."""
    nodes, shoulder = shirt.nodes.copy(), wearer.body.joint("left_shoulder")
    sleeve = nodes[:, 0] > shoulder[0] + 0.06
    nodes[sleeve] += [-0.15, -0.1, 0.0]
    lost = shirt.at(nodes)
    assert len(self_intersections(nodes, shirt.faces)) > 20
    found, drape = drape_uncrossed(lost, at_rest(nodes), wearer, FABRIC, ANYWHERE)
    assert len(self_intersections(found.nodes, found.faces)) == 0 and drape.converged
    assert {contour.name for contour in found.contours} == {"cuff.left", "cuff.right", "hem", "neck"}
