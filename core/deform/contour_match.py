"""Matched open contours as curves: samples by arc length on both, closest points on the other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..segment.target import Contour
from .surface import closest_on_curve

SPACING = 5e-3
"""Distance between samples along a contour [m]: a third of the garment's edges, so that no vertex is passed over."""


@dataclass(frozen=True)
class CurveRows:
    """Hold rows (1 - t) x_a + t x_b that should come to rest on fixed points.

    Attributes:
        first: Node a of each row, shape [row_count].
        second: Node b of each row, shape [row_count].
        along: Parameter t, shape [row_count].
        goal: Where the row belongs [m], shape [row_count, 3].
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
        total = 0.0
        for source, target in pairs:
            loop = np.asarray(source.vertices, dtype=np.int64)
            goal = np.ascontiguousarray(target_vertices[target.vertices])
            edge, along, _ = sample_curve(nodes[loop])
            _, _, samples = sample_curve(goal)
            length = float(np.linalg.norm(np.roll(goal, -1, axis=0) - goal, axis=1).sum())
            total += length
            self._curves.append((loop, edge, along, goal, samples, length))
        self._total = max(total, 1e-12)

    def rows(self, nodes: np.ndarray) -> CurveRows | None:
        """Find both directions' rows for the current nodes [m]; None where nothing is matched."""
        if not self._curves:
            return None
        parts: list[tuple[np.ndarray, ...]] = []
        for loop, edge, along, goal, samples, length in self._curves:
            share = length / self._total
            first, second = loop[edge], np.roll(loop, -1)[edge]
            points = nodes[first] * (1 - along)[:, None] + nodes[second] * along[:, None]
            ahead = np.roll(goal, -1, axis=0)
            segment, t = closest_on_curve(points, goal, ahead)
            foot = goal[segment] * (1 - t)[:, None] + ahead[segment] * t[:, None]
            parts.append((first, second, along, foot, np.full(len(first), share / len(first))))
            start = np.ascontiguousarray(nodes[loop])
            segment, t = closest_on_curve(samples, start, np.roll(start, -1, axis=0))
            parts.append(
                (loop[segment], np.roll(loop, -1)[segment], t, samples, np.full(len(samples), share / len(samples)))
            )
        return CurveRows(*(np.concatenate([p[k] for p in parts]) for k in range(5)))


def sample_curve(points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Sample a closed curve evenly by arc length.

    Args:
        points: Corners of the closed curve [m], shape [corner_count, 3].

    Returns:
        Edge of each sample (from its corner to the next), parameter along it, and position [m].
    """
    ahead = np.roll(points, -1, axis=0)
    length = np.linalg.norm(ahead - points, axis=1)
    end = np.cumsum(length)
    count = max(16, int(np.ceil(end[-1] / SPACING)))
    at = (np.arange(count) + 0.5) / count * end[-1]
    edge = np.minimum(np.searchsorted(end, at), len(points) - 1)
    along = np.clip(1 - (end[edge] - at) / np.maximum(length[edge], 1e-12), 0.0, 1.0)
    return edge, along, points[edge] * (1 - along)[:, None] + ahead[edge] * along[:, None]
