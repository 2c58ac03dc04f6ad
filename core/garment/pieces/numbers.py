"""Numbers of production pieces, for tables and reports."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ...run.errors import BadInput
from ...run.units import MM_PER_M
from ..curves import edge_length
from ..pattern import Pattern
from ..polygon import polygon_area
from .layout import lay_on_cloth
from .make import PieceSettings, make_pieces
from .piece import Piece, PieceSet


@dataclass(frozen=True)
class PieceNumbers:
    """Describe the numbers of one piece.

    Attributes:
        quantity: How often it is cut.
        is_pair: True where half of them are cut mirrored.
        is_folded: True where it is cut on the fold.
        perimeter: Length of the sew line of one opened piece [m].
        area: Area within its cut line, opened [m2].
        cloth: Area of all copies [m2].
        notches: Number of notches that are drawn.
    """

    name: str
    quantity: int
    is_pair: bool
    is_folded: bool
    perimeter: float
    area: float
    cloth: float
    notches: int


@dataclass(frozen=True)
class CutNumbers:
    """Describe the pieces of a pattern: the numbers of each, and the garment's metrics by dotted name."""

    pieces: tuple[PieceNumbers, ...] = ()
    metrics: Mapping[str, float | None] = field(default_factory=dict)


def measure_pieces(pattern: Pattern) -> CutNumbers:
    """Return the numbers of a pattern's pieces with the usual allowances; none where no pieces can be cut of it."""
    try:
        return CutNumbers(*describe_pieces(make_pieces(pattern, PieceSettings(is_finished=False))))
    except BadInput:
        return CutNumbers()


def describe_pieces(pieces: PieceSet) -> tuple[tuple[PieceNumbers, ...], dict[str, float | None]]:
    """Return the numbers of each piece of the pattern's panels, and those of the garment by dotted name; pieces that
    finish edges are not counted."""
    found = tuple(_measure(piece) for piece in pieces.pieces)
    lay = lay_on_cloth(pieces.pieces)
    return found, {
        "pieces.count": float(sum(one.quantity for one in found)),
        "pieces.drawn": float(len(found)),
        "pieces.area_m2": sum(one.cloth for one in found),
        "pieces.cloth_length_m": lay.length,
        "pieces.cloth_used": lay.used,
        **{f"finished.{one.point}_mm": MM_PER_M * one.value for one in pieces.finished_measures},
    }


def _measure(piece: Piece) -> PieceNumbers:
    opened = 1.0 if piece.fold is None else 2.0
    sides = [edge_length(piece.net, i) for i in range(len(piece.edges)) if i != piece.fold]
    area = opened * polygon_area(piece.cut.points)
    return PieceNumbers(
        name=piece.name,
        quantity=piece.quantity,
        is_pair=piece.pair,
        is_folded=piece.fold is not None,
        perimeter=opened * sum(sides),
        area=area,
        cloth=piece.quantity * area,
        notches=len(piece.notches),
    )
