"""Production pieces to be cut out of cloth, with allowance, notches and seams, without a file format."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from ..pattern import EdgeRef, Panel
from .finished_points import FinishedMeasure


class EdgeUse(StrEnum):
    """Describe the use of an edge of a piece; the names are those of an allowance table."""

    SEAM = "seam"
    GATHERED = "gathered"
    DART = "dart"
    NECK = "neck"
    ARMHOLE = "armhole"
    CUFF = "cuff"
    HEM = "hem"
    LEG = "leg"
    WAIST = "waist"
    FRONT = "front"
    ZIP = "zip"
    BUTTONS = "buttons"
    VENT = "vent"
    PLACKET = "placket"
    WRAP = "wrap"
    FACED = "faced"
    OPEN = "open"
    FOLD = "fold"


CLOSURE_EDGE_USES = (EdgeUse.ZIP, EdgeUse.BUTTONS)
"""Uses of edges, at the centre front or of a cuff, that are closed when the garment has been put on."""

SEWN_EDGE_USES = (EdgeUse.SEAM, EdgeUse.GATHERED, *CLOSURE_EDGE_USES)
"""Uses of edges that are joined to another piece, or to another edge of their own."""

TURNED_UP_EDGE_USES = (EdgeUse.CUFF, EdgeUse.HEM, EdgeUse.LEG, EdgeUse.WAIST)
"""Uses of edges whose allowance is turned up along them and so has to cover the cloth below it."""


class Material(StrEnum):
    """Describe what a piece is cut out of."""

    CLOTH = "cloth"
    RIB = "rib"
    INTERFACING = "interfacing"


class NotchPurpose(StrEnum):
    """Describe what a notch marks."""

    MATCH = "match"
    GATHER = "gather"
    JUNCTION = "junction"
    DART = "dart"
    HEM = "hem"
    SLIT = "slit"


@dataclass(frozen=True)
class PieceEdge:
    """Describe an edge of a piece and its source in the pattern.

    Attributes:
        width: Seam allowance [m].
        source: The pattern's edge that it is, or a part of; None for a fold.
        part: Fractions of the source's length at which it begins and ends.
        mirror: The pattern's edge of which the mirrored copy (of a pair) or the other half (of a fold) is a mirror
            image, reversed; None where there is no copy.
    """

    use: EdgeUse
    width: float
    source: EdgeRef | None
    part: tuple[float, float] = (0.0, 1.0)
    mirror: EdgeRef | None = None


@dataclass(frozen=True)
class PanelPlace:
    """Describe the placement of a panel of the pattern in a piece: piece = panel @ rotation.T + translation.

    Attributes:
        rotation: Orthogonal, shape [2, 2]; its determinant is -1 for a panel of the mirrored copy.
        translation: Shape [2] [m].
        misfit: Largest distance between the panel, so placed, and the piece [m]; 0 except for a mirrored copy.
    """

    panel: str
    rotation: np.ndarray
    translation: np.ndarray
    misfit: float = 0.0


@dataclass(frozen=True)
class Notch:
    """Describe a notch of a piece's edge.

    Attributes:
        edge: Index of the edge in the piece; of two that meet at the notch, the first.
        at: Fraction of that edge's length.
        purpose: What it marks.
        count: 1, or 2 for the back.
        sew: Its place on the sew line [m], shape [2].
        point: Its place on the cut line, a vertex of it [m], shape [2].
        inward: Unit vector into the cloth, shape [2].
        depth: Depth of the cut [m], less than the allowance.
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
class MarkedLine:
    """Describe a line that is marked on a piece by its name, `CF` or `waist`: points [m], shape [n, 2]."""

    name: str
    points: np.ndarray


