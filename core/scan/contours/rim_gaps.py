"""Find holes that have broken through a contour by their narrow mouth, and bridge them there."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial

import numpy as np
from scipy.spatial import cKDTree

from ...geometry.curves import Curve
from ...geometry.geometry import unit, vertex_normals
from .loop import CONTOUR_SMOOTHING_LENGTH

MIN_BITE_RIM_RATIO = 2.5
"""Least ratio of a bite's rim to its mouth. Design has less: a half-round scallop 1.6, a pointed V-neck 2."""
MIN_BITE_DEPTH = 0.05
"""Least depth of a bite into the garment [m]; less is a tooth of a cut along triangles."""
MIN_BITE_DEPTH_SHARE = 0.25
"""Least depth of a bite into the garment, as a share of its rim's length; a fold of a hem runs sideways instead."""
MIN_BITE_AREA_SHARE = 0.6
"""Least area of a neck's bite, as a share of the rectangle over its mouth of equal depth. A triangle has 0.5, and so
has the lower part of a V, whose rim is 2.2 times its mouth where it is 21 cm wide and 20 cm deep, and 2.7 near the tip;
a round hole whose rim is 2.5 times its mouth has 1.0."""
MIN_TEAR_RIM_RATIO = 4.0
"""Ratio of the rim to the mouth from which a neck's bite with less area than `MIN_BITE_AREA_SHARE` is a tear; a V has
this ratio where it is twice as deep as wide."""
MAX_SLIT_AREA_RATIO = 0.02
"""Ratio of area to a rim's squared length below which it is a slit's, whose area vector has no reliable direction."""
MIN_BITE_NORMAL_COSINE = 0.1
"""Least cosine between a bite's area vector and its direction for missing surface: nearer to 0 its sign is random. A
fold of a flared hem had 0.06, stretches of it that are a vertex shorter -0.07 to -0.4."""
MAX_BITE_POINT_COUNT = 1000
"""Largest number of points that are compared in pairs; of a longer contour every second, third, ... point is."""
MAX_BITE_CANDIDATE_COUNT = 500
"""Largest number of stretches that are checked, narrowest first: the many folds of a gathered hem are all rejected."""

MIN_BAY_AREA_RATIO = 0.3
"""Least ratio of an unseen bay's area to that of the square on its mouth: a half disk has 0.39."""
MIN_BAY_NORMAL_COSINE = 0.85
"""Least cosine between a bay's area vector and the surface's normal: true holes had 0.99, gaps below sleeves 0.7."""
MIN_MEAN_NORMAL_LENGTH = 2.0 / np.pi
"""Least length of the mean of a bay's unit normals [1]: that of half a tube. A stretch that goes further around is the
end of the tube, whose normals cancel and give no direction for its area vector."""
MIN_BAY_AREA = 4e-4
"""Smallest area of a bay [m2]: less is a tooth of the triangles."""
MIN_SEEN_LENGTH = 0.01
"""Length below which a seen stretch within an unseen one is noise [m]."""


def bridge_bays(
    points: np.ndarray, normals: np.ndarray, unseen: np.ndarray
) -> tuple[np.ndarray, tuple[np.ndarray, ...]]:
    """Cut off a contour's bays beyond which nothing was seen: holes of the scan that broke through the contour.

    A stretch of unseen points and its chord enclose the area vector A; with the garment on the left, A runs against the
    surface's normal n where the stretch goes around missing surface. It is a bay where A and -n agree, A is large, and
    the stretch goes at most half around a tube.

    Args:
        points: The contour [m], garment on the left, shape [n, 3].
        normals: The surface's normals there, averaged over some centimetres, shape [n, 3].
        unseen: True where nothing was seen beyond, shape [n].

    Returns:
        As `bridge_bites`.
    """
    stretches = _unseen_stretches(points, unseen)
    if not stretches:
        return np.arange(len(points)), ()
    kept = np.ones(len(points), bool)
    bays = []
    for stretch in stretches:
        mouth = points[stretch[-1]] - points[stretch[0]]
        area, missing = _missing_area(points[stretch], normals[stretch])
        lies_in_surface = (
            missing >= MIN_BAY_NORMAL_COSINE * area and _mean_length(normals[stretch]) >= MIN_MEAN_NORMAL_LENGTH
        )
        if lies_in_surface and missing >= max(MIN_BAY_AREA, MIN_BAY_AREA_RATIO * float(mouth @ mouth)):
            kept[stretch[1:-1]] = False
            bays.append(stretch)
    return np.flatnonzero(kept), tuple(bays)


def _unseen_stretches(points: np.ndarray, unseen: np.ndarray) -> list[np.ndarray]:
    """Return the indices of each stretch of unseen points with the seen point on either side, in order."""
    seen = np.flatnonzero(~unseen)
    if len(seen) < 3 or len(seen) == len(points):
        return []
    step = Curve(points).lengths
    arc = np.concatenate([[0.0], np.cumsum(np.concatenate([step, step]))])
    # Each gap between two seen points that are not neighbours; gaps with little seen between them are one.
    gaps = [[a, b if b > a else b + len(points)] for a, b in zip(seen, np.roll(seen, -1), strict=True)]
    gaps = [gap for gap in gaps if gap[1] > gap[0] + 1]
    merged = [gaps[0]]
    for gap in gaps[1:]:
        if arc[gap[0]] - arc[merged[-1][1]] < MIN_SEEN_LENGTH:
            merged[-1][1] = gap[1]
        else:
            merged.append(gap)
    return [np.arange(a, b + 1) % len(points) for a, b in merged if b - a < len(points)]


