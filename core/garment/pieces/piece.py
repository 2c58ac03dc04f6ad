"""Production pieces: what is cut out of cloth, with allowance, notches and the seams that join it; no file format."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from ..pattern import EdgeRef, Panel


class EdgeUse(StrEnum):
    """Describe what becomes of an edge of a piece; the names are those of an allowance table."""

    SEAM = "seam"
    GATHERED = "gathered"
    DART = "dart"
    NECK = "neck"
    ARMHOLE = "armhole"
    CUFF = "cuff"
    HEM = "hem"
    LEG = "leg"
    WAIST = "waist"
    OPEN = "open"
    FOLD = "fold"


SEWN_EDGE_USES = (EdgeUse.SEAM, EdgeUse.GATHERED)
"""Edges that are sewn to another piece, or to another edge of their own."""

TURNED_UP_EDGE_USES = (EdgeUse.CUFF, EdgeUse.HEM, EdgeUse.LEG, EdgeUse.WAIST)
"""Edges whose allowance is turned up along them: it must cover the cloth that it lies on."""


class NotchPurpose(StrEnum):
    """Describe what a notch marks."""

    MATCH = "match"
    GATHER = "gather"
    JUNCTION = "junction"
    DART = "dart"
    HEM = "hem"


@dataclass(frozen=True)
class PieceEdge:
    """Describe what an edge of a piece is in the pattern.

    Attributes:
        use: What becomes of it.
        width: Seam allowance [m].
        source: The pattern's edge that it is, or a part of; None for a fold.
        part: Fractions of the source's length at which it begins and ends.
        twin: The pattern's edge of which the mirrored copy (of a pair) or the other half (of a fold) is a mirror image,
            run the other way; None where there is no copy.
    """

    use: EdgeUse
    width: float
    source: EdgeRef | None
    part: tuple[float, float] = (0.0, 1.0)
    twin: EdgeRef | None = None


@dataclass(frozen=True)
class PanelPlace:
    """Describe where a panel of the pattern lies in a piece: piece = panel @ rotation.T + translation.

    Attributes:
        panel: Name of the panel.
        rotation: Orthogonal, shape [2, 2]; its determinant is -1 for a panel of the mirrored copy.
        translation: Shape [2] [m].
        misfit: Largest distance between the panel, so placed, and the piece [m]; 0 but for a mirrored copy.
    """

    panel: str
    rotation: np.ndarray
    translation: np.ndarray
    misfit: float = 0.0


@dataclass(frozen=True)
class Notch:
    """Mark a place of a piece's edge.

    Attributes:
        edge: Index of the edge in the piece; of two that meet at the notch, the first.
        at: Fraction of that edge's length.
        purpose: What it marks.
        count: 1, or 2 for the back.
        sew: Its place on the sew line [m], shape [2].
        point: Its place on the cut line, a vertex of it [m], shape [2].
        inward: Unit vector into the cloth, shape [2].
        depth: How deep it is cut [m], less than the allowance.
    """

    edge: int
    at: float
    purpose: NotchPurpose
    count: int
    sew: np.ndarray
    point: np.ndarray
    inward: np.ndarray
    depth: float


@dataclass(frozen=True)
class CutLine:
    """Describe where a piece is cut: a closed polygon, counter-clockwise.

    Attributes:
        points: Vertices [m], shape [n, 2]; the last is not the first again.
        edge: Of each side, from vertex i to vertex i + 1: the piece's edge that it is parallel to, or -1 beside a
            corner, shape [n].
        corner: Whether the outline turns at a vertex, shape [n]; the others sample a curve or carry a notch.
    """

    points: np.ndarray
    edge: np.ndarray
    corner: np.ndarray


@dataclass(frozen=True)
class Piece:
    """Describe one piece of cloth, ready to be cut.

    Attributes:
        name: Upper case letters, digits, `_` and `-` only, at most 20, unique.
        net: The sew line: control points, edges and grainline (+y) of the piece as a panel, counter-clockwise, seen
            from the cloth's outside [m].
        edges: What each edge of `net` is.
        places: The panels that lie in it, and those of its mirrored copy.
        quantity: How often it is cut.
        pair: True where half of them are cut mirrored.
        fold: Index of the edge that lies on the fold of the cloth, or None.
        cut: Where it is cut.
        notches: Its notches.
        darts: Sew lines of darts within the cut line, and other lines that are marked, not cut [m], shape [n, 2] each.
        drills: Points that are marked within it, tips of darts [m], shape [n, 2].
        grain: Both ends of the line to be drawn along the warp [m], shape [2, 2].
    """

    name: str
    net: Panel
    edges: tuple[PieceEdge, ...]
    places: tuple[PanelPlace, ...]
    quantity: int
    pair: bool
    fold: int | None
    cut: CutLine
    notches: tuple[Notch, ...]
    darts: tuple[np.ndarray, ...]
    drills: np.ndarray
    grain: np.ndarray


@dataclass(frozen=True)
class PieceSide:
    """Point at one edge of a piece; `mirrored` where it is that of the mirrored copy, or of the half below the fold."""

    piece: int
    edge: int
    mirrored: bool


@dataclass(frozen=True)
class SeamWalk:
    """Describe one seam as it is sewn.

    Attributes:
        name: What the seam is called.
        step: Where it stands in the sewing order, from 1; seams of one step are sewn alike, left and right.
        sides: The edges of each side, in the order in which they are met from the seam's start to its end.
        lengths: Length of each side on the sew line [m].
        gathered: True where the first or second side is longer by intent.
    """

    name: str
    step: int
    sides: tuple[tuple[PieceSide, ...], tuple[PieceSide, ...]]
    lengths: tuple[float, float]
    gathered: bool


@dataclass(frozen=True)
class PieceSet:
    """Describe all pieces of a garment.

    Attributes:
        name: What the style is called, for people.
        size: The size by girths, or an empty text.
        fabric: Name of the cloth, or an empty text.
        pieces: The pieces, bodies first.
        seams: The seams, in the order in which they are sewn.
        missing: What a wearable garment needs and no pattern of net panels knows, a line each.
    """

    name: str
    size: str
    fabric: str
    pieces: tuple[Piece, ...]
    seams: tuple[SeamWalk, ...]
    missing: tuple[str, ...]

    @property
    def panel_count(self) -> int:
        """Return how many pieces of cloth there are, copies counted."""
        return sum(piece.quantity for piece in self.pieces)
