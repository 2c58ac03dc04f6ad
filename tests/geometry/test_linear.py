"""Factorisations: right answers, refusal of what is indefinite, and an ordering that is a permutation."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sparse
from garmentq.core.geometry.connectivity import HalfEdges
from garmentq.core.geometry.dissection import dissect
from garmentq.core.geometry.linear import NotPositiveDefinite, analyse_pattern, factor_general, factor_symmetric
from garmentq.core.geometry.multifrontal import Cholesky
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse.linalg import spsolve


def graph(side: int) -> tuple[sparse.csr_matrix, HalfEdges]:
    """Return the neighbours of a square sheet's nodes, themselves among them, and its half-edges."""
    i, j = (part.ravel() for part in np.meshgrid(np.arange(side - 1), np.arange(side - 1), indexing="ij"))
    a = i * side + j
    faces = np.concatenate([np.stack([a, a + side, a + side + 1], 1), np.stack([a, a + side + 1, a + 1], 1)])
    edges = HalfEdges.of(faces)
    return sparse.csr_matrix(edges.adjacency + sparse.identity(side * side)), edges


@settings(deadline=None)
@given(st.integers(0, 2**31), st.integers(1, 60), st.sampled_from([1, 3]))
def test_random_positive_definite_matrices(seed, count, block):
    """Any pattern, in several pieces too: an entry misplaced in a front breaks this."""
    rng = np.random.default_rng(seed)
    pattern = sparse.random_array((count, count), density=min(1.0, 2.5 / count), rng=rng) + sparse.identity(count)
    blocks = sparse.csr_matrix(sparse.kron(pattern, np.ones((block, block))))
    blocks.data = rng.normal(size=blocks.nnz)
    matrix = sparse.csr_matrix(blocks @ blocks.T + 0.1 * sparse.identity(blocks.shape[0]))
    if block == 3:  # whole blocks, also where numbers cancel
        whole = sparse.kron(pattern @ pattern.T, np.ones((3, 3)))
        matrix = sparse.csr_matrix(matrix + 1e-300 * whole)
    matrix.sort_indices()
    solver = Cholesky(matrix.indptr, matrix.indices, block)
    right = rng.normal(size=(matrix.shape[0], 7))  # enough to be solved together
    assert solver.factor(matrix.data) and solver.is_positive_definite()
    exact = np.linalg.solve(matrix.toarray(), right)
    assert np.allclose(solver.solve(right), exact, rtol=1e-8, atol=1e-8 * np.abs(exact).max())
    for few, own in ((right[:, 0], exact[:, 0]), (right[:, :2], exact[:, :2])):
        assert np.allclose(solver.solve(few), own, rtol=1e-8, atol=1e-8 * np.abs(exact).max())
    lowest = np.linalg.eigvalsh(matrix.toarray())[0]
    matrix.setdiag(matrix.diagonal() - 1.5 * lowest)
    assert not solver.factor(matrix.data) and not solver.is_positive_definite()


def test_a_factor_of_single_precision_solves_to_its_digits():
    """A part of the factor left in another precision, or a result handed back in single precision, breaks this."""
    near, _ = graph(30)
    matrix = sparse.csr_matrix(near.shape[0] * sparse.identity(900) - near)
    matrix.sort_indices()
    right = np.random.default_rng(1).normal(size=900)
    exact = spsolve(sparse.csc_matrix(matrix), right)
    coarse = Cholesky(matrix.indptr, matrix.indices, single=True)
    assert coarse.factor(matrix.data) and coarse.is_positive_definite()
    shared = Cholesky(matrix.indptr, matrix.indices).in_single()
    assert shared.single and shared.factor(matrix.data)
    assert np.array_equal(shared.solve(right), coarse.solve(right))
    together = coarse.solve(np.tile(right[:, None], 8))
    assert together.dtype == np.float64
    assert np.allclose(together.T, exact, rtol=1e-5, atol=1e-6 * np.abs(exact).max())
    found = coarse.solve(right)
    assert found.dtype == np.float64
    assert 1e-9 < np.abs(found - exact).max() / np.abs(exact).max() < 1e-5
    matrix.setdiag(-1.0)
    assert not coarse.factor(matrix.data) and not coarse.is_positive_definite()


def test_the_doors_agree():
    """A door that solves another system, or forgets part of a pattern, breaks this."""
    near, edges = graph(20)
    wide = sparse.csr_matrix(near @ near)
    rng = np.random.default_rng(0)
    right = rng.normal(size=(400, 3))
    one, two = analyse_pattern(edges), analyse_pattern(edges, rings=2)
    for pattern in (near, wide):  # the narrower one first: what it lacks is zero, not what was there before
        matrix = sparse.csr_matrix(pattern.shape[0] * sparse.identity(400) - pattern)
        exact = spsolve(sparse.csc_matrix(matrix), right)
        # what the pattern of one ring does not hold is factored all the same
        doors = (factor_symmetric(matrix), *(factor_symmetric(matrix, k) for k in (one, two)), factor_general(matrix))
        for factor in doors:
            assert factor.is_positive_definite()
            assert np.allclose(factor.solve(right), exact, rtol=1e-10)


def test_what_is_indefinite_is_refused():
    """A factor of an indefinite or a singular matrix that passes for that of a definite one breaks this."""
    near, edges = graph(12)
    laplacian = sparse.csr_matrix(sparse.diags(np.asarray(near.sum(axis=1)).ravel()) - near)
    indefinite = laplacian - 0.01 * sparse.identity(144)
    solver = analyse_pattern(edges)
    for analysed in (None, solver):
        with pytest.raises(NotPositiveDefinite):
            factor_symmetric(indefinite, analysed)
    right = np.random.default_rng(0).normal(size=144)
    assert np.allclose(indefinite @ factor_general(indefinite).solve(right), right)
    assert not factor_general(indefinite).is_positive_definite()
    with pytest.raises(NotPositiveDefinite):
        factor_general(sparse.csr_matrix(np.diag([1.0, 0.0])))
    # and the analysis serves on
    assert np.allclose(factor_symmetric(laplacian + sparse.identity(144), solver).solve(np.ones(144)), 1.0)


@pytest.mark.parametrize("leaf", [4, 24])
def test_dissection_is_a_permutation_with_parents_later(leaf):
    """A node lost, doubled or eliminated after what it feeds breaks this."""
    near, _ = graph(25)
    parts = dissect(near.indptr.astype(np.int64), near.indices.astype(np.int64), leaf)
    assert np.array_equal(np.sort(np.concatenate([part.nodes for part in parts])), np.arange(625))
    for index, part in enumerate(parts):
        assert part.parent == -1 or part.parent > index
        assert (part.boundary >= part.first + len(part.nodes)).all()


def test_separators_are_short():
    """Level sets around one node, whose fronts are 2.0 sides long and cost a fifth more arithmetic, break this."""
    side = 32
    near, _ = graph(side)
    parts = dissect(near.indptr.astype(np.int64), near.indices.astype(np.int64))
    assert max(len(part.nodes) + len(part.boundary) for part in parts) < 1.8 * side
