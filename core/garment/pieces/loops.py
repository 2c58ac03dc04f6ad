"""Remove the loops of an offset outline."""

from __future__ import annotations

import numpy as np

from ..polygon import polygon_area

CORNER_CROSSING_TOLERANCE = 1e-12
"""Distance of a crossing from the end of a side [share of the side] below which it is the corner itself."""


def remove_loops(points: np.ndarray, tags: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the outer loop of a closed polygon that may cross itself. Changing to the other side at every crossing
    splits the polygon into loops that cross neither themselves nor each other. The superfluous loops of an offset
    outline are clockwise, or inside the outer one; the loop of the largest area is kept.

    Args:
        points: Corners, counter-clockwise [m], shape [n, 2].
        tags: A number of each side, from corner i to i + 1, shape [n].

    Returns:
        Corners, the tag of each side, and for each corner its index in `points`, or -1 for a crossing.
    """
    cuts = _find_crossings(points)
    if not cuts:
        return points, tags, np.arange(len(points))
    corners, sides, origin, following = _split(points, tags, cuts)
    best: list[int] = []
    area, seen = 0.0, np.zeros(len(corners), dtype=bool)
    for first in range(len(corners)):
        loop = []
        at = first
        while not seen[at]:
            seen[at] = True
            loop.append(at)
            at = int(following[at])
        if len(loop) > 2 and polygon_area(corners[loop]) > area:
            best, area = loop, polygon_area(corners[loop])
    return corners[best], sides[best], origin[best]


def _find_crossings(points: np.ndarray) -> list[tuple[int, float, int, float]]:
    """Return side i, the fraction of it, side j > i and the fraction of that for every crossing of two sides."""
    n = len(points)
    step = np.roll(points, -1, axis=0) - points
    low = np.minimum(points, points + step)
    high = np.maximum(points, points + step)
    overlaps = np.all((low[:, None] <= high[None]) & (low[None] <= high[:, None]), axis=2)
    i, j = np.nonzero(np.triu(overlaps, 2))
    keep = (j - i) % n != n - 1
    i, j = i[keep], j[keep]
    cross = step[i, 0] * step[j, 1] - step[i, 1] * step[j, 0]
    apart = points[j] - points[i]
    with np.errstate(divide="ignore", invalid="ignore"):
        s = (apart[:, 0] * step[j, 1] - apart[:, 1] * step[j, 0]) / cross
        t = (apart[:, 0] * step[i, 1] - apart[:, 1] * step[i, 0]) / cross
    # A side includes its start, not its end, so that a crossing in a corner is found once.
    hit = (
        (s >= -CORNER_CROSSING_TOLERANCE)
        & (s < 1 - CORNER_CROSSING_TOLERANCE)
        & (t >= -CORNER_CROSSING_TOLERANCE)
        & (t < 1 - CORNER_CROSSING_TOLERANCE)
    )
    return [(int(a), float(b), int(c), float(d)) for a, b, c, d in zip(i[hit], s[hit], j[hit], t[hit], strict=True)]


def _split(
    points: np.ndarray, tags: np.ndarray, cuts: list[tuple[int, float, int, float]]
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return corners, tags and origins with two corners at every crossing, and the corner that follows each."""
    n = len(points)
    step = np.roll(points, -1, axis=0) - points
    places: list[tuple[int, float, int]] = [(i, -1.0, -1) for i in range(n)]
    for number, (i, s, j, t) in enumerate(cuts):
        places += [(i, s, number), (j, t, number)]
    places.sort()
    side = np.array([place[0] for place in places])
    cut_of = np.array([place[2] for place in places])
    part = np.clip([place[1] for place in places], 0.0, 1.0)
    corners = points[side] + part[:, None] * step[side]
    following = (np.arange(len(places)) + 1) % len(places)
    sides = tags[side]
    for cut in range(len(cuts)):
        one, two = np.flatnonzero(cut_of == cut)
        corners[two] = corners[one]
        following[one], following[two] = following[two], following[one]
        sides[one], sides[two] = sides[two], sides[one]
    return corners, sides, np.where(cut_of < 0, side, -1), following
