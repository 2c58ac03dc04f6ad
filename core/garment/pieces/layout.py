"""Lay out pieces on cloth, and compute how much cloth they need."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...geometry.rigid import plane_rotation
from ..polygon import polygon_area
from .piece import Material, Piece
from .shelf_packing import pack_on_shelves

CLOTH_WIDTH = 1.40
"""Usual usable width of cloth [m]."""

CLOTH_GAP = 0.01
"""Free space between pieces on cloth [m]: room for the blade."""

BIAS_ANGLE = np.deg2rad(45.0)
"""Angle between the warp and a piece cut on the bias [rad]."""

FOLD_LINE_TOLERANCE = 1e-9
"""Distance to the fold [m] below which a point is on it: folding sets them exactly there."""


@dataclass(frozen=True)
class Copy:
    """Describe one copy of a piece as it is cut, a folded one opened: the piece's name, and the cut line,
    counter-clockwise, the warp along y [m], shape [n, 2]."""

    name: str
    outline: np.ndarray


@dataclass(frozen=True)
class Lay:
    """Describe how much cloth the pieces of a garment need.

    Attributes:
        width: Usable width of the cloth [m].
        length: Length that is used [m]; infinite where a piece is wider than the cloth.
        used: Share of the used cloth that is in pieces.
        copies: Each at its position: x across the cloth, y along it; empty where a piece is wider.
    """

    width: float
    length: float
    used: float
    copies: tuple[Copy, ...] = ()

    @classmethod
    def of(cls, copies: tuple[Copy, ...], width: float) -> Lay:
        """Return the lay of copies on cloth from y = 0."""
        length = max(float(copy.outline[:, 1].max()) for copy in copies)
        area = sum(polygon_area(copy.outline) for copy in copies)
        return cls(width, length, area / (length * width), copies)


def lay_on_cloth(pieces: tuple[Piece, ...], width: float = CLOTH_WIDTH) -> Lay:
    """Return the cloth that all copies of its pieces need, folded ones opened, all with their grainline along it. A
    shelf layout of bounding boxes, smaller pieces stacked beside taller ones; a cutter finds a shorter one by hand."""
    copies = list_copies(pieces)
    sizes = np.array([np.ptp(copy.outline, axis=0) for copy in copies]).reshape(-1, 2)
    if not copies or sizes[:, 0].max() > width:
        return Lay(width, float("inf"), 0.0)
    corners = pack_on_shelves(sizes, CLOTH_GAP, width, stacked=True)
    laid = [
        Copy(copy.name, copy.outline - copy.outline.min(axis=0) + corner)
        for copy, corner in zip(copies, corners, strict=True)
    ]
    return Lay.of(tuple(laid), width)


def list_copies(pieces: tuple[Piece, ...]) -> list[Copy]:
    """Return the copies of pieces of cloth: half of a pair's mirrored, folded ones opened."""
    found = []
    for piece in pieces:
        if piece.material is not Material.CLOTH:
            continue
        outline = piece.cut.points if piece.fold is None else _unfold(piece)
        outline = outline @ plane_rotation(BIAS_ANGLE).T if piece.is_bias else outline
        mirrored = (outline * [-1.0, 1.0])[::-1]
        for number in range(piece.quantity):
            found.append(Copy(piece.name, mirrored if piece.pair and number % 2 else outline))
    return found


def _unfold(piece: Piece) -> np.ndarray:
    """Return the cut line of both halves of a folded piece."""
    half, axis = piece.cut.points, float(piece.cut.points[:, 0].min())
    on = half[:, 0] < axis + FOLD_LINE_TOLERANCE
    first = np.flatnonzero(on & ~np.roll(on, 1))  # the fold is the left side of the right half, downwards
    half = np.roll(half, -int(first[0]) - int(on.sum()) + 1, axis=0)[: len(half) - int(on.sum()) + 2]
    return np.concatenate([half, (half[1:-1] * [-1.0, 1.0] + [2.0 * axis, 0.0])[::-1]])
