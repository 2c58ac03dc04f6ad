"""Divide the border of a wrapped front: what is seen of its neckline, and what lies below the outer front."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...body.body import Body

MIN_LAP_REACH = 0.1
"""Least distance to either side [m] that both edges of a wrapped front go on beyond the point where they cross: a
double-breasted front laps by 8 to 10 cm in all, 5 on each side of the middle; a wrap's edges reach both side seams."""

MAX_LAP_GAP = 0.06
"""Largest distance of both edges where they cross, seen from in front [m]: one front lies on the other, or hangs from
the bust up to so far before it."""

MAX_LAP_POINT_COUNT = 600
"""Largest number of points of a border of which all pairs of segments are compared; of a longer one every second,
third, ... point is."""


class LapBorder(NamedTuple):
    """Describe the parts of the border of a wrapped front by the indices of their vertices in the loop, in its order.

    Attributes:
        seen: The neckline that is seen: the back neck and both front edges, to where they cross; closed by that step.
        covered: The rest, from the left front's edge, below the outer front, to the right front's.
    """

    seen: np.ndarray
    covered: np.ndarray


def divide_lap(points: np.ndarray, body: Body) -> LapBorder | None:
    """Divide a border loop where it crosses itself, seen from in front.

    Both edges of a wrapped front go down from the side neck points, cross in the point of the V and go on to the other
    side of the wearer: the border of a plain front does not cross itself. From the loop's highest point on, the first
    crossing counts beyond which both edges go on.

    Args:
        points: The loop, garment on the left [m], shape [n, 3].
        body: The wearer.

    Returns:
        The parts; None where the loop does not cross itself in front of the wearer, or ends near that place.
    """
    lateral = body.sideways("shoulder") / np.linalg.norm(body.sideways("shoulder"))
    ahead = np.cross(lateral, (0.0, 1.0, 0.0))
    count, stride = len(points), -(-len(points) // MAX_LAP_POINT_COUNT)
    order = np.roll(np.arange(count), -int(points[:, 1].argmax()))[::stride]
    line = (points[order] - body.joint("neck")) @ np.stack([lateral, (0.0, 1.0, 0.0), ahead], axis=1)
    crossing = _find_crossing(line)
    if crossing is None:
        return None
    first, last = crossing
    start, end = int(order[first]), int(order[(last + 1) % len(order)])
    covered = (start + np.arange((end - start) % count + 1)) % count
    seen = (end + np.arange((start - end) % count + 1)) % count
    return LapBorder(seen, covered)


def _find_crossing(line: np.ndarray) -> tuple[int, int] | None:
    """Find the first two segments of a closed line that cross each other, seen from in front, and between which it
    reaches far to both sides.

    Args:
        line: To the wearer's left, up and ahead of the neck joint [m], shape [n, 3].

    Returns:
        The segments' first points in order; None without any.
    """
    count = len(line)
    step = np.roll(line, -1, axis=0) - line
    i, j = np.triu_indices(count, 2)
    near = (line[i, 2] > 0.0) & (line[j, 2] > 0.0) & (np.abs(line[i, 2] - line[j, 2]) < MAX_LAP_GAP)
    i, j = i[near], j[near]
    area = _cross(step[i], step[j])
    between = line[j] - line[i]
    with np.errstate(divide="ignore", invalid="ignore"):
        along, across = (_cross(between, step[k]) / area for k in (j, i))
        found = (along >= 0.0) & (along < 1.0) & (across >= 0.0) & (across < 1.0) & (i + count - 1 - j > 1)
    crossings = np.flatnonzero(found)
    for one in crossings[np.argsort((i + count - 1 - j)[crossings], kind="stable")]:
        beyond = line[i[one] : j[one] + 2, 0] - line[i[one], 0]
        if beyond.min() < -MIN_LAP_REACH and beyond.max() > MIN_LAP_REACH:
            return int(i[one]), int(j[one])
    return None


def _cross(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return the products x1 y2 - y1 x2 of vectors [m], shape [n, 3]."""
    return np.asarray(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])
