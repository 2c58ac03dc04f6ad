"""Place notches on the cut line."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from ..curves import edge_length, edge_points
from ..pattern import Panel
from .darts import Span
from .marks import Mark
from .offset import Offset
from .piece import SEWN_EDGE_USES, CutLine, EdgeUse, Notch, NotchPurpose, PieceEdge

NOTCH_DEPTH = 0.006
"""Depth of a notch where the allowance has room for it [m]: a quarter of an inch, as of a notcher's punch."""

BARE_DEPTH = 0.003
"""Depth of a notch into a piece without an allowance [m]: it must disappear in the seam."""

DOUBLE_NOTCH_SPACING = 0.006
"""Distance of the two cuts of a double notch [m]."""

MIN_NOTCH_SPACING = 0.015
"""Smallest distance of a notch from another one, or from the end of its edge [m]: one and a half usual allowances. A
nearer one is left out: the cloth between them would fray away, and nobody could tell them apart. The two cuts of a
double notch count as one."""

MAX_RUN_TURN_ANGLE = np.deg2rad(45.0)
"""Largest turn at which two sewn edges are one run, with a notch where they meet [rad]; a larger turn is a corner."""

NOTCH_VERTEX_TOLERANCE = 3e-4
"""Distance to a vertex of the cut line [m] below which a notch is at it."""


@dataclass(frozen=True)
class _Place:
    """Describe a notch before its place on the cut line is known: edge, fraction, purpose, count, sew point, inward
    direction."""

    edge: int
    at: float
    purpose: NotchPurpose
    count: int
    sew: np.ndarray
    inward: np.ndarray


def place_notches(
    net: Panel,
    edges: tuple[PieceEdge, ...],
    marks: list[tuple[Mark, ...]],
    offset: Offset,
    darts: tuple[Span, ...],
    passed: Collection[int] = (),
) -> tuple[CutLine, tuple[Notch, ...]]:
    """Return the cut line with a vertex at every notch, and the notches.

    Args:
        net: The piece.
        edges: What each edge is.
        marks: The marks of each edge.
        offset: Its cut line, and where hems fold.
        darts: Its darts, and slits within it; each gets a notch at either end of its mouth.
        passed: Control points within one run of gathers, which get no notch of their own.
    """
    count = len(edges)
    inner = {k % count for first, last in darts for k in range(first, last + 1)}
    places = _vertex_notches(net, edges, inner, passed)
    for first, last in darts:
        ends = ((first - 1) % count, 1.0), ((last + 1) % count, 0.0)
        purpose = NotchPurpose.DART if edges[first % count].use is EdgeUse.DART else NotchPurpose.SLIT
        places += [_place(net, edge, at, Mark(at, purpose, 1), 0.0) for edge, at in ends]
    for i in range(count):
        if i not in inner:
            kept = [end for end, k in ((0.0, i), (1.0, (i + 1) % count)) if k not in passed]
            places += _edge_notches(net, i, marks[i], kept)
    cut, notches = offset.cut, []
    for place in places:
        cut, found = _project_on_cut_line(cut, place, edges[place.edge].width)
        notches += found
    for edge, point, along in offset.folds:
        cut, at = _insert(cut, point)
        corners = net.points[[edge, (edge + 1) % count]]
        end = int(np.linalg.norm(corners - point, axis=1).argmin())
        corner = corners[end]
        width = float(np.linalg.norm(corner - at))
        notches.append(Notch(edge, float(end), NotchPurpose.HEM, 1, corner, at, along, _depth(width)))
    return cut, tuple(notches)


def _vertex_notches(net: Panel, edges: tuple[PieceEdge, ...], inner: set[int], passed: Collection[int]) -> list[_Place]:
    """Return the notches at control points, without those that follow another one too closely."""
    places: list[_Place] = []
    starts = np.cumsum([0.0, *(edge_length(net, i) for i in range(len(edges)))])
    kept: list[float] = []
    for i in range(len(edges)):
        place = None if i in inner or i in passed else _vertex_notch(net, edges, i, inner)
        around = [abs(starts[i] - other) for other in kept]
        if place is not None and all(min(gap, starts[-1] - gap) >= MIN_NOTCH_SPACING for gap in around):
            places.append(place)
            kept.append(starts[i])
    return places


