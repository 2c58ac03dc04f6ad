"""Compute the distance of open contours from their counterparts, by name (second term of thesis eq. 3.7)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....garment.garment import Garment
from ....scan.contours.target import Contour, Target

CONTOUR_LOSS_SPACING = 5e-3
"""Distance between samples of a target's contour [m]: a fraction of the edges of any mesh that is fitted to it."""


@dataclass(frozen=True)
class ContourLoss:
    """Compare each open contour with the target's of the same name [m2].

        L = sum_c l_c / (2 l) (mean_s |p_s - s|^2 + mean_v |x_v - q_v|^2)

    Notation: s samples of the target's contour c, p_s the closest point of our curve to each; q_v the closest
    sample to node x_v of our curve; l_c the target contour's length, l that of all. Only trusted pairs count.

    Attributes:
        contours: Ours.
        goals: Samples of each counterpart [m], shape [sample_count, 3] each.
        lengths: l_c [m].
    """

    contours: tuple[Contour, ...]
    goals: tuple[np.ndarray, ...]
    lengths: tuple[float, ...]

    @classmethod
    def of(cls, garment: Garment, target: Target) -> ContourLoss:
        """Pair a garment's named contours with the target's."""
        contours, goals, lengths = [], [], []
        for contour in garment.contours:
            other = target.contour(contour.name)
            if other is not None and other.trusted:
                goal = other.curve(target.vertices)
                contours.append(contour)
                goals.append(goal.resample(max(16, int(np.ceil(goal.length / CONTOUR_LOSS_SPACING)))))
                lengths.append(goal.length)
        return cls(tuple(contours), tuple(goals), tuple(lengths))

    def evaluate(self, nodes: np.ndarray) -> tuple[float, np.ndarray]:
        """Return L [m2] and dL/dx [m], shape [node_count, 3]; exact where closest points are unique."""
        value, gradient = 0.0, np.zeros_like(nodes)
        for contour, goal, length in zip(self.contours, self.goals, self.lengths, strict=True):
            loop, weight = contour.vertices, length / (2.0 * sum(self.lengths))
            closest = contour.curve(nodes).closest(goal)
            a, b, along = loop[closest.segment], np.roll(loop, -1)[closest.segment], closest.along
            missing = closest.foot - goal
            share = weight / len(goal)
            value += share * float((missing**2).sum())
            np.add.at(gradient, a, 2.0 * share * (1.0 - along)[:, None] * missing)
            np.add.at(gradient, b, 2.0 * share * along[:, None] * missing)
            offset = nodes[loop][:, None] - goal[None]
            nearest = (offset**2).sum(2).argmin(1)
            offset = offset[np.arange(len(loop)), nearest]
            share = weight / len(loop)
            value += share * float((offset**2).sum())
            np.add.at(gradient, loop, 2.0 * share * offset)
        return value, gradient