def bridge_bites(
    points: np.ndarray, find_normals: Callable[[], np.ndarray], *, pointed: bool = False
) -> tuple[np.ndarray, tuple[np.ndarray, ...]]:
    """Cut bites off a contour along the chord of their mouth.

    A bite is much longer than its chord, reaches into the garment (along the contour's area vector), and has an area
    vector against the surface's normal, as around missing surface (`bridge_bays`); a fold of a hem goes around air or
    cloth. The one with the narrowest mouth for its length is cut off, then again.

    Args:
        points: The contour [m], garment on the left, shape [n, 3].
        find_normals: Returns the surface's normals there, averaged over some centimetres, shape [n, 3].
        pointed: True for a neck, whose design may be a V: a stretch as narrow as a V with no more area is no bite.

    Returns:
        Indices of the points that stay on the contour, in order, and those of each bite, its mouth's two ends included.
    """
    kept = np.arange(len(points))
    gaps: list[np.ndarray] = []
    normals = cache(find_normals)
    while len(kept) > 8 and (gap := _find_bite(points[kept], partial(_take, normals, kept), pointed)) is not None:
        start, count = gap
        kept = np.roll(kept, -start)
        gaps.append(kept[: count + 1])
        kept = np.concatenate([kept[:1], kept[count:]])
    return kept, tuple(gaps)


def _take(normals: Callable[[], np.ndarray], rows: np.ndarray) -> np.ndarray:
    found: np.ndarray = normals()[rows]
    return found


def _find_bite(points: np.ndarray, normals: Callable[[], np.ndarray], pointed: bool) -> tuple[int, int] | None:
    """Return start and number of steps of the bite with the narrowest mouth, or None."""
    stride = -(-len(points) // MAX_BITE_POINT_COUNT)
    found = _search_pairs(points[::stride], lambda: normals()[::stride], pointed)
    if found is None:
        return None
    start, count = found[0] * stride, found[1] * stride
    return start, min(count, len(points) - 2)


def _search_pairs(points: np.ndarray, normals: Callable[[], np.ndarray], pointed: bool) -> tuple[int, int] | None:
    count = len(points)
    steps = Curve(points).lengths
    arc = np.concatenate([[0.0], np.cumsum(np.concatenate([steps, steps]))])
    start, span = np.meshgrid(np.arange(count), np.arange(2, count // 2), indexing="ij")
    length = arc[start + span] - arc[start]
    chord = np.linalg.norm(points[(start + span) % count] - points[start], axis=2)
    narrow = (length >= 2.0 * MIN_BITE_DEPTH) & (length > MIN_BITE_RIM_RATIO * chord) & (length < 0.5 * arc[count])
    if not narrow.any():
        return None
    area = 0.5 * np.cross(points - points.mean(axis=0), np.roll(points, -1, axis=0) - points.mean(axis=0)).sum(axis=0)
    normal = area / max(float(np.linalg.norm(area)), 1e-12)
    candidates = np.argwhere(narrow)
    narrowness = (length / np.maximum(chord, 1e-9))[narrow]
    for row, column in candidates[np.argsort(-narrowness, kind="stable")][:MAX_BITE_CANDIDATE_COUNT].tolist():
        first, steps_taken = row, column + 2
        rim = (first + np.arange(steps_taken + 1)) % count
        inside = points[rim[1:-1]] - points[first]
        if float((inside @ normal).max()) < max(MIN_BITE_DEPTH, MIN_BITE_DEPTH_SHARE * float(length[row, column])):
            continue
        area, missing = _missing_area(points[rim], normals()[rim])
        tear = float(length[row, column]) >= MIN_TEAR_RIM_RATIO * float(chord[row, column])
        if pointed and not tear and area < MIN_BITE_AREA_SHARE * _frame_area(points[rim]):
            continue
        if missing > MIN_BITE_NORMAL_COSINE * area or area < MAX_SLIT_AREA_RATIO * float(length[row, column]) ** 2:
            return first, steps_taken
    return None


def _frame_area(points: np.ndarray) -> float:
    """Return the area of the rectangle over a stretch's chord that is as deep as the stretch [m2]."""
    run, chord = points - points[0], points[-1] - points[0]
    return float(np.linalg.norm(np.cross(run, chord), axis=1).max())


def _mean_length(normals: np.ndarray) -> float:
    """Return the length of the mean of unit normals: 1 on a plane, 0 all around a tube."""
    return float(np.linalg.norm(normals.mean(axis=0)))


def _missing_area(points: np.ndarray, normals: np.ndarray) -> tuple[float, float]:
    """Return the area [m2] between a stretch and its chord, and how much of it is missing surface."""
    run, normal = points - points[0], normals.sum(axis=0)
    area = 0.5 * np.cross(run, np.roll(run, -1, axis=0)).sum(axis=0)
    return float(np.linalg.norm(area)), -float(area @ normal) / max(float(np.linalg.norm(normal)), 1e-12)


def average_normals(vertices: np.ndarray, faces: np.ndarray, loop: np.ndarray) -> np.ndarray:
    """Return unit normals along a contour, averaged within `CONTOUR_SMOOTHING_LENGTH`, shape [loop_count, 3].

    Noise scatters the vertices' normals, which shortens their mean but keeps its direction.
    """
    normals, around = (
        vertex_normals(vertices, faces),
        cKDTree(vertices).query_ball_point(vertices[loop], CONTOUR_SMOOTHING_LENGTH),
    )
    return unit(np.array([normals[neighbours].mean(axis=0) for neighbours in around]))
