"""Place the line that is drawn along the warp of a piece."""

from __future__ import annotations

import numpy as np

from ..meshing import points_in_polygon
from ..pattern import Panel
from .flatten import flatten_outline


def draw_grain(net: Panel) -> np.ndarray:
    """Return the line to be drawn along the warp [m], shape [2, 2]: four fifths of an upright line, at most 0.4 m. Of
    upright lines nearly as long as the longest, the one nearest to a third of the width is taken, away from the texts
    in the middle."""
    outline = flatten_outline(net)[0]
    low, high = outline.min(axis=0), outline.max(axis=0)
    ys = np.linspace(low[1], high[1], 202)[1:-1]
    found = [(0.0, outline.mean(axis=0), outline.mean(axis=0))]
    for x in np.linspace(low[0], high[0], 21)[1:-1]:
        inside = points_in_polygon(outline, np.stack([np.full(200, x), ys], axis=1))
        edges = np.flatnonzero(np.diff(np.concatenate([[False], inside, [False]]).astype(int)))
        found += [
            (float(ys[b - 1] - ys[a]), np.array([x, ys[a]]), np.array([x, ys[b - 1]])) for a, b in edges.reshape(-1, 2)
        ]
    longest = max(length for length, _, _ in found)
    third = low[0] + (high[0] - low[0]) / 3.0
    long = [one for one in found if one[0] >= 0.85 * longest]
    length, start, end = min(long, key=lambda one: (abs(float(one[1][0]) - third), float(one[1][1])))
    middle, half = (start + end) / 2.0, min(0.4 * length, 0.2)
    return np.array([middle - [0.0, half], middle + [0.0, half]])
