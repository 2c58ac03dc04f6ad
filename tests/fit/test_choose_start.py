"""A graded drape that crosses itself makes way for the pattern dressed from flat, where that is nearer to the scan."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.spec import BuiltinWearer
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.cloth.outcome import Outcome
from garmentq.core.cloth.statics import Drape
from garmentq.core.garment.garment import Garment
from garmentq.core.garment.resampling import resample
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.garment.templates import load_draped_template
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.geometry.intersections import self_intersections
from garmentq.core.recover.case import Case
from garmentq.core.recover.drape.shipped import TEMPLATE_WEARER
from garmentq.core.recover.drape.wearer import WearerGeometry
from garmentq.core.recover.fit.choose_start import choose_start
from garmentq.core.recover.recovery import Request
from garmentq.core.recover.state import RecoveryState
from garmentq.core.run.clock import Clock
from garmentq.core.run.hooks import SILENT_HOOKS
from garmentq.core.scan.contours.target import Target
from garmentq.core.scan.scan import Scan

module = sys.modules[choose_start.__module__]


@pytest.fixture(scope="module")
def shirt() -> Garment:
    """Return a coarse T-shirt on the body that it was drafted for."""
    worn = load_draped_template("tshirt")
    mesh = mesh_pattern(worn.pattern, 800)
    return mesh.at(resample(worn, worn.nodes, mesh))


@pytest.fixture(scope="module")
def case() -> Case:
    """Return the case whose scan is that T-shirt."""
    worn = load_draped_template("tshirt")
    normals = vertex_normals(worn.nodes, worn.faces)
    return Case(
        request=Request(Path("tshirt.ply"), BuiltinWearer(TEMPLATE_WEARER)),
        scan=Scan(worn.nodes, worn.faces),
        scan_target=Target(worn.nodes, worn.faces, normals, worn.contours, (), "tshirt"),
        wearer=WearerGeometry(builtin_body(TEMPLATE_WEARER)),
    )


def start_from(case: Case, garment: Garment, drape: Drape) -> RecoveryState:
    """Return the state that a graded drape leaves."""
    state = RecoveryState("tshirt", garment.pattern, case.scan_target, case.wearer, get_fabric("cotton_poplin"))
    return replace(state, garment=garment, graded=garment, drape=drape)


def at_rest(nodes: np.ndarray) -> Drape:
    return Drape(nodes, 0.0, 1, 1.0, Outcome.CONVERGED, nodes)


def test_a_drape_without_crossings_stays(case, shirt):
    """Broken where a drape in order costs another one, or is replaced by it."""
    assert not len(self_intersections(shirt.nodes, shirt.faces))
    drape = at_rest(shirt.nodes)
    found = choose_start(case, start_from(case, shirt, drape), SILENT_HOOKS)
    assert found.garment is shirt and found.drape is drape


def lose_sleeve(case: Case, shirt: Garment) -> Garment:
    """Return the T-shirt with its left sleeve across the trunk."""
    nodes, shoulder = shirt.nodes.copy(), case.body.joint("left_shoulder")
    nodes[nodes[:, 0] > shoulder[0] + 0.06] += [-0.45, -0.1, 0.0]
    assert len(self_intersections(nodes, shirt.faces)) > 20
    return shirt.at(nodes)


@pytest.mark.nightly
def test_a_sleeve_beside_its_arm_is_dressed_anew(case, shirt):
    """Broken where a sleeve that a scan shows grown together with the trunk stays beside its arm."""
    lost = lose_sleeve(case, shirt)
    found = choose_start(case, start_from(case, lost, at_rest(lost.nodes)), SILENT_HOOKS)
    garment = found.garment
    assert garment is found.graded and len(self_intersections(garment.nodes, garment.faces)) == 0
    assert found.drape.converged
    assert {contour.name for contour in garment.contours} == {"cuff.left", "cuff.right", "hem", "neck"}


@pytest.mark.parametrize("is_deformed", [False, pytest.param(True, marks=pytest.mark.nightly)])
def test_a_drape_that_is_no_farther_stays(case, shirt, is_deformed, monkeypatch):
    """Broken where a drape is given up for one without crossings that cannot be brought nearer to the scan."""
    lost = lose_sleeve(case, shirt)
    far = lost.nodes + [0.0, 0.0, 0.3]
    monkeypatch.setattr(module, "redrape", lambda *given, **named: (lost.at(far), at_rest(far)))
    if not is_deformed:  # neither comes any nearer
        monkeypatch.setattr(module, "deform", lambda garment, *given, **named: garment)
    drape = at_rest(lost.nodes)
    clock = Clock()
    found = choose_start(case, start_from(case, lost, drape), clock.hooks)
    assert found.garment is lost and found.drape is drape
    choice = clock.take_findings()[-1]  # the first ones are of the deformations
    assert choice.evidence["taken"] == "graded drape" and len(choice.evidence["scores"]) == 2
