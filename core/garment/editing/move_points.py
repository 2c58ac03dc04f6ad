"""Move control points; their mirror images and the points sewn to them follow."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from ..pattern import EdgeRef, Pattern
from ..seams import find_sewn_partners
from .partners import Corner, check_number, find_panel, mirror_corners, restore_seam_lengths


def move_points(
    pattern: Pattern,
    points: Collection[Corner],
    by: np.ndarray,
    keep_symmetry: bool = True,
    keep_seams: bool = True,
) -> Pattern:
    """Return a pattern with control points moved. Each given point moves by exactly `by`, its mirror image by the
    mirrored motion, a point on its panel's axis along the axis. The point sewn to a moved one moves as far along the
    seam. The remaining difference of seam lengths is removed by moving all other points as little as possible
    (`equalise_seams`).

    Args:
        pattern: The pattern.
        points: Panel and number of each control point.
        by: The motion in the panels' axes [m], shape [2].
        keep_symmetry: Move mirror images too.
        keep_seams: Make the seams equal; False leaves them as the move makes them.

    Raises:
        EditBad: where a point does not exist.
    """
    for name, number in points:
        check_number(find_panel(pattern, name), number)
    moves = {corner: np.asarray(by, float) for corner in points}
    if keep_symmetry:
        moves |= _mirror_moves(pattern, moves)
    fixed = set(moves)
    if keep_seams:
        moves |= {corner: way for corner, way in _sewn_moves(pattern, moves).items() if corner not in moves}
    places = pattern.points.copy()
    for (name, number), move in moves.items():
        places[pattern.first_points[name] + number] += move
    return restore_seam_lengths(pattern.with_points(places), pattern, fixed, keep_symmetry, keep_seams)


def _mirror_moves(pattern: Pattern, moves: dict[Corner, np.ndarray]) -> dict[Corner, np.ndarray]:
    """Return the moves of mirror images, and of points on an axis along it; a given point keeps its own move."""
    images, found = mirror_corners(pattern), {}
    for corner, move in moves.items():
        for image, matrix in images.get(corner, []):
            if image == corner:
                found[corner] = (move + matrix @ move) / 2.0
            elif image not in moves:
                found[image] = matrix @ move
    return found


def _sewn_moves(pattern: Pattern, moves: dict[Corner, np.ndarray]) -> dict[Corner, np.ndarray]:
    """Return the moves, along their seams, of the points that moved ones are sewn to."""
    sewn, found = find_sewn_partners(pattern), {}
    for (name, number), move in moves.items():
        count = len(pattern.panel(name).points)
        for edge, is_start in (((number - 1) % count, False), (number, True)):
            other = sewn.get(EdgeRef(name, edge))
            if other is None:
                continue
            other_count = len(pattern.panel(other.panel).points)
            partner = (other.panel, (other.edge + 1) % other_count if is_start else other.edge)
            along = float(move @ _direction(pattern, EdgeRef(name, edge)))
            found[partner] = -along * _direction(pattern, other)
    return found


def _direction(pattern: Pattern, ref: EdgeRef) -> np.ndarray:
    """Return the unit vector from an edge's first control point to its second."""
    start, end = pattern.ends_of(ref)
    chord = pattern.points[end] - pattern.points[start]
    return np.asarray(chord / np.linalg.norm(chord))
