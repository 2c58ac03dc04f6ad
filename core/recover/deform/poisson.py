"""Solve the prefactored Poisson system from per-face Jacobians to positions (thesis eq. 4.1), and its adjoint."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from ...geometry.linear import factor_symmetric

POISSON_REGULARISATION_SHARE = 1e-10
"""Share of the Laplacian's mean diagonal that is added to its diagonal: free translation makes it singular."""


class PoissonSystem:
    """Solve for the positions whose gradients are nearest to given Jacobians.

    Minimises sum_f A_f |(G x)_f - J_f|^2 (thesis eq. 4.1): (G^T A G) x = G^T A J, with zero mean over the nodes.

    **Deviation**: J is the 3x2 Jacobian in the frame of the face's flat rest triangle. The third column of the thesis'
    3x3 Jacobian is in the null space of the solve.
    """

    def __init__(self, gradient: sp.csr_matrix, areas: np.ndarray) -> None:
        weights = sp.diags(np.repeat(areas, 2))
        laplacian = gradient.T @ weights @ gradient
        laplacian = laplacian + POISSON_REGULARISATION_SHARE * laplacian.diagonal().mean() * sp.identity(
            laplacian.shape[0]
        )
        self._factor = factor_symmetric(laplacian)
        self._divergence = (gradient.T @ weights).tocsr()
        self._adjoint = self._divergence.T.tocsr()

    def positions(self, jacobians: np.ndarray) -> np.ndarray:
        """Return zero-mean positions [m] from Jacobian rows, shape [2 face_count, 3]."""
        nodes = self._factor.solve(self._divergence @ jacobians)
        found: np.ndarray = nodes - nodes.mean(axis=0)
        return found

    def pull_back(self, gradient: np.ndarray) -> np.ndarray:
        """Return the gradient with respect to the Jacobian rows from that with respect to the positions."""
        return np.asarray(self._adjoint @ self._factor.solve(gradient - gradient.mean(axis=0)))
