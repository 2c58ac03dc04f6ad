"""Divide the border of a garment that is open in front into its neckline, its front edges and its hem."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...body.body import Body
from ...geometry.curves import Curve
from .loop import smooth_loop

PART_COUNT = 4
"""Number of parts of the border of an open front: neckline, an edge, hem, the other edge."""


class FrontBorder(NamedTuple):
    """Describe the parts of the border of an open front by the indices of their vertices in the loop, in its order;
    neighbouring parts share a corner."""

    neck: np.ndarray
    left: np.ndarray
    hem: np.ndarray
    right: np.ndarray


def divide_front(points: np.ndarray, body: Body, limit: str = "head") -> FrontBorder | None:
    """Divide a border loop into neckline, front edges and hem.

    Neckline and hem run around the trunk, front edges along it. Of all divisions of the smoothed loop into four parts
    the one with the least
        int_neck,hem (t . a)^2 ds + int_edges (1 - (t . a)^2) ds
    is taken, by dynamic programming from the loop's highest point along the trunk, which belongs to the neckline. So
    does all that is above the joint `limit`: the edge of a hood runs upwards there, beside the face. The edge that goes
    down from there, the garment on its left, is that of the wearer's left front.

    Notation: t the unit tangent, a the trunk's direction, from the pelvis to the neck.

    Args:
        points: The loop, garment on the left [m], shape [n, 3].
        body: The wearer.
        limit: Name of the joint above which no front edge goes.

    Returns:
        The parts; None where one of them has no length. Whether the loop is a front's shows what neckline and hem go
        around.
    """
    axis = body.joint("neck") - body.joint("pelvis")
    axis = axis / np.linalg.norm(axis)
    smooth = smooth_loop(points)
    first = int((smooth @ axis).argmax())
    curve = Curve(np.roll(smooth, -first, axis=0))
    along = (curve.tangents @ axis) ** 2
    middles = 0.5 * (curve.points + np.roll(curve.points, -1, axis=0))
    along[middles @ axis > body.joint(limit) @ axis] = 0.0
    starts = _divide(along * curve.lengths, (1.0 - along) * curve.lengths)
    corners = [_nearest(points, curve.points[start]) for start in starts]
    parts = [_between(corners[i], corners[(i + 1) % PART_COUNT], len(points)) for i in range(PART_COUNT)]
    if min(len(part) for part in parts) < 2:
        return None
    left, hem, right, neck = parts
    return FrontBorder(neck, left, hem, right)


def _divide(across: np.ndarray, along: np.ndarray) -> list[int]:
    """Find where the parts after the first begin if each segment costs `across` in neckline and hem and `along` in the
    edges, shape [n] each.

    The loop begins and ends in the neckline, so that it has five parts in order, each of a segment at least.
    """
    costs = np.stack([across, along, across, along, across])
    total = np.full(len(costs), np.inf)
    total[0] = 0.0
    came = np.zeros((len(across), len(costs)), dtype=np.int64)
    for i in range(len(across)):
        for part in range(len(costs) - 1, 0, -1):
            came[i, part] = part
            if total[part - 1] < total[part]:
                total[part], came[i, part] = total[part - 1], part - 1
        total = total + costs[:, i]
    part, starts = len(costs) - 1, []
    for i in range(len(across) - 1, -1, -1):
        if came[i, part] != part:
            starts.append(i)
            part -= 1
    return starts[::-1]


def _nearest(points: np.ndarray, place: np.ndarray) -> int:
    """Return the index of the nearest point [m]."""
    return int(((points - place) ** 2).sum(axis=1).argmin())


def _between(first: int, last: int, count: int) -> np.ndarray:
    """Return the indices of a loop from one to another, both included."""
    return (first + np.arange((last - first) % count + 1)) % count
