"""The only place where sparse matrices are factored: Cholesky where they are positive definite, else LU."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import splu

if TYPE_CHECKING:
    from .connectivity import HalfEdges
    from .multifrontal import Cholesky


class NotPositiveDefinite(np.linalg.LinAlgError):
    """The matrix is not positive definite: a part of the system is not constrained, or is unstable."""


class Factor(Protocol):
    """Solve systems with a matrix that has been factored."""

    def solve(self, right: np.ndarray) -> np.ndarray:
        """Solve for one right side [n] or several [n, m]."""

    def is_positive_definite(self) -> bool:
        """Return whether the matrix is positive definite."""


class Solver(Factor, Protocol):
    """Factor and solve symmetric matrices that share a pattern; `single` is True in single precision."""

    single: bool

    def factor(self, data: np.ndarray) -> bool:
        """Factor the matrix with these entries, in the order of the pattern; False where it is singular."""


class SuperLU:
    """Factor with scipy's SuperLU, also indefinite matrices: minimum degree of A^T + A, pivots on the diagonal."""

    single = False

    def __init__(self, indptr: np.ndarray, indices: np.ndarray) -> None:
        """Take the full symmetric pattern, columns ascending; SuperLU computes its order in each factorisation."""
        self._indptr, self._indices = indptr, indices
        self._factor = None

    def factor(self, data: np.ndarray) -> bool:
        """Factor; see `Solver`."""
        n = len(self._indptr) - 1
        matrix = sparse.csc_matrix((data, self._indices, self._indptr), shape=(n, n))
        try:
            self._factor = splu(
                matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
            )
        except RuntimeError:  # exactly singular
            self._factor = None
        return self._factor is not None

    def solve(self, right: np.ndarray) -> np.ndarray:
        """Solve; see `Factor`."""
        assert self._factor is not None
        return np.asarray(self._factor.solve(right))

    def is_positive_definite(self) -> bool:
        """Check by Sylvester's law: without row swaps U's diagonal is D of L D L^T, and its signs are the inertia."""
        lu = self._factor
        if lu is None or not np.array_equal(lu.perm_r, lu.perm_c):
            return False
        return bool((lu.U.diagonal() > 0).all())


def analyse_pattern(edges: HalfEdges, rings: int = 1) -> Cholesky:
    """Analyse the pattern of matrices that couple each vertex of a mesh with the given number of rings around it. One
    ring is the pattern of a Laplacian, two that of its square; a face's and an edge's rows are within one."""
    from .multifrontal import Cholesky

    adjacency = edges.adjacency + sparse.identity(edges.vertex_count)
    matrix = sparse.csr_matrix(adjacency)
    for _ in range(rings - 1):
        matrix = sparse.csr_matrix(matrix @ adjacency)
    matrix.sum_duplicates()
    return Cholesky(matrix.indptr, matrix.indices)


def factor_symmetric(matrix: sparse.spmatrix, analysed: Cholesky | None = None) -> Factor:
    """Factor a symmetric positive definite matrix.

    A matrix whose pattern occurs once is factored by SuperLU: the analysis for our own Cholesky takes as long as 4 to 5
    of its factorisations. With the pattern analysed our own is 3 to 5 times faster.

    Args:
        matrix: The matrix, both triangles.
        analysed: Result of `analyse_pattern`; it keeps the factor until its next one. With entries outside: SuperLU.

    Raises:
        NotPositiveDefinite: where the matrix is not positive definite.
    """
    data = None if analysed is None else analysed.place(sparse.csr_matrix(matrix))
    found: Factor
    if analysed is not None and data is not None:
        analysed.factor(data)
        found = analysed
    else:
        found = factor_general(matrix)
    if not found.is_positive_definite():
        raise NotPositiveDefinite("a matrix that must be positive definite is not")
    return found


def factor_general(matrix: sparse.spmatrix) -> Factor:
    """Factor a symmetric matrix that may be indefinite.

    Raises:
        NotPositiveDefinite: where the matrix is singular.
    """
    columns = sparse.csc_matrix(matrix)
    columns.sort_indices()
    found = SuperLU(columns.indptr, columns.indices)
    if not found.factor(columns.data):
        raise NotPositiveDefinite("the matrix is singular")
    return found
