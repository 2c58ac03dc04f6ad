"""Compute the inequality of the two sides of the seams (thesis eq. 3.10)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....garment.garment import Garment
from ....garment.pattern import Pattern
from ....garment.seams import seam_lengths, seam_ratios, seam_sides


@dataclass(frozen=True)
class SeamLoss:
    """Compare the lengths of both sides of every seam [m2].

        L = sum_s sum_j (|e_j| - r_s |e'_j|)^2 = sum_s (l_s - r_s l'_s)^2 / n_s
    Thesis eq. 3.10 over the n_s mesh edges of each seam s; all edges of one side are equally long, and an edge follows
    the chord of its control points (eq. 3.1), which makes the second form exact. r_s is 1, and for a gathered seam a
    parameter: its ratio in the template, times exp of the fitted value.

    Attributes:
        starts, ends: Control point at which each side begins and ends, shape [seam_count, 2].
        factors: Length over chord of each side, shape [seam_count, 2].
        ratios: r at first, shape [seam_count].
        gathered: Which seams have a free ratio, shape [seam_count].
        counts: n, shape [seam_count].
    """

    starts: np.ndarray
    ends: np.ndarray
    factors: np.ndarray
    ratios: np.ndarray
    gathered: np.ndarray
    counts: np.ndarray

    @classmethod
    def of(cls, garment: Garment, base: Pattern) -> SeamLoss:
        """Prepare for a meshed pattern; `base` gives the ratios of gathered seams."""
        pattern = garment.pattern
        starts, ends, _ = seam_sides(pattern)
        points = pattern.points
        factors = seam_lengths(pattern) / np.linalg.norm(points[ends] - points[starts], axis=-1)
        counts = np.array([len(garment.edge_uv[seam.a]) - 1 for seam in pattern.seams])
        return cls(starts, ends, factors, seam_ratios(base), pattern.gathered, counts)

    def best_ratios(self, points: np.ndarray) -> np.ndarray:
        """Return the logarithms, for `evaluate`, at which the gathered seams' loss is zero, [gathered_count]."""
        sides = self.factors * np.linalg.norm(points[self.ends] - points[self.starts], axis=-1)
        return np.asarray(np.log(sides[:, 0] / (self.ratios * sides[:, 1]))[self.gathered])

    def evaluate(
        self, points: np.ndarray, ratio_logs: np.ndarray | None = None
    ) -> tuple[float, np.ndarray, np.ndarray]:
        """Return L [m2], dL/dc [m], shape [point_count, 2], and dL/d(logarithms of the gathered ratios) [m2].

        Args:
            points: All control points [m], shape [point_count, 2].
            ratio_logs: ln of each gathered seam's ratio over the template's, shape [gathered_count]; None for zeros.
        """
        ratios = self.ratios.copy()
        if ratio_logs is not None:
            ratios[self.gathered] *= np.exp(ratio_logs)
        chords = points[self.ends] - points[self.starts]
        lengths = np.linalg.norm(chords, axis=-1)
        sides = self.factors * lengths
        missing = sides[:, 0] - ratios * sides[:, 1]
        pull = 2.0 * missing / self.counts
        along = chords / lengths[..., None] * self.factors[..., None]
        gradient = np.zeros_like(points)
        for side, sign in ((0, np.ones_like(ratios)), (1, -ratios)):
            slope = (pull * sign)[:, None] * along[:, side]
            np.add.at(gradient, self.ends[:, side], slope)
            np.add.at(gradient, self.starts[:, side], -slope)
        by_ratio = -(pull * ratios * sides[:, 1])[self.gathered]
        return float((missing**2 / self.counts).sum()), gradient, by_ratio
