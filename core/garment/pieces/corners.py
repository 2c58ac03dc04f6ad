"""Corners of a cut line, where the allowances of two edges meet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...geometry.geometry import unit
from .piece import TURNED_UP_EDGE_USES, EdgeUse

MITRE_LIMIT = 3.0
"""Largest length of a mitre [allowances]; a longer one, at a corner sharper than about 40 degrees, is cut off."""

MAX_STRAIGHT_TURN_ANGLE = 1e-3
"""Turn between two sides below which they are straight [rad]: 0.1 mm on 10 cm."""

MIN_FOLD_SIDE_COSINE = np.cos(np.deg2rad(70.0))
"""Smallest cosine between a side and the normal of a hem's fold (70 degrees). A side at a larger angle is not mirrored
at the fold, because the hem would end in a narrow spike."""


@dataclass(frozen=True)
class Side:
    """Describe one edge before its offset.

    Attributes:
        edge: Its index in the piece.
        sew: The edge itself, flattened [m], shape [n, 2].
        width: Its allowance [m].
    """

    edge: int
    sew: np.ndarray
    width: float
    use: EdgeUse

    @property
    def first(self) -> np.ndarray:
        """Return the unit tangent at its beginning, shape [2]."""
        return unit(self.sew[1] - self.sew[0])

    @property
    def last(self) -> np.ndarray:
        """Return the unit tangent at its end, shape [2]."""
        return unit(self.sew[-1] - self.sew[-2])

    def offset(self) -> np.ndarray:
        """Return it moved outwards (to the right) by its allowance [m], shape [n, 2]. A vertex moves along the bisector
        of its sides' normals by width / cos(half the turn), so that every side stays parallel at the allowance's
        distance."""
        tangents = np.diff(self.sew, axis=0)
        tangents = tangents / np.linalg.norm(tangents, axis=1, keepdims=True)
        normals = np.stack([tangents[:, 1], -tangents[:, 0]], axis=1)
        summed = np.concatenate([normals[:1], normals]) + np.concatenate([normals, normals[-1:]])
        return np.asarray(self.sew + 2.0 * self.width * summed / (summed**2).sum(axis=1, keepdims=True))


@dataclass(frozen=True)
class Corner:
    """Describe the join of two offset edges.

    Attributes:
        before: The first edge's points up to the corner [m], shape [n, 2].
        between: Points between both [m], shape [m, 2].
        after: The second edge's points from the corner [m], shape [k, 2].
        fold: Where the fold of a turned-up edge meets the cut line, and the unit vector along it into the cloth; None.
    """

    before: np.ndarray
    between: np.ndarray
    after: np.ndarray
    fold: tuple[np.ndarray, np.ndarray] | None = None


def join_corner(first: Side, second: Side, before: np.ndarray, after: np.ndarray) -> Corner:
    """Join the offset of an edge to that of the next one.

    - The side of a turned-up edge continues to its fold and from there as the mirror image of the cut side, so that the
    hem, turned up, covers it.
    - At a convex corner both are extended to where they meet (mitre), but at most by `MITRE_LIMIT` allowances from the
    corner. Where they do not meet nearby (different widths of edges in a straight line), a step at a right angle joins
    them.
    - At a concave corner they cross; the loop between is removed later.

    Args:
        first, second: The edges.
        before: Offset of the first, or the rest of it after the corner at its start [m], shape [n, 2].
        after: Offset of the second [m], shape [k, 2].
    """
    if first.use in TURNED_UP_EDGE_USES and second.use not in TURNED_UP_EDGE_USES and second.width + first.width > 0.0:
        fold = Fold(second.sew[0], -first.last, -_right(first.last), first.width)
        mirrored = fold.mirror(after)
        if mirrored is not None:
            side, path = mirrored
            hem = _begin_at(before[::-1], fold.corner, fold.along, path[-1])[::-1]
            return Corner(hem, path[::-1], side, (path[0], fold.along))
    if second.use in TURNED_UP_EDGE_USES and first.use not in TURNED_UP_EDGE_USES and second.width + first.width > 0.0:
        fold = Fold(first.sew[-1], second.first, -_right(second.first), second.width)
        mirrored = fold.mirror(before[::-1])
        if mirrored is not None:
            side, path = mirrored
            return Corner(side[::-1], path, _begin_at(after, fold.corner, fold.along, path[-1]), (path[0], fold.along))
    return _mitre(first, second, before, after)


def _mitre(first: Side, second: Side, before: np.ndarray, after: np.ndarray) -> Corner:
    """Join two offsets where they meet."""
    nothing = np.zeros((0, 2))
    p, a, b = first.sew[-1], first.last, second.first
    turn = float(np.arctan2(a[0] * b[1] - a[1] * b[0], a @ b))
    if abs(turn) < MAX_STRAIGHT_TURN_ANGLE:
        return Corner(before, nothing, after)
    if turn < 0.0:
        return Corner(before, nothing, after)
    width = max(first.width, second.width)
    on, back = (
        (second.width - first.width * np.cos(turn)) / np.sin(turn),
        (first.width - second.width * np.cos(turn)) / np.sin(turn),
    )
    end, start = p + first.width * _right(a), p + second.width * _right(b)
    diagonal = float(np.hypot(first.width, on))
    if diagonal <= MITRE_LIMIT * width:
        tip = end + on * a
        return Corner(_begin_at(before[::-1], p, -a, tip)[::-1], nothing, _begin_at(after, p, b, tip))
    if on <= 0.0 or back <= 0.0:
        return Corner(before, nothing, after)  # a step
    reach = [np.sqrt(max((MITRE_LIMIT * w) ** 2 - w**2, 0.0)) for w in (first.width, second.width)]
    tips = np.array([end + min(on, reach[0]) * a, start - min(back, reach[1]) * b])
    return Corner(np.concatenate([before, tips[:1]]), nothing, np.concatenate([tips[1:], after]))


@dataclass(frozen=True)
class Fold:
    """Describe one end of the line along which a hem is turned up.

    Attributes:
        corner: Where it meets the side on the sew line [m], shape [2].
        along: Unit vector along it, away from the corner, shape [2].
        inward: Unit vector into the cloth, at a right angle to it, shape [2].
        depth: Depth of the hem [m].
    """

    corner: np.ndarray
    along: np.ndarray
    inward: np.ndarray
    depth: float

    def mirror(self, side: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        """Mirror a cut side at the fold.

        Args:
            side: The side's offset from the corner on [m], shape [n, 2].

        Returns:
            The side above the fold, and the line from it down to the hem's cut edge; None where the side leans too far.
        """
        lean = unit(side[1] - side[0])
        if lean @ self.inward < MIN_FOLD_SIDE_COSINE:
            return None
        height = self.height(side)
        above = np.flatnonzero(height > 1e-9)
        if not len(above):
            return None
        k = int(above[0])
        if k == 0:
            foot = side[0] - lean * height[0] / (lean @ self.inward)
        else:
            share = -height[k - 1] / (height[k] - height[k - 1])
            foot = side[k - 1] + share * (side[k] - side[k - 1])
        rest = np.concatenate([foot[None], side[k:]])
        up = self._up_to_depth(rest)
        return rest, up - 2.0 * self.height(up)[:, None] * self.inward

    def height(self, points: np.ndarray) -> np.ndarray:
        """Return the distance of points inside the fold [m], shape [n]."""
        return np.asarray((points - self.corner) @ self.inward)

    def _up_to_depth(self, line: np.ndarray) -> np.ndarray:
        """Return the start of a line up to the hem's depth, extended straight where it is shorter."""
        height = self.height(line)
        over = np.flatnonzero(height >= self.depth)
        if not len(over):
            lean = unit(line[-1] - line[-2])
            rise = max(float(lean @ self.inward), MIN_FOLD_SIDE_COSINE)
            return np.concatenate([line, (line[-1] + lean * (self.depth - height[-1]) / rise)[None]])
        k = int(over[0])
        if k == 0:
            return line[:1]
        share = (self.depth - height[k - 1]) / (height[k] - height[k - 1])
        return np.concatenate([line[:k], (line[k - 1] + share * (line[k] - line[k - 1]))[None]])


def _begin_at(line: np.ndarray, corner: np.ndarray, along: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Return an offset line from a new start on, without the points before it along its edge's tangent."""
    is_ahead = (line - corner) @ along > (start - corner) @ along + 1e-9
    first = int(np.argmax(is_ahead)) if is_ahead.any() else len(line) - 1
    return np.concatenate([start[None], line[first:]])


def _right(direction: np.ndarray) -> np.ndarray:
    return np.array([direction[1], -direction[0]])
