"""Arrange all pieces of a garment side by side on one large sheet."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...garment.pieces.piece import PieceSet
from ...garment.pieces.shelf_packing import pack_on_shelves
from .drawing import Line, Text, draw_lines, list_texts
from .text_places import SheetJoins, label_piece

SHEET_PIECE_GAP = 0.01
"""Free space between pieces [m]."""

SHEET_BORDER = 0.002
"""Free space around all pieces [m]: a line stays clear of the frame; paper has a margin of its own."""


@dataclass(frozen=True)
class Sheet:
    """Describe the places of the pieces on a sheet.

    Attributes:
        pieces: The pieces.
        shifts: Translation of each piece from its own axes to the sheet's [m], shape [n, 2].
        size: Width and height of the sheet [m], shape [2]; its origin is at the lower left.
        lines, texts: Drawing of each piece, in the sheet's axes.
    """

    pieces: PieceSet
    shifts: np.ndarray
    size: np.ndarray
    lines: tuple[tuple[Line, ...], ...]
    texts: tuple[tuple[Text, ...], ...]

    @property
    def outlines(self) -> list[np.ndarray]:
        """Return each piece's cut line on the sheet [m]."""
        return [piece.cut.points + shift for piece, shift in zip(self.pieces.cut_pieces, self.shifts, strict=True)]


def min_sheet_width(pieces: PieceSet) -> float:
    """Return the smallest width of a sheet [m]."""
    return max(float(np.ptp(piece.cut.points[:, 0])) for piece in pieces.cut_pieces) + 2.0 * SHEET_BORDER


def arrange_pieces(pieces: PieceSet, width: float, joins: SheetJoins | None = None) -> Sheet:
    """Arrange the pieces, each once, side by side on a sheet of a width [m], or of that of the widest piece; their
    texts are clear of the joins of sheets of paper where they have room."""
    joins = joins or SheetJoins()
    shifts, size = pack_pieces(pieces, width)
    lines = tuple(
        tuple(replace(line, points=line.points + shift) for line in draw_lines(piece))
        for piece, shift in zip(pieces.cut_pieces, shifts, strict=True)
    )
    texts = tuple(
        tuple(
            replace(text, centre=text.centre + shift)
            for text in label_piece(piece, list_texts(pieces, n), joins.shift(shift))
        )
        for n, (piece, shift) in enumerate(zip(pieces.cut_pieces, shifts, strict=True))
    )
    return Sheet(pieces, shifts, size, lines, texts)


def pack_pieces(pieces: PieceSet, width: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the translation of each piece to its place on a sheet [m], shape [n, 2], and the sheet's size [m]."""
    low = np.array([piece.cut.points.min(axis=0) for piece in pieces.cut_pieces])
    sizes = np.array([piece.cut.points.max(axis=0) for piece in pieces.cut_pieces]) - low
    corners = (
        pack_on_shelves(sizes, SHEET_PIECE_GAP, max(width, min_sheet_width(pieces)) - 2.0 * SHEET_BORDER, stacked=True)
        + SHEET_BORDER
    )
    return corners - low, (corners + sizes).max(axis=0) + SHEET_BORDER
