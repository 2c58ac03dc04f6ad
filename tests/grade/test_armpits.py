"""Cloth under arms that hang: no scan shows it, and its lengths are found all the same."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.body.body import JOINTS
from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.hanging_arms import lies_under_arm
from garmentq.core.body.skinning import skin, weights_at
from garmentq.core.garment.templates import load_draped_template
from garmentq.core.recover.fit.isometry import FIT_ISOMETRY_SETTINGS, fit_isometry
from garmentq.core.recover.grade.armpits import Armpits
from garmentq.core.recover.grade.grading import grade_pattern
from garmentq.core.recover.grade.registration import register_coarsely
from garmentq.core.scan.contours.contours import name_contours
from garmentq.core.scan.contours.target import Target

SLEEVES = 1.5
"""How much longer the sleeves of the scanned T-shirt are than those of its base pattern."""


@pytest.fixture(scope="module")
def body():
    """Stand with arms down."""
    return builtin_body("builtin:female,height=1.70,pose=arms-down")


@pytest.fixture(scope="module")
def worn(body):
    """Hang the shipped T-shirt on it."""
    hung = load_draped_template("tshirt")
    nodes = skin(hung.nodes, weights_at(body, hung.nodes, rest=True), body.transforms)
    return hung.at(nodes, name_contours(nodes, hung.faces, body)[0])


def lengthen_sleeves(garment, body) -> np.ndarray:
    """Return the nodes [m] of the garment with longer sleeves, armholes where they are."""
    sleeve = np.array(["sleeve" in panel.name for panel in garment.pattern.panels])
    nodes, first = garment.nodes.copy(), garment.panel_of_uv
    for side, sign in (("left", 1.0), ("right", -1.0)):
        shoulder, elbow = (body.joints[JOINTS.index(f"{side}_{name}")] for name in ("shoulder", "elbow"))
        along = (elbow - shoulder) / np.linalg.norm(elbow - shoulder)
        own = np.unique(garment.uv_node[sleeve[first]])
        own = own[np.sign(nodes[own, 0]) == sign * np.sign(body.joint("left_shoulder")[0])]
        rest = np.intersect1d(own, garment.uv_node[~sleeve[first]])
        start = (nodes[rest] @ along).max()
        beyond = np.maximum(nodes[own] @ along - start, 0.0)
        nodes[own] += (SLEEVES - 1.0) * beyond[:, None] * along
    return nodes


def test_armholes_end_in_the_armpit_that_no_scan_shows(worn, body):
    """Broken where longer sleeves take the hidden end of the armhole along: bodices would be cut short at the sides."""
    target = lengthen_sleeves(worn, body)
    seen = worn.faces[~lies_under_arm(target, body)[worn.faces].any(axis=1)]
    scan = Target(target, seen, np.zeros_like(target), worn.contours, (), "tshirt")
    grading = grade_pattern(worn, scan, body)
    held = Armpits.of(worn, body).fixed
    assert held.any()

    def moved(nodes: np.ndarray) -> float:
        return float(np.linalg.norm(nodes - worn.nodes, axis=1)[held].max())

    assert moved(grading.garment.nodes) < 0.005
    assert moved(register_coarsely(worn, scan)) > 0.01  # what it is without


def test_arms_that_are_raised_hide_nothing(worn):
    """Broken where a pose in which the scanner sees the armpit is registered otherwise than before."""
    raised = builtin_body("builtin:female,height=1.70,pose=A")
    found = Armpits.of(worn, raised)
    assert not found.hidden.any()
    assert not found.fixed.any()


SAG = 0.03
"""How far cloth has sagged in the armpit [m]."""


def test_cloth_that_sags_in_the_armpit_leaves_its_panels_as_they_are(worn, body):
    """Broken where hidden cloth is held where a drape sagged to: sides get shorter, and armholes longer, by as much."""
    seen = worn.faces[~lies_under_arm(worn.nodes, body)[worn.faces].any(axis=1)]
    scan = Target(worn.nodes, seen, np.zeros_like(worn.nodes), worn.contours, (), "tshirt")
    sunk = worn.nodes - SAG * lies_under_arm(worn.nodes, body)[:, None] * [0.0, 1.0, 0.0]

    def longest_way(stay_hidden: float) -> float:
        settings = replace(FIT_ISOMETRY_SETTINGS, start_cost_hidden=stay_hidden)
        fitted = fit_isometry(worn, sunk, scan, body, worn.pattern, settings)
        return float(np.linalg.norm(fitted.pattern.points - worn.pattern.points, axis=1).max())

    assert longest_way(FIT_ISOMETRY_SETTINGS.start_cost_hidden) < 0.006
    assert longest_way(0.0) > 0.012  # what it is with the nodes held
