"""The solvers of the cloth's systems: right answers, and definiteness."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sparse
from garmentq.core.cloth.energy import Energy, Inertia
from garmentq.core.cloth.scene import Scene
from garmentq.core.cloth.solver import make_solver
from garmentq.core.cloth.topology import Topology
from garmentq.core.geometry.linear import SuperLU


@pytest.fixture(scope="module")
def system(sheet, cloth):
    flat, faces = sheet(24, 17, 0.3, 0.2)
    topology = Topology.from_mesh(faces, flat[faces])
    nodes = np.column_stack([flat[:, 0], 0.01 * np.sin(30 * flat[:, 0]), flat[:, 1]])
    energy = Energy(Scene(topology, cloth), inertia=Inertia(nodes, 100.0))
    data = topology.assemble(energy.hessian(nodes, exact=False)[2], energy.scene.fixed)
    matrix = sparse.csc_matrix((data, topology.pattern.indices, topology.pattern.indptr))
    return topology, data, matrix


@pytest.mark.parametrize("make", [make_solver, lambda pattern: SuperLU(pattern.indptr, pattern.indices)])
def test_solution_and_definiteness(system, make):
    """A misplaced entry of a front, or a definiteness that is only guessed, breaks this."""
    topology, data, matrix = system
    solver = make(topology.pattern)
    right = np.random.default_rng(0).normal(size=(matrix.shape[0], 2))
    assert solver.factor(data)
    assert solver.is_positive_definite()
    for b, x in ((right, solver.solve(right)), (right[:, 0], solver.solve(right[:, 0]))):
        assert np.abs(matrix @ x - b).max() < 1e-9 * np.abs(b).max()
    shifted = data.copy()
    # an eigenvalue just below zero makes it indefinite
    lowest = sparse.linalg.eigsh(matrix, k=1, sigma=0.0)[0][0]
    diagonal = matrix.copy()
    diagonal.setdiag(matrix.diagonal() - 1.01 * lowest)
    shifted = diagonal.data
    solver.factor(shifted)
    assert not solver.is_positive_definite()
    assert solver.factor(data) and solver.is_positive_definite()  # and it recovers


def test_two_pieces_of_cloth(sheet, cloth):
    """A mesh of several components (a belt beside a dress) must not end the dissection."""
    flat, faces = sheet(9, 9, 0.1, 0.1)
    both = np.concatenate([faces, faces + len(flat)])
    topology = Topology.from_mesh(both, np.concatenate([flat, flat])[both])
    nodes = np.column_stack([np.concatenate([flat, flat + 0.2]), np.zeros(2 * len(flat))])
    energy = Energy(Scene(topology, cloth), inertia=Inertia(nodes, 100.0))
    data = topology.assemble(energy.hessian(nodes, exact=False)[2], energy.scene.fixed)
    matrix = sparse.csc_matrix((data, topology.pattern.indices, topology.pattern.indptr))
    solver = make_solver(topology.pattern)
    assert solver.factor(data)
    assert np.abs(matrix @ solver.solve(np.ones(matrix.shape[0])) - 1).max() < 1e-9
