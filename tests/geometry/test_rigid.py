"""Rigid, similar and mirrored fits of points."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.geometry.rigid import fit_rigid
from hypothesis import given, settings
from hypothesis import strategies as st


def random_rotation(rng: np.random.Generator, dimension: int) -> np.ndarray:
    """Return a rotation, never a reflection."""
    turn, _ = np.linalg.qr(rng.normal(size=(dimension, dimension)))
    turn[:, 0] *= np.sign(np.linalg.det(turn))
    return turn


@given(st.integers(0, 1000), st.integers(2, 3), st.booleans(), st.booleans())
@settings(max_examples=60, deadline=None)
def test_a_known_motion_is_recovered(seed: int, dimension: int, scaled: bool, mirrored: bool) -> None:
    """Breaks if rotation, scale, mirror image or translation is lost or inverted."""
    rng = np.random.default_rng(seed)
    turn, move = random_rotation(rng, dimension), rng.normal(size=dimension)
    if mirrored:
        turn[:, 0] *= -1.0
    scale = float(rng.uniform(0.5, 2.0)) if scaled else 1.0
    points = rng.normal(size=(12, dimension))
    motion = fit_rigid(points, scale * points @ turn.T + move, scaled=scaled, mirrored=mirrored)
    np.testing.assert_allclose(motion.rotation, turn, atol=1e-9)
    assert motion.scale == pytest.approx(scale)
    np.testing.assert_allclose(motion.translation, move, atol=1e-9)
    np.testing.assert_allclose(motion.apply(points), scale * points @ turn.T + move, atol=1e-9)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_reflection_is_not_returned(dimension: int) -> None:
    """Breaks if the mirror image, which fits exactly, is taken for a rotation; or a rotation for a mirror image."""
    points = np.random.default_rng(0).normal(size=(20, dimension))
    image = points * np.append(-1.0, np.ones(dimension - 1))
    assert np.linalg.det(fit_rigid(points, image).rotation) == pytest.approx(1.0)
    assert np.linalg.det(fit_rigid(points, points, mirrored=True).rotation) == pytest.approx(-1.0)


@given(st.integers(0, 1000))
@settings(max_examples=30, deadline=None)
def test_no_small_turn_is_better(seed: int) -> None:
    """Breaks if the fit of points without an exact motion is not the one of least squares."""
    rng = np.random.default_rng(seed)
    source, target = rng.normal(size=(2, 9, 2))
    motion = fit_rigid(source, target)
    least = ((motion.apply(source) - target) ** 2).sum()
    for angle in (-1e-3, 1e-3):
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        turned = (motion.apply(source) - motion.target_centre) @ turn.T + motion.target_centre
        assert ((turned - target) ** 2).sum() >= least


def test_one_point_is_moved_without_a_turn() -> None:
    """Breaks if a single pair, which says nothing of rotation, turns the rest about it."""
    motion = fit_rigid(np.array([[1.0, 2.0]]), np.array([[3.0, 5.0]]))
    np.testing.assert_allclose(motion.apply(np.array([[2.0, 2.0]])), [[4.0, 5.0]])
