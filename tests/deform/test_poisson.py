"""The Poisson solve: exact where the truth is known, and its derivative."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.geometry.geometry import gradient_operator
from garmentq.core.recover.deform.jacobian_stage import FaceAdam
from garmentq.core.recover.deform.poisson import PoissonSystem


@pytest.fixture(scope="module")
def system(scene):
    garment, _, _ = scene
    gradient, areas = gradient_operator(garment.rest, garment.faces, len(garment.nodes))
    return gradient, areas, PoissonSystem(gradient, areas)


def test_gradients_of_a_flat_map_are_its_matrix(scene, system):
    """Breaks if rest edges and node order disagree, or rows and columns of the Jacobian are swapped."""
    garment, _, _ = scene
    matrix = np.array([[1.1, 0.2], [0.0, 0.9], [0.3, -0.4]])
    front = garment.panel_of_face == 0
    flat = np.zeros((len(garment.nodes), 2))
    flat[garment.uv_node[garment.panel_of_uv == 0]] = garment.uv[garment.panel_of_uv == 0]
    jacobians = (system[0] @ (flat @ matrix.T)).reshape(-1, 2, 3).transpose(0, 2, 1)
    assert np.allclose(jacobians[front], matrix, atol=1e-9)


@pytest.mark.parametrize("seed", [0, 1])
def test_solve_returns_affine_maps_of_the_drape_exactly(scene, system, seed):
    """Breaks if the right-hand side is not the Laplacian's own divergence, or the pin pulls."""
    garment, _, _ = scene
    moved = garment.nodes @ np.random.default_rng(seed).normal(size=(3, 3)) + 0.3
    found = system[2].positions(system[0] @ moved)
    assert np.allclose(found, moved - moved.mean(axis=0), atol=1e-7)


def test_derivative_of_the_solve_agrees_with_finite_differences(scene, system):
    """Breaks if the backward solve forgets the mean or the areas."""
    gradient, _, solver = system
    generator = np.random.default_rng(0)
    start = np.asarray(gradient @ scene[0].nodes)
    weight = generator.normal(size=scene[0].nodes.shape)
    found = solver.pull_back(2.0 * weight * solver.positions(start))
    way = generator.normal(size=start.shape)
    value = [float((solver.positions(start + s * way) ** 2 * weight).sum()) for s in (1e-4, -1e-4)]
    assert (found * way).sum() == pytest.approx((value[0] - value[1]) / 2e-4, rel=1e-6)


def test_a_step_turns_with_the_garment():
    """Breaks if the second moment is kept per number, as in plain Adam."""
    generator = np.random.default_rng(0)
    turn = np.linalg.qr(generator.normal(size=(3, 3)))[0]
    pull = generator.normal(size=(5, 8, 3))
    ends = []
    for matrix in (np.eye(3), turn):
        values = np.zeros((8, 3))
        move = FaceAdam(values, 2, 0.02)
        for one in pull:
            move.step(one @ matrix.T, 1.0)
        ends.append(values)
    assert np.allclose(ends[0] @ turn.T, ends[1], atol=1e-12)


def test_steps_are_those_of_adam():
    """Breaks if a decay, a correction of the start or the rate is another one: blocks of one number are plain Adam."""
    pull = np.random.default_rng(0).normal(size=(6, 5, 1))
    values, mean, square = np.zeros((5, 1)), 0.0, 0.0
    move, expected = FaceAdam(values, 1, 0.02), np.zeros((5, 1))
    for n, one in enumerate(pull, 1):
        move.step(one, 0.5)
        mean, square = 0.9 * mean + 0.1 * one, 0.999 * square + 0.001 * one**2
        expected -= 0.01 * (mean / (1 - 0.9**n)) / (np.sqrt(square / (1 - 0.999**n)) + 1e-12)
    np.testing.assert_allclose(values, expected, rtol=1e-12)
