"""Cut a symmetric piece on the fold of the cloth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..curves import place_on_chord, split_edge
from ..pattern import Edge
from .pairing import MirroredGroup
from .piece import CutLine, EdgeUse, Notch, Piece, PieceEdge

MAX_FOLD_AXIS_ANGLE = np.deg2rad(0.5)
"""Largest angle between the axis of a piece and its grainline [rad]: cloth is folded along the warp."""

FOLD_AXIS_TOLERANCE = 1e-7
"""Distance to the axis [m] below which a point is on it."""


def fold_piece(piece: Piece, mirrored: MirroredGroup) -> Piece | None:
    """Return the half of a piece right of its axis, with an edge on the fold; None where it has no axis along the warp.

    Args:
        piece: The whole piece, cut once, its grainline along +y.
        mirrored: Its symmetry.
    """
    axis = find_fold_axis(mirrored)
    if axis is None:
        return None
    by_source = {edge.source: i for i, edge in enumerate(piece.edges)}
    twins = [by_source.get(ref, -1) for ref in mirrored.mirrors]
    points, edges, parts = _halve_edges(piece, twins, axis)
    middle = [(points[i] + points[(i + 1) % len(points)])[0] / 2.0 for i in range(len(points))]
    right = np.array([x > axis for x in middle])
    first = np.flatnonzero(right & ~np.roll(right, 1))
    cut = _halve_cut(piece.cut, axis)
    if len(first) != 1 or cut is None:
        return None
    chain = [(int(first[0]) + k) % len(points) for k in range(int(right.sum()))]
    half = [*chain, (chain[-1] + 1) % len(points)]
    outline = points[half]
    outline[[0, -1], 0] = axis
    refs = [parts[i] for i in chain]
    numbers = {number: k for k, (number, _, _) in enumerate(refs)}
    listed = tuple(replace(piece.edges[number], part=part, mirror=mirrored.mirrors[number]) for number, part, _ in refs)
    grain = piece.grain
    if grain[:, 0].min() < axis + 0.02:
        inside = cut.points[:, 0].max()
        grain = np.array([[0.7 * axis + 0.3 * inside, y] for y in grain[:, 1]])
    return replace(
        piece,
        net=replace(piece.net, points=outline, edges=(*[edges[i] for i in chain], Edge())),
        edges=(*listed, PieceEdge(EdgeUse.FOLD, 0.0, None)),
        fold=len(chain),
        cut=cut,
        notches=tuple(_keep_notches(piece, numbers, refs, axis)),
        darts=tuple(line for line in piece.darts if line[:, 0].min() > axis - FOLD_AXIS_TOLERANCE),
        drills=piece.drills[piece.drills[:, 0] > axis - FOLD_AXIS_TOLERANCE],
        grain=grain,
        lines=tuple(
            replace(line, points=np.maximum(line.points, [axis, -np.inf]))
            for line in piece.lines
            if line.points[:, 0].max() > axis - FOLD_AXIS_TOLERANCE
        ),
    )


def find_fold_axis(mirrored: MirroredGroup) -> float | None:
    """Return the x of the axis of a symmetric piece [m]; None where it does not lie along the warp."""
    if abs(mirrored.rotation[0, 1]) > np.sin(2.0 * MAX_FOLD_AXIS_ANGLE) or mirrored.rotation[0, 0] > 0.0:
        return None
    return float(mirrored.translation[0]) / 2.0


def _halve_edges(
    piece: Piece, mirrors: list[int], axis: float
) -> tuple[np.ndarray, list[Edge], list[tuple[int, tuple[float, float], bool]]]:
    """Return control points and edges, symmetric edges cut at the axis, and the source of each edge."""
    net = piece.net
    points, edges, parts = [], [], []
    for i, edge in enumerate(net.edges):
        points.append(net.points[i])
        if mirrors[i] != i:
            edges.append(edge)
            parts.append((i, (0.0, 1.0), False))
            continue
        at, one, two = split_edge(edge, 0.5)
        points.append(place_on_chord(at[None], net.points[i], net.points[(i + 1) % len(net.points)])[0])
        edges += [one, two]
        parts += [(i, (0.0, 0.5), True), (i, (0.5, 1.0), True)]
    return np.array(points), edges, parts


def _halve_cut(cut: CutLine, axis: float) -> CutLine | None:
    """Return the part of a cut line right of the axis, closed along it; None where it is not in one part."""
    x = cut.points[:, 0] - axis
    inside = x > FOLD_AXIS_TOLERANCE
    first = np.flatnonzero(inside & ~np.roll(inside, 1))
    if len(first) != 1:
        return None
    n = len(x)
    chain = [(int(first[0]) + k) % n for k in range(int(inside.sum()))]
    before, after = (chain[0] - 1) % n, (chain[-1] + 1) % n
    ends = [_cross(cut.points, before, chain[0], axis), _cross(cut.points, chain[-1], after, axis)]
    points = np.concatenate([ends[:1], cut.points[chain], ends[1:]])
    tags = np.concatenate([[cut.edge[before]], cut.edge[chain], [-1]])
    return CutLine(points, tags, np.concatenate([[True], cut.corner[chain], [True]]))


def _cross(points: np.ndarray, a: int, b: int, axis: float) -> np.ndarray:
    share = (axis - points[a, 0]) / (points[b, 0] - points[a, 0])
    return np.array([axis, points[a, 1] + share * (points[b, 1] - points[a, 1])])


def _keep_notches(
    piece: Piece, numbers: dict[int, int], refs: list[tuple[int, tuple[float, float], bool]], axis: float
) -> list[Notch]:
    """Return the notches right of the axis, by the new numbers of their edges."""
    found = []
    for notch in piece.notches:
        if notch.point[0] <= axis + FOLD_AXIS_TOLERANCE or notch.edge not in numbers:
            continue
        number = numbers[notch.edge]
        low, high = refs[number][1]
        found.append(replace(notch, edge=number, at=min(max((notch.at - low) / (high - low), 0.0), 1.0)))
    return found
