"""Points on the bust are told by curvature that a dart gathers in one place, which neither noise nor a bust feigns."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.skinning import rest_body
from garmentq.core.recover.drape.sizing import measure_wearer
from garmentq.core.recover.grade.bust_points import find_bust_points
from garmentq.core.recover.grade.trunk_curvature import TrunkCurvature
from garmentq.core.scan.contours.target import Target

BODY = builtin_body("builtin:female,height=1.70")

POINTS = np.array([[0.10, -0.04], [-0.10, -0.04]])
"""Where the front is pointed: to the wearer's left, and above the armpit [m]."""


def front(depth: np.ndarray, *, spacing: float = 0.01, noise: float = 0.0) -> Target:
    """Return a sheet before the chest, `depth` [m] further back at each of its vertices; `noise` [m] moves each."""
    rng = np.random.default_rng(0)
    x, y = grid(spacing)
    pelvis = rest_body(BODY).joint("pelvis")
    armpit = measure_wearer(BODY).armpit_height - pelvis[1] + BODY.joint("pelvis")[1]
    vertices = np.stack([x, y + armpit, BODY.joint("pelvis")[2] + 0.2 - depth], axis=2).reshape(-1, 3)
    number = np.arange(x.size).reshape(x.shape)
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
    faces = np.concatenate([np.stack([a, b, c], 2).reshape(-1, 3), np.stack([a, c, d], 2).reshape(-1, 3)])
    vertices = vertices + noise * rng.normal(size=vertices.shape)
    return Target(vertices, faces, np.zeros_like(vertices), (), (), "tank")


def grid(spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """Return places to the wearer's left and above the armpit [m], shape [n, m] each."""
    across, up = np.arange(-0.36, 0.361, spacing), np.arange(-0.4, 0.251, spacing)
    return tuple(np.meshgrid(across, up))


def cones(angle: float, spacing: float = 0.01, points: np.ndarray = POINTS) -> np.ndarray:
    """Return the depth of a sheet that ends in cones of an angle [rad] at points."""
    x, y = grid(spacing)
    away = np.min([np.hypot(x - left, y - up) for left, up in points], axis=0)
    return away * np.sqrt(1.0 / (1.0 - angle / (2.0 * np.pi)) ** 2 - 1.0)


def bust(height: float, wide: float) -> np.ndarray:
    """Return the depth of a sheet with two smooth hills, their height and standard deviation [m]."""
    x, y = grid(0.01)
    return -sum(height * np.exp(-0.5 * ((x - a) ** 2 + (y - b) ** 2) / wide**2) for a, b in POINTS)


@pytest.mark.parametrize(("spacing", "noise"), [(0.01, 0.0), (0.004, 0.0), (0.01, 0.0005), (0.005, 0.001)])
def test_the_ends_of_two_darts_are_found(spacing: float, noise: float) -> None:
    """Broken where a point is off by 2 cm, or noise of any mesh moves the angle by a sixth."""
    found = find_bust_points(TrunkCurvature.of(front(cones(0.7, spacing), spacing=spacing, noise=noise), BODY))
    assert found is not None
    truth = np.c_[POINTS[:, 0], POINTS[:, 1]]
    pelvis = BODY.joint("pelvis")
    above = found.places[:, 1] - pelvis[1] - measure_wearer(BODY).armpit_height + rest_body(BODY).joint("pelvis")[1]
    assert np.abs(np.c_[found.places[:, 0] - pelvis[0], above] - truth).max() < 0.02
    assert found.angle == pytest.approx(0.7, rel=1 / 6)


@pytest.mark.parametrize(
    ("depth", "noise"),
    [
        (cones(0.4), 0.0),
        (cones(0.7, points=POINTS[:1]), 0.0),
        (bust(0.02, 0.04), 0.0),
        (bust(0.0, 0.04), 0.001),
        (0.01 * np.cos(2.0 * np.pi * grid(0.01)[0] / 0.06), 0.0005),
    ],
)
def test_other_cloth_is_not_pointed(depth: np.ndarray, noise: float) -> None:
    """Broken where a small dart, one on one side only, a stretched bust, noise or folds are taken for darts."""
    assert find_bust_points(TrunkCurvature.of(front(depth, noise=noise), BODY)) is None
