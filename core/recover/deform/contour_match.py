"""Match open contours as curves: samples by arc length on both, closest points on the other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...geometry.curves import ClosedCurve, CurvePoints
from ...scan.contours.target import Contour

CONTOUR_MATCH_SPACING = 5e-3
"""Distance between samples along a contour [m]: a third of the garment's edges, so that no vertex is missed."""


@dataclass(frozen=True)
class CurveRows:
    """Describe rows (1 - t) x_a + t x_b with a goal each.

    Attributes:
        first: Node a of each row, shape [row_count].
        second: Node b of each row, shape [row_count].
        along: Parameter t, shape [row_count].
        goal: Goal of each row [m], shape [row_count, 3].
        share: Weight of each row; all rows of both directions sum to 2, shape [row_count].
    """

    first: np.ndarray
    second: np.ndarray
    along: np.ndarray
    goal: np.ndarray
    share: np.ndarray


class ContourMatch:
    """Match closed source curves with closed target curves in both directions."""

    def __init__(
        self, pairs: tuple[tuple[Contour, Contour], ...], nodes: np.ndarray, target_vertices: np.ndarray
    ) -> None:
        self._curves = []
        for source, target in pairs:
            loop = np.asarray(source.vertices, dtype=np.int64)
            goal = ClosedCurve(target_vertices[target.vertices])
            self._curves.append((loop, sample_curve(ClosedCurve(nodes[loop])), goal, sample_curve(goal).foot))
        self._total = max(sum(goal.length for _, _, goal, _ in self._curves), 1e-12)

    def rows(self, nodes: np.ndarray) -> CurveRows | None:
        """Return both directions' rows for the current nodes [m]; None where nothing is matched."""
        if not self._curves:
            return None
        parts: list[tuple[np.ndarray, ...]] = []
        for loop, at, goal, samples in self._curves:
            share = goal.length / self._total
            ahead = np.roll(loop, -1)
            first, second = loop[at.segment], ahead[at.segment]
            points = nodes[first] * (1 - at.along)[:, None] + nodes[second] * at.along[:, None]
            parts.append((first, second, at.along, goal.closest(points).foot, np.full(len(first), share / len(first))))
            closest = ClosedCurve(nodes[loop]).closest(samples)
            weight = np.full(len(samples), share / len(samples))
            parts.append((loop[closest.segment], ahead[closest.segment], closest.along, samples, weight))
        return CurveRows(*(np.concatenate([p[k] for p in parts]) for k in range(5)))


def sample_curve(curve: ClosedCurve) -> CurvePoints:
    """Sample a closed curve [m] evenly by arc length, half a spacing from its first corner."""
    count = max(16, int(np.ceil(curve.arc[-1] / CONTOUR_MATCH_SPACING)))
    return curve.locate((np.arange(count) + 0.5) / count * curve.arc[-1])
