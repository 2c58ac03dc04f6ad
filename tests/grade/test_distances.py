"""Distances of contours along the skeleton (thesis algorithm 3), on skeletons where they are known."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.body.body import JOINTS, Body
from garmentq.core.recover.grade.distances import compare_contours, limb_chain, loop_centre, position_along
from garmentq.core.scan.contours.target import Contour

PLACES = {
    "pelvis": (0, 0.9, 0), "spine1": (0, 1.0, 0), "spine2": (0, 1.1, 0), "spine3": (0, 1.2, 0),
    "neck": (0, 1.4, 0), "head": (0, 1.5, 0),
    "collar": (0.05, 1.35, 0), "shoulder": (0.15, 1.35, 0), "elbow": (0.40, 1.35, 0), "wrist": (0.65, 1.35, 0),
    "hand": (0.75, 1.35, 0), "hip": (0.1, 0.85, 0), "knee": (0.1, 0.5, 0), "ankle": (0.1, 0.1, 0),
    "foot": (0.1, 0.02, 0),
}  # fmt: skip


@pytest.fixture
def body() -> Body:
    """Stand a skeleton of straight lines in a T-pose."""
    joints = np.zeros((24, 3))
    for i, name in enumerate(JOINTS):
        side, _, part = name.rpartition("_")
        joints[i] = np.array(PLACES[part]) * ([-1, 1, 1] if side == "right" else [1, 1, 1])
    none, index = np.zeros((0, 3)), np.zeros((0, 3), dtype=int)
    weights, transforms = np.zeros((0, 24)), np.zeros((24, 4, 4))
    return Body(none, index, joints, weights, transforms, none, index, joints, weights, np.eye(3))


def ring(centre, axis: int, radius: float = 0.1, count: int = 40) -> np.ndarray:
    """Draw a circle about a coordinate axis."""
    angle = 2 * np.pi * np.arange(count) / count
    circle = np.insert(radius * np.stack([np.cos(angle), np.sin(angle)], axis=1), axis, 0.0, axis=1)
    return circle + np.array(centre)


@pytest.mark.parametrize(
    ("name", "axis", "here", "there", "distance"),
    [
        ("cuff.left", 0, (0.30, 1.35, 0.02), (0.55, 1.33, 0.0), 0.25),
        ("cuff.right", 0, (-0.30, 1.35, 0.0), (-0.20, 1.35, 0.0), -0.10),
        ("cuff.left", 0, (0.70, 1.35, 0.0), (0.85, 1.35, 0.0), 0.15),
        ("leg.left", 1, (0.12, 0.70, 0.0), (0.10, 0.15, 0.0), 0.55),
        ("hem", 1, (0.0, 0.95, 0.0), (0.0, 0.40, 0.03), 0.55),
        ("waist", 1, (0.0, 1.05, 0.0), (0.0, 0.97, 0.0), -0.08),
        ("neck", 1, (0.0, 1.42, 0.0), (0.0, 1.45, 0.02), 0.03),
    ],
)
def test_straight_limbs_give_exact_distances(body, name, axis, here, there, distance):
    """Breaks where a contour is projected on the wrong bone or joints between two contours are skipped."""
    loop = np.arange(40)
    measures = compare_contours(
        (ring(here, axis), (Contour(name, loop, 0.6),)), (ring(there, axis, 0.12), (Contour(name, loop, 0.7),)), body
    )
    assert [m.name for m in measures] == [name]
    assert measures[0].distance == pytest.approx(distance, abs=1e-9)
    assert (measures[0].source_length, measures[0].target_length) == (0.6, 0.7)


def test_a_bent_limb_is_measured_along_its_bones(body):
    """Breaks where the straight distance is taken across a bent elbow."""
    chain = np.array([[0.0, 0, 0], [1.0, 0, 0], [1.0, -1.0, 0]])
    assert position_along(chain, np.array([0.9, 0.05, 0.0])) == pytest.approx(0.9)
    assert position_along(chain, np.array([1.1, -0.7, 0.0])) == pytest.approx(1.7)
    assert position_along(chain, np.array([1.0, -1.2, 0.3])) == pytest.approx(2.2)


def test_only_common_contours_are_compared(body):
    """Breaks where a missing contour raises or is compared with another."""
    loop = np.arange(40)
    points = ring((0, 1, 0), 1)
    assert compare_contours((points, (Contour("hem", loop, 1),)), (points, (Contour("neck", loop, 1),)), body) == ()


def test_the_centre_does_not_depend_on_the_sampling():
    """Breaks where the mean of vertices is taken: dense samples on one side would pull it there."""
    dense = np.concatenate(
        [np.linspace(0, np.pi, 200, endpoint=False), np.linspace(np.pi, 2 * np.pi, 60, endpoint=False)]
    )
    circle = np.stack([np.cos(dense), np.zeros_like(dense), np.sin(dense)], axis=1)
    assert np.abs(loop_centre(circle)).max() < 1e-3
    assert np.abs(circle.mean(0)).max() > 0.1


def test_chains_start_at_the_trunk(body):
    """Breaks where a limb is measured towards the trunk, which turns the sign of every distance."""
    assert limb_chain("cuff.right", body)[0, 0] > limb_chain("cuff.right", body)[-1, 0]
    assert limb_chain("hem", body)[0, 1] > limb_chain("hem", body)[-1, 1]
    assert np.allclose(limb_chain("hem", body)[:, 0], 0.0)
