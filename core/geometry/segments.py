"""Compiled search for the closest segment of a polyline."""

from __future__ import annotations

import numpy as np

from ..run.kernels import kernel


@kernel()
def closest_segments(points: np.ndarray, start: np.ndarray, end: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Find the segment from start[j] to end[j] closest to each point, the first of equal ones, and the parameter on it.

    Args:
        points: Positions [m], shape [n, d].
        start: First end of each segment [m], shape [segment_count, d].
        end: The other, shape [segment_count, d].
    """
    count, dimension = points.shape
    segment = np.zeros(count, np.int64)
    along = np.zeros(count)
    for i in range(count):
        best = np.inf
        for j in range(start.shape[0]):
            length = 0.0
            dot = 0.0
            for k in range(dimension):
                d = end[j, k] - start[j, k]
                length += d * d
                dot += d * (points[i, k] - start[j, k])
            t = min(max(dot / max(length, 1e-30), 0.0), 1.0)
            distance = 0.0
            for k in range(dimension):
                r = points[i, k] - (start[j, k] + t * (end[j, k] - start[j, k]))
                distance += r * r
            if distance < best:
                best = distance
                segment[i] = j
                along[i] = t
    return segment, along
