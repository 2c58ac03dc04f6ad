"""The Poisson solve: exact where the truth is known, and its derivative."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from garmentq.core.geometry.geometry import gradient_operator
from garmentq.core.recover.deform.jacobian_stage import FaceAdam
from garmentq.core.recover.deform.poisson import PoissonSystem, solve_poisson


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
    weight = torch.from_numpy(generator.normal(size=scene[0].nodes.shape))
    rows = torch.from_numpy(start).requires_grad_(True)
    (solve_poisson(rows, solver) ** 2 * weight).sum().backward()
    way = generator.normal(size=start.shape)
    value = [float((solver.positions(start + s * way) ** 2 * weight.numpy()).sum()) for s in (1e-4, -1e-4)]
    assert (rows.grad.numpy() * way).sum() == pytest.approx((value[0] - value[1]) / 2e-4, rel=1e-6)


def test_a_step_turns_with_the_garment():
    """Breaks if the second moment is kept per number, as in plain Adam."""
    generator = np.random.default_rng(0)
    turn = np.linalg.qr(generator.normal(size=(3, 3)))[0]
    pull = generator.normal(size=(5, 8, 3))
    ends = []
    for matrix in (np.eye(3), turn):
        values = torch.zeros(8, 3, dtype=torch.float64, requires_grad=True)
        move = FaceAdam(values, 2, 0.02)
        for one in pull:
            values.grad = torch.from_numpy(one @ matrix.T)
            move.step(1.0)
        ends.append(values.detach().numpy())
    assert np.allclose(ends[0] @ turn.T, ends[1], atol=1e-12)
