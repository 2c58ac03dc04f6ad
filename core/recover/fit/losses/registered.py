"""Compute the distance of a drape from the registered target: in full along the normal, reduced within the surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....garment.garment import Garment
from ....geometry.geometry import vertex_normals
from .chamfer import flat_shares


@dataclass(frozen=True)
class RegisteredLoss:
    """Compare a drape node by node with a registered target (thesis 4.3.6) [m2].

        L = 1/2 sum_v d_v^T W_v d_v,    d_v = x_v - t_v,    W_v = a_v (s I + (1 - s) n_v n_v^T) / sum a
    Registration finds the surface to a millimetre, but a node's place on it only as accurately as the pattern was
    known. So sliding within the surface has the share s of the cost; on open contours, which are visible, s = 1.

    **Deviation**: the thesis weights all three components alike.

    Attributes:
        target: t, where registration put each node [m], shape [node_count, 3].
        normals: n, unit normals there, shape [node_count, 3].
        weights: W, shape [node_count, 3, 3]; sums to at most the identity, so that 2 L is a mean square in m2.
    """

    target: np.ndarray
    normals: np.ndarray
    weights: np.ndarray

    @classmethod
    def of(cls, garment: Garment, slide: float) -> RegisteredLoss:
        """Weight the nodes of a garment on the target by their flat area; `slide` is s."""
        count, share = len(garment.nodes), flat_shares(garment)
        normals = vertex_normals(garment.nodes, garment.faces)
        along = np.full(count, slide)
        for contour in garment.contours:
            along[contour.vertices] = 1.0
        across = (1.0 - along)[:, None, None] * normals[:, :, None] * normals[:, None, :]
        weights = share[:, None, None] * (along[:, None, None] * np.eye(3) + across)
        return cls(garment.nodes, normals, weights)

    def value(self, nodes: np.ndarray) -> float:
        """Return L [m2] at nodes [m], shape [node_count, 3]."""
        return 0.5 * float(((nodes - self.target) * self.gradient(nodes)).sum())

    def gradient(self, nodes: np.ndarray) -> np.ndarray:
        """Return dL/dx [m], shape [node_count, 3]."""
        found: np.ndarray = np.einsum("vij,vj->vi", self.weights, nodes - self.target)
        return found

    def evaluate(self, nodes: np.ndarray) -> tuple[float, np.ndarray]:
        """Return L [m2] and dL/dx [m], shape [node_count, 3]."""
        return self.value(nodes), self.gradient(nodes)

    def curvature(self, moves: np.ndarray) -> np.ndarray:
        """Return J^T W J, shape [p, p], for the derivative J of the nodes by p parameters, shape [node_count, 3, p]."""
        weighted = np.einsum("vij,vjp->vip", self.weights, moves)
        return np.asarray(np.tensordot(moves, weighted, axes=((0, 1), (0, 1))))
