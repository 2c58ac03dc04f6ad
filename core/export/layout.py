"""Lay flat pieces side by side."""

from __future__ import annotations

import numpy as np


def lay_out(sizes: np.ndarray, gap: float, width: float) -> np.ndarray:
    """Put boxes on shelves, tallest first, so that none overlaps another.

    Args:
        sizes: Width and height of each box [m], shape [n, 2].
        gap: Free space between boxes [m].
        width: Where a shelf ends [m]; a box wider than that has a shelf of its own.

    Returns:
        Lower left corner of each box [m], shape [n, 2]; the first shelf stands on y = 0.
    """
    corners = np.zeros((len(sizes), 2))
    order = sorted(range(len(sizes)), key=lambda i: (-float(sizes[i, 1]), i))
    x = y = shelf = 0.0
    for i in order:
        if x > 0.0 and x + sizes[i, 0] > width:
            x, y, shelf = 0.0, y + shelf + gap, 0.0
        corners[i] = x, y
        x += float(sizes[i, 0]) + gap
        shelf = max(shelf, float(sizes[i, 1]))
    return corners
