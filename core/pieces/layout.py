"""Lay pieces on cloth, and say how much of it they need."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..pattern import polygon_area
from .piece import Piece

CLOTH_WIDTH = 1.40
"""The usual usable width of cloth [m]."""

CLOTH_GAP = 0.01
"""Free space between pieces on cloth [m]: room for the blade."""


@dataclass(frozen=True)
class Lay:
    """Describe how much cloth the pieces of a garment need, laid side by side along the warp.

    Attributes:
        width: Usable width of the cloth [m].
        length: Length that is used [m]; infinite where a piece is wider than the cloth.
        used: Share of the cloth that ends up in pieces.
    """

    width: float
    length: float
    used: float


def lay_on_cloth(pieces: tuple[Piece, ...], width: float = CLOTH_WIDTH) -> Lay:
    """Return the cloth that all copies of pieces need, folded ones opened, all with their grainline along the cloth.

    A shelf layout of bounding boxes, smaller pieces stacked beside taller ones: what a cutter betters by hand.
    """
    sizes, area = [], 0.0
    for piece in pieces:
        opened = 2.0 if piece.fold is not None else 1.0
        sizes += [np.ptp(piece.cut.points, axis=0) * [opened, 1.0]] * piece.quantity
        area += opened * piece.quantity * polygon_area(piece.cut.points)
    if not sizes or max(size[0] for size in sizes) > width:
        return Lay(width, float("inf"), 0.0)
    corners = stack_up(np.array(sizes), CLOTH_GAP, width)
    length = float((corners[:, 1] + np.array(sizes)[:, 1]).max())
    return Lay(width, length, area / (length * width))


def stack_up(sizes: np.ndarray, gap: float, width: float) -> np.ndarray:
    """Put boxes on shelves, tallest first, each upon a lower one of its shelf where there is room for it.

    Args:
        sizes: Width and height of each box [m], shape [n, 2]; none is wider than `width`.
        gap: Free space between boxes [m].
        width: Where a shelf ends [m].

    Returns:
        Lower left corner of each box [m], shape [n, 2]; the first shelf stands on y = 0.
    """
    corners = np.zeros((len(sizes), 2))
    columns: list[list[float]] = []  # x, width, y of the next box, top of the shelf
    bottom = top = right = 0.0
    for i in sorted(range(len(sizes)), key=lambda i: (-float(sizes[i, 1]), -float(sizes[i, 0]), i)):
        wide, tall = float(sizes[i, 0]), float(sizes[i, 1])
        room = [c for c in columns if wide <= c[1] + 1e-9 and c[2] + tall <= c[3] + 1e-9]
        if room:
            column = room[0]
            corners[i] = column[0], column[2]
            column[2] += tall + gap
            continue
        if not columns or right + wide > width + 1e-9:
            bottom, right = top, 0.0
            top = bottom + tall + gap
        corners[i] = right, bottom
        columns.append([right, wide, bottom + tall + gap, top - gap])
        right += wide + gap
    return corners
