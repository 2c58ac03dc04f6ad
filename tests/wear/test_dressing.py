"""Dressing: the wearer himself wears what the recovery draped, and cloth that crosses itself is parted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.cloth.outcome import Outcome
from garmentq.core.cloth.statics import Drape
from garmentq.core.geometry.intersections import self_intersections
from garmentq.core.recover.drape.motion import rotation_of
from garmentq.core.recover.drape.stage import redrape
from garmentq.core.recover.drape.wearer import WearerGeometry
from garmentq.core.reuse.wear.dressing import dress_body, transfer_alone_to_body
from garmentq.core.reuse.wear.layer_separation import separate_layers
from garmentq.core.reuse.wear.worn import WornGarment
from garmentq.core.run.clock import Clock
from garmentq.core.scan.contours.target import Target
from worn_template import load_worn_template

RATE = 8.0
"""Angular velocity of a wearer who turns [rad/s]."""


@pytest.fixture(scope="module")
def worn() -> WornGarment:
    """Return a skirt as it hangs on the body that it was drafted for."""
    return load_worn_template("skirt", get_fabric("cotton_poplin"))


def at_rest(nodes: np.ndarray) -> Drape:
    """Return nodes as an equilibrium."""
    return Drape(nodes, 0.0, 1, 1.0, Outcome.CONVERGED, nodes)


def test_cloth_that_crosses_nothing_stays(worn):
    """Broken where cloth that is in order is brought to rest a second time."""
    drape = at_rest(worn.garment.nodes)
    found = separate_layers(worn, WearerGeometry(worn.body), drape)
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
    nodes, drape = separate_layers(replace(worn, garment=garment.at(pulled)), wearer, at_rest(pulled))
    assert len(self_intersections(nodes, garment.faces)) == 0 and drape.converged


def test_cloth_turns_on_its_own_wearer_only(worn):
    """Broken where cloth that was scanned in rotation hangs at rest on its own wearer, or turns with another body."""
    turning = replace(worn, rotation=rotation_of(worn.body, RATE))
    assert transfer_alone_to_body(turning, worn.body, None).rotation == turning.rotation
    again = replace(worn.body, vertices=worn.body.vertices.copy())
    assert transfer_alone_to_body(turning, again, None).rotation == turning.rotation
    assert transfer_alone_to_body(turning, builtin_body("builtin:male"), None).rotation is None


@pytest.mark.nightly
@pytest.mark.parametrize("rate", [0.0, RATE])
def test_the_wearer_himself_wears_the_redraped_mesh(worn, rate):
    """Broken where a result that is dressed on its own wearer is not its re-draped mesh, also in rotation."""
    garment, rotation = worn.garment, rotation_of(worn.body, rate) if rate else None
    scan = Target(garment.nodes, garment.faces, np.zeros_like(garment.nodes), garment.contours, (), "skirt")
    draped, _ = redrape(garment, WearerGeometry(worn.body), worn.fabric, scan, rotation=rotation)
    result = replace(worn, garment=garment.at(draped.nodes), rotation=rotation)
    dressed = dress_body(result, worn.body, None, Clock())
    assert dressed.report.metrics["self_intersecting_faces"] == 0.0
    assert np.linalg.norm(dressed.worn.garment.nodes - draped.nodes, axis=1).max() < 5e-4
