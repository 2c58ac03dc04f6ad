"""Compute the distance of two surfaces, both ways, weighted by curvature (thesis eq. 3.8, 3.9)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....garment.garment import Garment
from ....geometry.geometry import lump, mean_curvature, signed_areas
from ....geometry.surface import TriangleSurface

REFERENCE_FOLD_RADIUS = 0.025
"""Radius of a fold whose inverse is the unit of mean curvature [m]: a fold of 2.5 cm counts twice a flat place."""

MAX_RELATIVE_CURVATURE = 4.0
"""Largest curvature that counts [1 / `REFERENCE_FOLD_RADIUS`]: a weight of 5, the cap of Bongratz et al. (2022). Radii
under 6 mm are the noise of a scan and the corners of its triangles."""


@dataclass(frozen=True)
class ChamferLoss:
    """Compare a drape's surface with the target's, both ways [m2].

        L = sum_v a_v w(q_v) |x_v - q_v|^2 + sum_t b_t w_t |t - p_t|^2,    w = (1 + c kappa) / mean

    Notation: q_v closest point of the target to node x_v, w(q_v) the weight of the target's vertex nearest to it; p_t
    closest point of the drape to the target's vertex t; a `shares` and b `goal_shares`, shares of area, each sums to 1;
    w `weights`, with kappa the mean curvature's size and c `curvature`. Thesis eq. 3.9; with c = 0 eq. 3.8.

    **Deviation**: the thesis takes the closest vertices, whose distance on a mesh of 3 cm edges is mostly that of the
    meshing, and kappa itself, which vanishes on flat cloth; here closest points of the surfaces, and 1 + kappa with the
    cap of Bongratz et al. Divided by its mean, the weight leaves L a mean square in m2.

    Attributes:
        goal: The target's surface.
        weights: w of each vertex of the target, shape [vertex_count].
        goal_shares: b, shape [vertex_count].
        faces: The drape's faces, shape [face_count, 3].
        shares: a, shape [node_count].
    """

    goal: TriangleSurface
    weights: np.ndarray
    goal_shares: np.ndarray
    faces: np.ndarray
    shares: np.ndarray

    @classmethod
    def of(cls, garment: Garment, vertices: np.ndarray, faces: np.ndarray, curvature: float = 1.0) -> ChamferLoss:
        """Prepare for a garment's mesh and a target's surface; `curvature` is c, 0 for the plain distance."""
        goal = TriangleSurface(vertices, faces)
        share = goal.vertex_areas / goal.vertex_areas.sum()
        bends = np.abs(mean_curvature(goal.vertices, goal.faces))
        weights = 1.0 + curvature * np.minimum(REFERENCE_FOLD_RADIUS * bends, MAX_RELATIVE_CURVATURE)
        weights = weights / float(share @ weights)
        return cls(goal, weights, share, garment.faces, flat_shares(garment))

    def evaluate(self, nodes: np.ndarray) -> tuple[float, np.ndarray]:
        """Return L [m2] and dL/dx [m], shape [node_count, 3], at nodes [m], shape [node_count, 3].

        The gradient is exact where closest points are unique: the distance is stationary in them (envelope theorem).
        """
        found = self.goal.closest(nodes)
        offset = nodes - found.foot
        corners = self.goal.faces[found.face]
        reach = ((self.goal.vertices[corners] - found.foot[:, None]) ** 2).sum(2)
        weight = self.shares * self.weights[corners[np.arange(len(nodes)), reach.argmin(1)]]
        value = float(weight @ (offset**2).sum(1))
        gradient = 2.0 * weight[:, None] * offset
        found = TriangleSurface(nodes, self.faces).closest(self.goal.vertices)
        missing = found.foot - self.goal.vertices
        weight = self.goal_shares * self.weights
        value += float(weight @ (missing**2).sum(1))
        gradient += found.interpolation(self.faces, len(nodes)).T @ (2.0 * weight[:, None] * missing)
        return value, gradient


def flat_shares(garment: Garment) -> np.ndarray:
    """Return each node's share of the flat panels' area, shape [node_count]; sums to 1."""
    areas = np.abs(signed_areas(garment.rest))
    found: np.ndarray = lump(areas, garment.faces, len(garment.nodes)) / areas.sum()
    return found
