"""Match open contours as curves: samples by arc length on both, closest points on the other."""

from __future__ import annotations

import numpy as np

from ...geometry.curves import Curve, CurvePoints
from ...scan.contours.target import Contour
from .data_terms import PointRows

CONTOUR_MATCH_SPACING = 5e-3
"""Distance between samples along a contour [m]: a third of the garment's edges, so that no vertex is missed."""


class ContourMatch:
    """Match source curves with target curves in both directions."""

    def __init__(
        self, pairs: tuple[tuple[Contour, Contour], ...], nodes: np.ndarray, target_vertices: np.ndarray
    ) -> None:
        self._curves = []
        for source, target in pairs:
            goal = target.curve(target_vertices)
            self._curves.append((source, sample_curve(source.curve(nodes)), goal, sample_curve(goal).foot))
        self._total = max(sum(goal.length for _, _, goal, _ in self._curves), 1e-12)

    def rows(self, nodes: np.ndarray) -> PointRows | None:
        """Return rows (1 - t) x_a + t x_b of both directions for the current nodes [m], whose weights sum to 2; None
        where nothing is matched."""
        if not self._curves:
            return None
        parts: list[tuple[np.ndarray, ...]] = []
        for source, at, goal, samples in self._curves:
            loop = np.asarray(source.vertices, dtype=np.int64)
            share, ahead = goal.length / self._total, np.roll(loop, -1)
            points = nodes[loop[at.segment]] * (1 - at.along)[:, None] + nodes[ahead[at.segment]] * at.along[:, None]
            on_loop = source.curve(nodes).closest(samples)
            for on, goals in ((at, goal.closest(points).foot), (on_loop, samples)):
                pair = np.stack([loop[on.segment], ahead[on.segment]], axis=1)
                weight = np.full(len(pair), share / len(pair))
                parts.append((pair, np.stack([1 - on.along, on.along], axis=1), goals, weight))
        return PointRows(*(np.concatenate([part[k] for part in parts]) for k in range(4)))


def sample_curve(curve: Curve) -> CurvePoints:
    """Sample a curve [m] evenly by arc length, half a spacing from its first corner."""
    count = max(16, int(np.ceil(curve.arc[-1] / CONTOUR_MATCH_SPACING)))
    return curve.locate((np.arange(count) + 0.5) / count * curve.arc[-1])