@dataclass(frozen=True)
class CutLine:
    """Describe the cut line of a piece: a closed polygon, counter-clockwise.

    Attributes:
        points: Vertices [m], shape [n, 2]; the first is not repeated.
        edge: Of each side, from vertex i to vertex i + 1: the piece's edge that it is parallel to, or -1 beside a
            corner, shape [n].
        corner: Whether the outline turns at a vertex, shape [n]; the others sample a curve or have a notch.
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
        places: Placement of its panels, and of those of its mirrored copy.
        quantity: How often it is cut.
        pair: True where half of them are cut mirrored.
        fold: Index of the edge on the fold of the cloth, or None.
        cut: Its cut line.
        darts: Sew lines of darts within the cut line, and other lines that are marked, not cut [m], shape [n, 2] each.
        drills: Points that are marked within it, tips of darts [m], shape [n, 2].
        grain: Both ends of the line to be drawn along the warp [m], shape [2, 2].
        is_grain_known: False where the line only stands for the panel's own +y.
        material: What it is cut out of.
        interfaced: How many copies are also cut out of interfacing.
        is_bias: True where the warp runs at 45 degrees to the piece's +y.
        lines: Centre front and back, and the levels of bust, waist and hips.
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
    is_grain_known: bool = True
    material: Material = Material.CLOTH
    interfaced: int = 0
    is_bias: bool = False
    lines: tuple[MarkedLine, ...] = ()


@dataclass(frozen=True)
class PieceSide:
    """Describe one edge of a piece; `mirrored`: of the mirrored copy, or of the half below the fold."""

    piece: int
    edge: int
    mirrored: bool


@dataclass(frozen=True)
class SeamWalk:
    """Describe one seam as it is sewn.

    Attributes:
        name: That of its step, as a tailor says it: `shoulder seam`; no two steps have one name.
        step: Its number in the sewing order, from 1; mirrored seams, left and right, have one step.
        sides: The edges of each side, in order from the seam's start to its end.
        lengths: Length of each side on the sew line [m].
        gathered: True where one side is longer by intent.
        is_paired: True where its step has one like it on the other side of the wearer.
    """

    name: str
    step: int
    sides: tuple[tuple[PieceSide, ...], tuple[PieceSide, ...]]
    lengths: tuple[float, float]
    gathered: bool
    is_paired: bool = False


@dataclass(frozen=True)
class TruedLine:
    """Describe a line at the end of a seam, and what trueing did there.

    Attributes:
        line: Name of the line: its contour or label, or the panel that it is sewn to.
        seam: Name of the seam that it crosses: its label, or its panels.
        corner: The angle between both parts of the line before [rad], 0 where it is smooth; positive: it points out.
        move: Largest distance that the line moved near the seam, or would have moved [m]; infinite where no curve of
            the same length is smooth.
        tolerance: Largest distance that it may move [m].
        is_trued: Whether it was made smooth.
    """

    line: str
    seam: str
    corner: float
    move: float
    tolerance: float
    is_trued: bool


@dataclass(frozen=True)
class PieceSet:
    """Describe all pieces of a garment.

    Attributes:
        name: Name of the style, for display.
        size: The size by girths, or an empty text.
        fabric: Name of the cloth, or an empty text.
        pieces: The pieces, bodies first.
        seams: The seams, in the order in which they are sewn.
        missing: What a wearable garment needs beside net panels, one line each.
        trued: Each line that was not smooth where it crosses a seam.
        is_stretchy: Whether the cloth stretches as a knit does.
        drafted: Pieces that finish edges and are no panels of the pattern: ribs, facings, bindings, linings.
        finishes: The seams that sew on these, and inner layers; their pieces are numbered as in `cut_pieces`.
        details: Lines of the title, label and value: the scan's name, the date, measures of the finished garment.
        finished_measures: Measures of the finished garment at the points of the trade.
        margins: How sure the recovered pattern's seams and edges are, a line each.
    """

    name: str
    size: str
    fabric: str
    pieces: tuple[Piece, ...]
    seams: tuple[SeamWalk, ...]
    missing: tuple[str, ...]
    trued: tuple[TruedLine, ...] = ()
    is_stretchy: bool = False
    drafted: tuple[Piece, ...] = ()
    finishes: tuple[SeamWalk, ...] = ()
    details: tuple[tuple[str, str], ...] = ()
    finished_measures: tuple[FinishedMeasure, ...] = ()
    margins: tuple[str, ...] = ()

    @property
    def cut_pieces(self) -> tuple[Piece, ...]:
        """Return all that is cut: the pieces of the pattern's panels, then those that finish edges."""
        return (*self.pieces, *self.drafted)
