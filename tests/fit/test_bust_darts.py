"""Bust darts of a tank are found in its drape, and given back to a base pattern that has none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.body.body import Body
from garmentq.core.body.builtin import builtin_body
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.garment.editing.darts import find_darts
from garmentq.core.garment.examine import Severity, find_faults
from garmentq.core.garment.garment import Garment
from garmentq.core.garment.pattern import Pattern
from garmentq.core.garment.resampling import resample
from garmentq.core.garment.seams import seam_mismatch
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.garment.templates import load_draped_template, load_template
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.recover.drape.sizing import measure_wearer
from garmentq.core.recover.drape.stage import drape_graded, drape_template, remesh
from garmentq.core.recover.drape.wearer import WearerGeometry
from garmentq.core.recover.fit.bust_darts import add_bust_darts, plan_bust_darts
from garmentq.core.recover.fit.dart_cutting import cut_darts
from garmentq.core.recover.grade.bust_points import BustPoints
from garmentq.core.recover.grade.grading import grade_pattern
from garmentq.core.recover.grade.sliding import SlideSettings, slide_seams
from garmentq.core.recover.state import RecoveryState
from garmentq.core.scan.contours.target import Target

ANGLE = 0.65
"""Of the darts that are sewn [rad]."""


@pytest.fixture(scope="module")
def wearer() -> WearerGeometry:
    """Return the body that the library's tank is shown on."""
    return WearerGeometry(builtin_body("builtin:female,height=1.70"))


@pytest.fixture(scope="module")
def plain() -> Garment:
    """Return the library's tank on it."""
    found = load_draped_template("tank")
    assert found is not None
    return found


def bust_of(body: Body, worn: Garment) -> BustPoints:
    """Return places on a front, 4 cm below the armpits and 10 cm beside the middle."""
    level = measure_wearer(body).armpit_height - 0.04
    front = np.flatnonzero(worn.nodes[:, 2] > np.median(worn.nodes[:, 2]))
    wanted = np.array([[0.10, level], [-0.10, level]])
    nearest = np.linalg.norm(worn.nodes[front][None, :, :2] - wanted[:, None], axis=2).argmin(axis=1)
    return BustPoints(worn.nodes[front[nearest]], ANGLE)


@pytest.fixture(scope="module")
def darted(wearer: WearerGeometry, plain: Garment) -> Pattern:
    """Return the tank with bust darts."""
    mesh = mesh_pattern(plain.pattern, 800)
    worn = mesh.at(resample(plain, plain.nodes, mesh))
    plan = plan_bust_darts(worn, bust_of(wearer.body, worn))
    assert plan is not None
    return cut_darts(worn, np.zeros((len(worn.faces), 2, 2)), plain.pattern, (plan,)).pattern


def recut(wearer: WearerGeometry, true: Pattern) -> RecoveryState:
    """Drape a pattern on the wearer, and grade and slide the library's tank to that drape."""
    base = load_template("tank")
    worn = drape_template(true, wearer)
    hangs = Target(worn.nodes, worn.faces, vertex_normals(worn.nodes, worn.faces), worn.contours, (), "tank")
    garment, _ = drape_graded(remesh(worn, 2500), wearer, get_fabric("cotton_poplin"), hangs)
    normals = vertex_normals(garment.nodes, garment.faces)
    target = replace(hangs, vertices=garment.nodes, faces=garment.faces, normals=normals, contours=garment.contours)
    graded = grade_pattern(drape_template(base, wearer, target), target, wearer.body).garment
    settings = SlideSettings().by_newton(curves=True)
    slid = slide_seams(graded, target, wearer.body, base, settings=settings)
    state = RecoveryState("tank", base, target, wearer, get_fabric("cotton_poplin"), garment=slid)
    return add_bust_darts(state, graded, settings)


@pytest.mark.slow
def test_bust_darts_come_back(wearer: WearerGeometry, darted: Pattern) -> None:
    """Broken where a dart ends elsewhere, is half as wide, or leaves seams unequal or an outline crossed."""
    found = recut(wearer, darted)
    changes = [one.evidence for one in found.findings]
    assert {(change["kind"], change["panel"]) for change in changes} == {("added", "front")}
    assert len(changes) == 2 and all(change["after"] < change["before"] for change in changes)
    pattern = found.garment.pattern
    for dart, truth in zip(find_darts(pattern), find_darts(darted), strict=True):
        assert np.linalg.norm(dart.ends(pattern)[1] - truth.ends(darted)[1]) < 0.03
        assert dart.angle(pattern) == pytest.approx(truth.angle(darted), rel=0.25)
    assert [len(panel.points) for panel in found.base.panels] == [len(panel.points) for panel in pattern.panels]
    assert seam_mismatch(pattern) < 1e-5
    assert not [fault for fault in find_faults(pattern) if fault.severity is Severity.ERROR]


@pytest.mark.nightly
def test_a_tank_without_darts_gets_none(wearer: WearerGeometry, plain: Garment) -> None:
    """Broken where cloth that lies over a bust is taken for cloth with darts."""
    assert not recut(wearer, plain.pattern).findings


def test_a_front_that_is_not_its_own_mirror_image_gets_no_darts(wearer: WearerGeometry, plain: Garment) -> None:
    """Broken where one dart alone is planned, whose other side then has none."""
    free = mesh_pattern(replace(plain.pattern, symmetric=False), 800)
    worn = free.at(resample(plain, plain.nodes, free))
    assert plan_bust_darts(worn, bust_of(wearer.body, worn)) is None


def test_darts_that_end_there_already_count(wearer: WearerGeometry, plain: Garment, darted: Pattern) -> None:
    """Broken where a bust that a dart has taken already asks for as much again."""
    mesh = mesh_pattern(darted, 800)
    coarse = mesh_pattern(plain.pattern, 800)
    worn = coarse.at(resample(plain, plain.nodes, coarse))
    points, plan = bust_of(wearer.body, worn), plan_bust_darts(worn, bust_of(wearer.body, worn))
    assert plan is not None and plan.angle == pytest.approx(ANGLE)
    cut = cut_darts(worn, np.zeros((len(worn.faces), 2, 2)), plain.pattern, (plan,))
    again = plan_bust_darts(mesh.at(cut.place(worn, worn.nodes, mesh)), points)
    assert again is None or again.angle < 0.1
