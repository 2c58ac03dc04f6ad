"""Dressing: the wearer himself wears what the recovery draped, and cloth that crosses itself is parted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.clock import Clock
from garmentq.core.drape import WearerGeometry, redrape
from garmentq.core.mesh import self_intersections
from garmentq.core.segment import Target
from garmentq.core.simulate import Drape, Outcome, get_fabric
from garmentq.core.wear import Worn, dress_body, wear_template
from garmentq.core.wear.parting import part_layers


@pytest.fixture(scope="module")
def worn() -> Worn:
    """Return a skirt as it hangs on the body that it was drafted for."""
    return wear_template("skirt", get_fabric("cotton_poplin"))


def at_rest(nodes: np.ndarray) -> Drape:
    """Return nodes as an equilibrium."""
    return Drape(nodes, 0.0, 1, 1.0, Outcome.CONVERGED, nodes)


def test_cloth_that_crosses_nothing_stays(worn):
    """Broken where cloth that is in order is brought to rest a second time."""
    drape = at_rest(worn.garment.nodes)
    found = part_layers(worn.garment, WearerGeometry(worn.body), worn.fabric, worn.target, drape)
    assert found[0] is worn.garment.nodes and found[1] is drape


@pytest.mark.nightly
def test_crossed_cloth_is_parted(worn):
    """Broken where cloth that was pulled through another layer stays there."""
    garment, wearer = worn.garment, WearerGeometry(worn.body)
    pulled = garment.nodes.copy()
    hem = pulled[:, 1] < pulled[:, 1].min() + 0.08
    front = hem & (np.abs(pulled[:, 0]) < 0.06) & (pulled[:, 2] > 0.0)
    behind = pulled[hem, 2].min() - pulled[front, 2].max() - 0.02
    pulled[front, 2] += behind
    assert len(self_intersections(pulled, garment.faces)) > 10
    nodes, drape = part_layers(garment.at(pulled), wearer, worn.fabric, worn.target, at_rest(pulled))
    assert len(self_intersections(nodes, garment.faces)) == 0 and drape.converged


@pytest.mark.nightly
def test_the_wearer_himself_wears_the_redraped_mesh(worn):
    """Broken where a result that is dressed on its own wearer is not what the recovery draped anew."""
    garment = worn.garment
    scan = Target(garment.nodes, garment.faces, np.zeros_like(garment.nodes), garment.contours, (), "skirt")
    nodes, _ = redrape(garment, WearerGeometry(worn.body), worn.fabric, scan)
    dressed = dress_body(replace(worn, garment=garment.at(nodes)), worn.body, None, Clock())
    assert dressed.metrics["self_intersecting_faces"] == 0.0
    assert np.linalg.norm(dressed.worn.garment.nodes - nodes, axis=1).max() < 5e-4
