"""Curves of a piece as polygons, within the accuracy of cutting."""

from __future__ import annotations

import numpy as np

from ..curves import edge_length, edge_points
from ..pattern import Panel

FLATTENING_TOLERANCE = 5e-5
"""Largest distance between a curve and its polygon [m]: a tenth of the width of a pencil line."""

MAX_EDGE_SEGMENT_COUNT = 512
"""Largest number of segments of one edge, for any tolerance."""


def flatten_edge(panel: Panel, edge: int, tolerance: float = FLATTENING_TOLERANCE) -> np.ndarray:
    """Return points along an edge, ends included, uniform in arc length [m], shape [n, 2]. A chord of length h misses a
    curve of curvature k by k h^2 / 8; k is the largest turn between 64 samples."""
    if panel.edges[edge].kind == "line":
        return edge_points(panel, edge, 1)
    samples = edge_points(panel, edge, 64)
    step = np.diff(samples, axis=0)
    turn = np.abs(np.arctan2(_cross(step[:-1], step[1:]), (step[:-1] * step[1:]).sum(axis=1))).max()
    length = edge_length(panel, edge)
    curvature = 64.0 * turn / max(length, 1e-12)
    parts = int(np.ceil(length * np.sqrt(curvature / (8.0 * tolerance))))
    return edge_points(panel, edge, min(max(parts, 1), MAX_EDGE_SEGMENT_COUNT))


def flatten_outline(panel: Panel, tolerance: float = FLATTENING_TOLERANCE) -> tuple[np.ndarray, np.ndarray]:
    """Return a panel's outline as a polygon [m], shape [n, 2], and the edge of each of its sides, shape [n]."""
    parts = [flatten_edge(panel, i, tolerance)[:-1] for i in range(len(panel.edges))]
    return np.concatenate(parts), np.repeat(np.arange(len(parts)), [len(part) for part in parts])


def distance_to_line(points: np.ndarray, line: np.ndarray, is_closed: bool = True) -> np.ndarray:
    """Return the distance of points, shape [n, 2], from a polygon line, shape [k, 2] [m], shape [n]."""
    ends = np.roll(line, -1, axis=0) if is_closed else line[1:]
    starts = line if is_closed else line[:-1]
    step = ends - starts
    share = ((points[:, None] - starts) * step).sum(axis=2) / np.maximum((step**2).sum(axis=1), 1e-18)
    feet = starts + np.clip(share, 0.0, 1.0)[..., None] * step
    return np.asarray(np.linalg.norm(points[:, None] - feet, axis=2).min(axis=1))


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
