"""Compute the distance of a drape's nodes from the target's faces, along their normals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from garmentq.core.garment.garment import Garment
from garmentq.core.geometry.surface import TriangleSurface
from garmentq.core.recover.fit.losses.chamfer import flat_shares


@dataclass(frozen=True)
class PlaneLoss:
    """Compare nodes with the planes of the target's nearest faces [m2].

        L = sum_v a_v (n_v . (x_v - q_v))^2
    q_v closest point of the target, n_v the normal of its face, a `shares` of area, which sum to 1. Sliding within the
    surface has no cost, so that Gauss-Newton converges faster than on distances to points. Nodes whose closest point is
    on an open edge do not count: the target ends there.

    Attributes:
        goal: The target's surface.
        shares: a, shape [node_count].
    """

    goal: TriangleSurface
    shares: np.ndarray

    @classmethod
    def of(cls, garment: Garment, vertices: np.ndarray, faces: np.ndarray) -> PlaneLoss:
        """Prepare for a garment's mesh and a target's surface."""
        return cls(TriangleSurface(vertices, faces), flat_shares(garment))

    def evaluate(self, nodes: np.ndarray) -> tuple[float, np.ndarray]:
        """Return L [m2] and dL/dx [m], shape [node_count, 3]; exact where the nearest face stays the same."""
        found = self.goal.closest(nodes)
        normal = self.goal.face_normals[found.face]
        inside = ~self.goal.border_faces[found.face]
        height = np.where(inside, (normal * (nodes - found.foot)).sum(1), 0.0)
        return float(self.shares @ height**2), (2.0 * self.shares * height)[:, None] * normal
