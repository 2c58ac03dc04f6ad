"""Draft straight strips that finish edges: ribs, bindings, casings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..parts.collars import NECK_RIB_WIDTH
from ..parts.ribs import RIB_RATIO
from ..pattern import Edge, Panel
from .piece import EdgeUse, Material, PieceEdge

BINDING_CUT_WIDTH = 0.04
"""Width of a double-folded binding as it is cut [m]: four times the 1 cm that is seen."""

HOOD_CASING_WIDTH = 0.03
"""Width of the casing of a hood's drawstring [m]: for a cord of 1 cm and the stitches."""


@dataclass(frozen=True)
class Strip:
    """Describe a strip before it is cut.

    Attributes:
        name: Of the piece.
        uses: Uses of the edges that it finishes.
        length: On the sew line [m].
        width: Between its long edges [m].
        material: What it is cut out of.
        allowance: Seam allowance of its edges [m]; a binding has none at its long ones.
        is_folded: Whether it is folded along its middle.
        is_bias: Whether it is cut at 45 degrees to the warp.
    """

    name: str
    uses: tuple[EdgeUse, ...]
    length: float
    width: float
    material: Material
    allowance: float
    is_folded: bool
    is_bias: bool


def plan_rib(name: str, uses: tuple[EdgeUse, ...], edge: float, allowance: float) -> Strip:
    """Return the rib of an edge of a length [m], shorter than it by `RIB_RATIO`, and folded along its middle."""
    return Strip(name, uses, RIB_RATIO * edge, 2.0 * NECK_RIB_WIDTH, Material.RIB, allowance, True, False)


def plan_binding(name: str, uses: tuple[EdgeUse, ...], edge: float, allowance: float) -> Strip:
    """Return the bias binding of an edge of a length [m], with an allowance at its ends alone."""
    return Strip(name, uses, edge, BINDING_CUT_WIDTH, Material.CLOTH, allowance, True, True)


def draw_strip(strip: Strip) -> tuple[Panel, tuple[PieceEdge, ...], tuple[np.ndarray, ...]]:
    """Return the outline of a strip, its long edges level, what its edges are, and the fold along its middle [m]."""
    right, high = strip.length, strip.width
    corners = np.array([[0.0, 0.0], [right, 0.0], [right, high], [0.0, high]])
    long = 0.0 if strip.is_bias else strip.allowance
    edges = tuple(PieceEdge(EdgeUse.SEAM, width, None) for width in (long, strip.allowance, long, strip.allowance))
    fold = (np.array([[0.0, high / 2.0], [right, high / 2.0]]),) if strip.is_folded else ()
    return Panel(strip.name, corners, (Edge(),) * 4), edges, fold
