"""Draft facings: strips in the shape of an edge, sewn along it and turned in (W. Aldrich, Metric Pattern Cutting for
Women's Wear, facings)."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from ..curves import place_on_chord, relative_to_chord, split_edge
from ..meshing import points_in_polygon
from ..pattern import Edge, Panel
from .flatten import distance_to_line, flatten_edge, flatten_outline
from .notches import edge_at
from .piece import EdgeUse, Piece, PieceEdge

MAX_FACING_SHARE = 0.6
"""Largest share of the edge beside an opening, such as a shoulder, that a facing covers; the rest is free."""

FACING_CURVE_TOLERANCE = 5e-4
"""Largest distance of a facing's inner edge from the line at its depth [m]: that edge is sewn to nothing."""

MAX_ARC_STEP = np.deg2rad(5.0)
"""Largest turn between two points of an arc round a corner [rad]: 0.05 mm off at 5 cm."""

INNER_EDGE_STEP = 0.005
"""Largest distance between points of a straight inner edge [m], so that its ends are at the sides."""

SIDE_SAMPLE_COUNT = 256
"""Number of places along a side at which its distance from an edge is looked up."""


def draft_facing(piece: Piece, run: tuple[int, ...], depth: float) -> tuple[Panel, tuple[PieceEdge, ...]] | None:
    """Return the outline of a facing of consecutive edges of a piece, in the piece's axes, and what its edges are: the
    faced ones first, then the side after them, the inner edge, and the side before them. The inner edge is at its depth
    from the faced ones; where the side beside is short, at `MAX_FACING_SHARE` of it. None where no facing fits.

    Args:
        piece: The piece.
        run: Indices of the edges, in order.
        depth: Width of the facing [m].
    """
    net, count = piece.net, len(piece.edges)
    before, after = (run[0] - 1) % count, (run[-1] + 1) % count
    if len(run) > count - 2 or EdgeUse.DART in (piece.edges[before].use, piece.edges[after].use):
        return None
    faced = _join([flatten_edge(net, i) for i in run])
    sides = [_sample_edge(net, after), _sample_edge(net, before)[::-1]]
    lengths = [float(np.linalg.norm(np.diff(side, axis=0), axis=1).sum()) for side in sides]
    depth = min(depth, *(MAX_FACING_SHARE * length for length in lengths))
    shares = [_find_share(faced, side, depth) for side in sides]
    inner = _offset_inwards(net, faced, depth)
    if None in shares or len(inner) < 2:
        return None
    (at_end, at_start) = (float(share or 0.0) for share in shares)
    last, first = edge_at(net, after, at_end), edge_at(net, before, 1.0 - at_start)
    curve = _fit_curve(np.concatenate([last[None], inner[::-1], first[None]]))
    points = [*(net.points[i] for i in run), net.points[after], last, *(end for end, _ in curve)]
    edges = [
        *(net.edges[i] for i in run),
        split_edge(net.edges[after], at_end)[1],
        *(edge for _, edge in curve),
        split_edge(net.edges[before], 1.0 - at_start)[2],
    ]
    uses = [
        *(replace(piece.edges[i], source=None, mirror=None, part=(0.0, 1.0)) for i in run),
        _side_of(piece.edges[after]),
        *(PieceEdge(EdgeUse.OPEN, 0.0, None) for _ in curve),
        _side_of(piece.edges[before]),
    ]
    return replace(net, points=np.array(points), edges=tuple(map(_plain, edges)), notches=()), tuple(uses)


def _plain(edge: Edge) -> Edge:
    return replace(edge, label="", contour="")


def _side_of(edge: PieceEdge) -> PieceEdge:
    """Return what the side of a facing is: sewn as the piece's own, or on its fold."""
    return PieceEdge(edge.use, edge.width, None)


def _sample_edge(net: Panel, edge: int) -> np.ndarray:
    """Return points along an edge at even fractions of its length [m], shape [n, 2]."""
    return np.array([edge_at(net, edge, at) for at in np.linspace(0.0, 1.0, SIDE_SAMPLE_COUNT + 1)])


def _join(lines: list[np.ndarray]) -> np.ndarray:
    return np.concatenate([lines[0], *(line[1:] for line in lines[1:])])


def _find_share(faced: np.ndarray, side: np.ndarray, depth: float) -> float | None:
    """Return the fraction of a side, from a faced edge on, at which it is as far from the edge as the depth."""
    distance = distance_to_line(side, faced, is_closed=False)
    beyond = np.flatnonzero(distance >= depth)
    return None if not len(beyond) else float(beyond[0]) / SIDE_SAMPLE_COUNT


def _offset_inwards(net: Panel, faced: np.ndarray, depth: float) -> np.ndarray:
    """Return the points within a piece at a depth from a line of its outline, in the line's order [m], shape [n, 2]."""
    parts = int(np.ceil(float(np.linalg.norm(np.diff(faced, axis=0), axis=1).max()) / INNER_EDGE_STEP))
    shares = np.arange(parts)[:, None] / parts
    dense = [start + shares * (end - start) for start, end in pairwise(faced)]
    faced = np.concatenate([*dense, faced[-1:]])
    step = np.diff(faced, axis=0)
    angles = np.unwrap(np.arctan2(step[:, 0], -step[:, 1]))  # of the normals into the piece
    found = []
    for k, angle in enumerate(angles):
        found.append((faced[k] + faced[k + 1]) / 2.0 + depth * _direction(np.array([angle])))
        if k + 1 < len(angles):
            turn = angles[k + 1] - angle
            parts = max(int(np.ceil(abs(turn) / MAX_ARC_STEP)), 1)
            found.append(faced[k + 1] + depth * _direction(angle + turn * np.arange(parts + 1) / parts))
    points = np.concatenate(found)
    outline = flatten_outline(net)[0]
    keep = distance_to_line(points, faced, is_closed=False) > depth - 1e-5
    return np.asarray(points[keep & points_in_polygon(outline, points)])


def _direction(angles: np.ndarray) -> np.ndarray:
    return np.stack([np.cos(angles), np.sin(angles)], axis=-1)


def _fit_curve(points: np.ndarray) -> list[tuple[np.ndarray, Edge]]:
    """Return cubics through the ends of a line of points, each its end [m] and its edge, by least squares; in halves
    where one is farther off than `FACING_CURVE_TOLERANCE`."""
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    at = np.concatenate([[0.0], np.cumsum(lengths)]) / max(float(lengths.sum()), 1e-12)
    basis = np.stack([(1 - at) ** 3, 3 * at * (1 - at) ** 2, 3 * at**2 * (1 - at), at**3], axis=1)
    rest = points - basis[:, [0, 3]] @ points[[0, -1]]
    handles = np.linalg.lstsq(basis[:, 1:3], rest, rcond=None)[0] if len(points) > 3 else points[[0, -1]]
    drawn = basis @ np.concatenate([points[:1], handles, points[-1:]])
    if len(points) > 8 and float(distance_to_line(points, drawn, is_closed=False).max()) > FACING_CURVE_TOLERANCE:
        middle = len(points) // 2
        return [*_fit_curve(points[: middle + 1]), *_fit_curve(points[middle:])]
    relative = relative_to_chord(handles, points[0], points[-1])
    straight = float(np.abs(place_on_chord(relative, points[0], points[-1]) - handles).max()) > 1e-6
    return [(points[-1], Edge("line") if straight or len(points) <= 3 else Edge("cubic", relative))]
