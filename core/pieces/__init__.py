"""Production pieces: from a pattern of net panels to what is cut out of cloth."""

from .allowance import WIDTHS, Allowances, read_allowances
from .errors import AllowanceBad, PieceBad
from .flatten import TOLERANCE, flatten_edge, flatten_outline
from .make import PieceSettings, Style, make_pieces
from .piece import (
    SEWN,
    TURNED,
    CutLine,
    EdgeUse,
    Notch,
    NotchPurpose,
    PanelPlace,
    Piece,
    PieceEdge,
    PieceSet,
    PieceSide,
    SeamWalk,
)

__all__ = [
    "SEWN",
    "TOLERANCE",
    "TURNED",
    "WIDTHS",
    "AllowanceBad",
    "Allowances",
    "CutLine",
    "EdgeUse",
    "Notch",
    "NotchPurpose",
    "PanelPlace",
    "Piece",
    "PieceBad",
    "PieceEdge",
    "PieceSet",
    "PieceSettings",
    "PieceSide",
    "SeamWalk",
    "Style",
    "flatten_edge",
    "flatten_outline",
    "make_pieces",
    "read_allowances",
]
