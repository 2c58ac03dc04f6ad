"""Pack boxes side by side on shelves."""

from __future__ import annotations

import numpy as np


def pack_on_shelves(sizes: np.ndarray, gap: float, width: float, stacked: bool = False) -> np.ndarray:
    """Put boxes on shelves, tallest first, without overlap.

    Args:
        sizes: Width and height of each box [m], shape [n, 2].
        gap: Free space between boxes [m].
        width: Length of a shelf [m]; a wider box has a shelf of its own.
        stacked: True to put a box upon a lower and wider one of its shelf where there is room for it.

    Returns:
        Lower left corner of each box [m], shape [n, 2]; the first shelf is at y = 0.
    """
    corners = np.zeros((len(sizes), 2))
    columns: list[list[float]] = []  # width, x, y of the next box, top of the shelf
    bottom = top = right = 0.0
    order = np.lexsort((np.arange(len(sizes)), -np.round(sizes[:, 0], 6), -np.round(sizes[:, 1], 6)))
    for i in order:  # sizes rounded to 1 um, so that mirrored boxes, equal up to rounding, keep their order
        wide, tall = float(sizes[i, 0]), float(sizes[i, 1])
        room = [one for one in columns if wide <= one[0] + 1e-9 and one[2] + tall <= one[3] + 1e-9] if stacked else []
        if room:
            corners[i] = room[0][1:3]
            room[0][2] += tall + gap
            continue
        if not columns or right + wide > width + 1e-9:
            bottom, right = top, 0.0
            top = bottom + tall + gap
        corners[i] = right, bottom
        columns.append([wide, right, bottom + tall + gap, top - gap])
        right += wide + gap
    return corners
