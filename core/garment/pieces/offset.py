"""Compute the cut line: offset every edge by its allowance, join the corners, remove loops."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...run.errors import keep_printable
from ..pattern import Panel
from ..polygon import polygon_area
from .corners import Side, join_corner
from .errors import PieceBad
from .flatten import flatten_edge, flatten_outline
from .loops import remove_loops
from .piece import CutLine, PieceEdge

CUT_VERTEX_MERGE_DISTANCE = 5e-6
"""Distance up to which two vertices of a cut line are one [m]: half of the smallest difference in a file of hundredths
of a millimetre."""

Span = tuple[int, int]
"""First and last edge of a dart, counted on from the first past the number of edges."""


@dataclass(frozen=True)
class Offset:
    """Describe a cut line, and the ends of the folds of turned-up edges: the edge, the point on the cut line [m], the
    unit vector along the fold into the cloth."""

    cut: CutLine
    folds: tuple[tuple[int, np.ndarray, np.ndarray], ...]


def offset_outline(net: Panel, edges: tuple[PieceEdge, ...], mouths: Mapping[Span, np.ndarray]) -> Offset:
    """Return the cut line of a piece: at its allowance from each edge, and from the mouth of each dart or slit.

    Args:
        net: The piece.
        edges: What each edge is.
        mouths: The edge across the mouth of each dart [m], shape [n, 2], from its first edge's start.

    Raises:
        PieceBad: where the loop that remains is smaller than the net piece.
    """
    sides = _list_sides(net, edges, mouths)
    lines = [side.offset() for side in sides]
    between, folds = [], []
    for k, side in enumerate(sides):
        other = (k + 1) % len(sides)
        corner = join_corner(side, sides[other], lines[k], lines[other])
        lines[k], lines[other] = corner.before, corner.after
        between.append(corner.between)
        if corner.fold is not None:
            folds.append((side.edge, *corner.fold))
    cut = _close(sides, lines, between)
    if polygon_area(cut.points) < polygon_area(flatten_outline(net)[0]) * (1.0 - 1e-6):
        raise PieceBad(f"the piece of panel '{keep_printable(net.name[:40])}' cannot be cut: {PieceBad().message}")
    return Offset(cut, tuple(folds))


def _list_sides(net: Panel, edges: tuple[PieceEdge, ...], mouths: Mapping[Span, np.ndarray]) -> list[Side]:
    """Return the edges to be offset, each dart replaced by its mouth, in order of the outline."""
    count = len(edges)
    inside = {k % count: span for span in mouths for k in range(span[0], span[1] + 1)}
    sides = []
    for i, edge in enumerate(edges):
        if i not in inside:
            sides.append(Side(i, flatten_edge(net, i), edge.width, edge.use))
        elif inside[i][0] % count == i:
            mouth = mouths[inside[i]]
            before = edges[(inside[i][0] - 1) % count]
            if np.linalg.norm(mouth[-1] - mouth[0]) > CUT_VERTEX_MERGE_DISTANCE:
                sides.append(Side(i, mouth, before.width, before.use))
    return sides


def _close(sides: list[Side], lines: list[np.ndarray], between: list[np.ndarray]) -> CutLine:
    """Return the closed cut line of offset edges and the points between them."""
    points, tags, corner = [], [], []
    for side, line, more in zip(sides, lines, between, strict=True):
        points += [line, more]
        tags += [np.full(len(line) - 1, side.edge), np.full(len(more) + 1, -1)]
        for part in (line, more):
            flags = np.zeros(len(part), dtype=bool)
            flags[:1] = flags[-1:] = True
            corner.append(flags)
    whole = _merge(np.concatenate(points), np.concatenate(tags), np.concatenate(corner))
    corners, kept, origin = remove_loops(whole.points, whole.edge)
    return _merge(corners, kept, np.where(origin < 0, True, whole.corner[origin]))


def _merge(points: np.ndarray, tags: np.ndarray, corner: np.ndarray) -> CutLine:
    """Return a closed line without coincident vertices, each with the tag of the last of those merged."""
    keep = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1) > CUT_VERTEX_MERGE_DISTANCE
    if not keep.any():
        return CutLine(points, tags, corner)
    number = np.concatenate([[0], np.cumsum(keep)[:-1]]) % int(keep.sum())
    merged = np.zeros(int(keep.sum()), dtype=bool)
    np.logical_or.at(merged, number, corner)
    return CutLine(points[keep], tags[keep], merged)
