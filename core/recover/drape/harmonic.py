"""Extend values at some vertices of a flat mesh harmonically to the others."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from ...geometry.connectivity import HalfEdges
from ...geometry.linear import factor_symmetric


def extend_harmonically(faces: np.ndarray, count: int, fixed: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Extend values at fixed vertices harmonically over a flat mesh (uniform Laplacian), shape [count, value_count]."""
    adjacency = HalfEdges.of(faces, count).adjacency
    laplacian = sparse.csr_matrix(sparse.csgraph.laplacian(adjacency) + 1e-9 * sparse.identity(count))
    free = np.setdiff1d(np.arange(count), fixed)
    result = np.zeros((count, values.shape[1]))
    result[fixed] = values
    right = -(laplacian[free][:, fixed] @ values)
    result[free] = factor_symmetric(laplacian[free][:, free]).solve(right)
    return result
