"""The derivatives of the posed template, against finite differences of its points."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.body.fit import FitState, Fitter, OrientedPoints, _apply_step, axis_angles_of
from garmentq.core.body.fit_slopes import PairWeights
from garmentq.core.body.template import load_template, rotations_of

SHAPE_COUNT = 4
STEP = 1e-6
"""Of the finite differences [rad, m, 1]: rounding is 1e-10, the second order 1e-6."""


@pytest.fixture(scope="module")
def fitter() -> Fitter:
    """Return a fitter of 40 points all over the body."""
    template = load_template()
    subset = np.random.default_rng(0).choice(len(template.vertices), 40, replace=False)
    return Fitter(template, subset, OrientedPoints(np.zeros((1, 3)), np.eye(3)[:1]))


@pytest.fixture(scope="module")
def state() -> FitState:
    """Return a bent body of no usual shape."""
    rng = np.random.default_rng(1)
    return FitState(rng.normal(size=SHAPE_COUNT), rotations_of(0.4 * rng.normal(size=(24, 3))), rng.normal(size=3))


def pull(fitter: Fitter, state: FitState, directions: np.ndarray, is_plane: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return S and g where each point is pulled by one metre along its own direction, shape [n, 3]."""
    count = len(directions)
    pairs = PairWeights(np.arange(count), np.ones(count), directions, directions, is_plane)
    return fitter._scale_slopes(SHAPE_COUNT, fitter._place(state), pairs)


@pytest.mark.parametrize("is_plane", [True, False])
def test_the_gradient_is_that_of_the_points(fitter, state, is_plane):
    """Broken where a joint moves what is not below it, an axis is another frame's, or the shape's own joints stay."""
    directions = np.random.default_rng(2).normal(size=(40, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    _, gradient = pull(fitter, state, directions, is_plane)
    for column in range(75 + SHAPE_COUNT):
        step = np.zeros(75 + SHAPE_COUNT)
        step[column] = STEP
        ahead, behind = (fitter._place(_apply_step(state, sign * step, SHAPE_COUNT)).points for sign in (1.0, -1.0))
        moved = (directions * (ahead - behind)).sum() / (2.0 * STEP)
        assert gradient[column] == pytest.approx(moved, abs=1e-6), column


def test_the_normal_matrix_is_that_of_the_weighted_slopes(fitter, state):
    """Broken where a point's pairs are another's, or the factor of their weights is transposed."""
    rng = np.random.default_rng(3)
    row = rng.integers(40, size=90)
    directions = rng.normal(size=(90, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    pairs = PairWeights(row, rng.uniform(0.5, 2.0, 90), directions, directions, True)
    scaled, _ = fitter._scale_slopes(SHAPE_COUNT, fitter._place(state), pairs)
    slopes = np.zeros((90, 75 + SHAPE_COUNT))
    for k in range(90):
        one = np.zeros((40, 3))
        one[row[k]] = directions[k]
        slopes[k] = pull(fitter, state, one, False)[1]
    expected = (slopes * pairs.weight[:, None]).T @ slopes
    np.testing.assert_allclose(scaled @ scaled.T, expected, atol=1e-5 * np.abs(expected).max())


def test_points_without_a_pair_pull_nothing(fitter, state):
    """Broken where a point that has no partner makes the system singular or draws it."""
    pairs = PairWeights(np.array([3]), np.ones(1), np.eye(3)[:1], np.eye(3)[:1], True)
    scaled, gradient = fitter._scale_slopes(SHAPE_COUNT, fitter._place(state), pairs)
    assert np.isfinite(scaled).all() and np.isfinite(gradient).all()
    others = np.arange(scaled.shape[1]) // 3 != 3
    assert np.abs(scaled[:, others]).max() < 1e-100


def test_axis_angles_are_those_of_the_rotations():
    """Broken where an axis points the other way, no turn has one, or half a turn loses it."""
    rng = np.random.default_rng(4)
    vectors = rng.normal(size=(24, 3))
    vectors *= (np.array([0.0, 1e-12, 1e-7, 3.05, 3.14159] + 19 * [1.3]) / np.linalg.norm(vectors, axis=1))[:, None]
    np.testing.assert_allclose(axis_angles_of(rotations_of(vectors)), vectors, atol=1e-9)
