"""Production pieces: from a pattern of net panels to what is cut out of cloth."""

from .allowance import DEFAULT_ALLOWANCES, Allowances, read_allowances
from .errors import AllowanceBad, PieceBad
from .flatten import FLATTENING_TOLERANCE, flatten_edge, flatten_outline
from .layout import CLOTH_WIDTH, Copy, Lay, lay_on_cloth
from .make import PieceSettings, Style, make_pieces
from .nesting import nest_on_cloth
from .numbers import CutNumbers, PieceNumbers, describe_pieces, measure_pieces
from .piece import (
    SEWN_EDGE_USES,
    TURNED_UP_EDGE_USES,
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
from .shelves import pack_on_shelves

__all__ = [
    "CLOTH_WIDTH",
    "DEFAULT_ALLOWANCES",
    "FLATTENING_TOLERANCE",
    "SEWN_EDGE_USES",
    "TURNED_UP_EDGE_USES",
    "AllowanceBad",
    "Allowances",
    "Copy",
    "CutLine",
    "CutNumbers",
    "EdgeUse",
    "Lay",
    "Notch",
    "NotchPurpose",
    "PanelPlace",
    "Piece",
    "PieceBad",
    "PieceEdge",
    "PieceNumbers",
    "PieceSet",
    "PieceSettings",
    "PieceSide",
    "SeamWalk",
    "Style",
    "describe_pieces",
    "flatten_edge",
    "flatten_outline",
    "lay_on_cloth",
    "make_pieces",
    "measure_pieces",
    "nest_on_cloth",
    "pack_on_shelves",
    "read_allowances",
]