def _vertex_notch(net: Panel, edges: tuple[PieceEdge, ...], i: int, inner: set[int]) -> _Place | None:
    """Return the notch at the start of edge i where a sewn run continues through it, or ends at a vent."""
    before = (i - 1) % len(edges)
    uses = {edges[before].use, edges[i].use}
    if before in inner or not uses <= {*SEWN_EDGE_USES, EdgeUse.VENT} or uses == {EdgeUse.VENT}:
        return None
    a, b = _tangent(net, before, 1.0), _tangent(net, i, 0.0)
    if abs(np.arctan2(a[0] * b[1] - a[1] * b[0], a @ b)) > MAX_RUN_TURN_ANGLE:
        return None
    middle = a + b
    inward = np.array([-middle[1], middle[0]]) / np.linalg.norm(middle)
    purpose = NotchPurpose.SLIT if EdgeUse.VENT in uses else NotchPurpose.JUNCTION
    return _Place(before, 1.0, purpose, 1, net.points[i], inward)


def _edge_notches(net: Panel, edge: int, marks: tuple[Mark, ...], ends: list[float]) -> list[_Place]:
    """Return the notches within an edge that are far enough from some of its ends and from each other."""
    length = edge_length(net, edge)
    taken = [end * length for end in ends]
    found = []
    for mark in marks:
        shifts = (-DOUBLE_NOTCH_SPACING / 2, DOUBLE_NOTCH_SPACING / 2) if mark.count == 2 else (0.0,)
        if (
            min((abs(mark.at * length - other) for other in taken), default=np.inf)
            < MIN_NOTCH_SPACING + DOUBLE_NOTCH_SPACING / 2
        ):
            continue
        taken.append(mark.at * length)
        found += [_place(net, edge, mark.at, mark, shift) for shift in shifts]
    return found


def _place(net: Panel, edge: int, at: float, mark: Mark, shift: float) -> _Place:
    length = edge_length(net, edge)
    moved = min(max(at + shift / length, 0.0), 1.0)
    along = _tangent(net, edge, moved)
    sew = edge_at(net, edge, moved)
    return _Place(edge, moved, mark.purpose, mark.count, sew, np.array([-along[1], along[0]]))


def edge_at(net: Panel, edge: int, at: float) -> np.ndarray:
    """Return the point of an edge at a fraction of its length [m], shape [2]."""
    cell = 1.0 / 1024
    whole = edge_points(net, edge, 1024)
    k = min(int(at / cell), 1023)
    share = at / cell - k
    return np.asarray(whole[k] + share * (whole[k + 1] - whole[k]))


def _tangent(net: Panel, edge: int, at: float) -> np.ndarray:
    points = edge_points(net, edge, 1024)
    k = min(int(at * 1024), 1023)
    along = points[k + 1] - points[k]
    return np.asarray(along / np.linalg.norm(along))


def _project_on_cut_line(cut: CutLine, place: _Place, width: float) -> tuple[CutLine, list[Notch]]:
    """Return the cut line with a vertex straight outside a sew point, and the notch there, if it is outside."""
    out = -place.inward
    step = np.roll(cut.points, -1, axis=0) - cut.points
    apart = cut.points - place.sew
    cross = out[0] * step[:, 1] - out[1] * step[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = (apart[:, 0] * step[:, 1] - apart[:, 1] * step[:, 0]) / cross
        share = (apart[:, 0] * out[1] - apart[:, 1] * out[0]) / cross
    hit = np.flatnonzero((distance > -1e-7) & (share >= -1e-9) & (share <= 1.0 + 1e-9))
    if not len(hit):
        return cut, []
    side = hit[np.argmin(distance[hit])]
    cut, at = _insert(cut, cut.points[side] + np.clip(share[side], 0.0, 1.0) * step[side])
    inward = place.sew - at
    size = float(np.linalg.norm(inward))
    inward = inward / size if size > NOTCH_VERTEX_TOLERANCE else place.inward
    return cut, [Notch(place.edge, place.at, place.purpose, place.count, place.sew, at, inward, _depth(width))]


def _depth(width: float) -> float:
    return min(NOTCH_DEPTH, width / 2.0) if width > 0.0 else BARE_DEPTH


def _insert(cut: CutLine, point: np.ndarray) -> tuple[CutLine, np.ndarray]:
    """Return the cut line with a vertex at a point on it, and that vertex."""
    gap = np.linalg.norm(cut.points - point, axis=1)
    nearest = int(gap.argmin())
    if gap[nearest] < NOTCH_VERTEX_TOLERANCE:
        return cut, cut.points[nearest]
    step = np.roll(cut.points, -1, axis=0) - cut.points
    share = np.clip(((point - cut.points) * step).sum(axis=1) / (step**2).sum(axis=1), 0.0, 1.0)
    side = int(np.linalg.norm(cut.points + share[:, None] * step - point, axis=1).argmin())
    return (
        CutLine(
            np.insert(cut.points, side + 1, point, axis=0),
            np.insert(cut.edge, side + 1, cut.edge[side]),
            np.insert(cut.corner, side + 1, False),
        ),
        point,
    )
