"""Solve the cloth's symmetric sparse systems; which library does it is hidden behind one interface."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import splu

from .topology import Topology


class Solver(Protocol):
    """Factor and solve one symmetric matrix after another, all with the same pattern."""

    def analyse(self, topology: Topology) -> None:
        """Take the pattern in and do whatever depends on it alone."""

    def factor(self, data: np.ndarray) -> bool:
        """Factor the matrix with these entries (in the order of `topology.indices`); False where it is singular."""

    def solve(self, right: np.ndarray) -> np.ndarray:
        """Solve for one right side [n] or several [n, m] with the last factor."""

    def is_positive_definite(self) -> bool:
        """Tell whether the last matrix factored was positive definite."""


class SuperLU:
    """Solve with scipy's SuperLU: always there; minimum degree of A^T + A, pivots on the diagonal."""

    def __init__(self) -> None:
        self._topology: Topology | None = None
        self._factor = None

    def analyse(self, topology: Topology) -> None:
        """Take the pattern in; SuperLU cannot reuse its ordering, so nothing more."""
        self._topology = topology

    def factor(self, data: np.ndarray) -> bool:
        """Factor; see `Solver`."""
        topology = self._topology
        assert topology is not None
        n = 3 * topology.node_count
        matrix = sparse.csc_matrix((data, topology.indices, topology.indptr), shape=(n, n))
        try:
            self._factor = splu(
                matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
            )
        except RuntimeError:  # exactly singular
            self._factor = None
        return self._factor is not None

    def solve(self, right: np.ndarray) -> np.ndarray:
        """Solve; see `Solver`."""
        assert self._factor is not None
        return self._factor.solve(right)

    def is_positive_definite(self) -> bool:
        """Judge by Sylvester's law: without row swaps U's diagonal is D of L D L^T, and its signs are the inertia."""
        lu = self._factor
        if lu is None or not np.array_equal(lu.perm_r, lu.perm_c):
            return False
        return bool((lu.U.diagonal() > 0).all())


def make_solver(topology: Topology) -> Solver:
    """Give the quickest solver for definite matrices, with the pattern analysed.

    **Deviation** from numerics 1 (SuperLU, or MKL Pardiso as an extra): our multifrontal Cholesky needs nothing beyond
    scipy's BLAS and is as quick as Pardiso was. It refuses an indefinite matrix, as descent must; an adjoint at an
    equilibrium with an indefinite Hessian takes `SuperLU`.
    """
    from .multifrontal import Multifrontal

    solver = Multifrontal()
    solver.analyse(topology)
    return solver
