"""Unroll the lines of a neck opening into the plane, in front and behind, to find the neckline's shape."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...body.body import Body
from .loop import smooth_loop

NECK_SMOOTHING_LENGTH = 0.02
"""Width of smoothing before a neck contour is unrolled [m]: two teeth of a cut; a right angle is rounded by 2 mm."""

MAX_STRAP_LEAN_RATIO = 0.35
"""Largest ratio of a strap's edge's inward shift to its height on the way to the side neck point. A neckline is widest
there, except a square one, whose lower corners are as wide or wider, by 0.29 of their depth on a drape. Round and
pointed ones lean in by more than a half below that point; 0.3 to 0.4 give the same lines on eleven drapes."""

HALF_NECKLINE_SAMPLE_COUNT = 96
"""Number of samples of half a neckline: one every 3 mm of a deep one."""


@dataclass(frozen=True)
class NeckLines:
    """Describe the two lines of a neck opening, each the mean of its left and its right half.

    Attributes:
        front, back: From the side neck point, (half width, 0), to the middle, (0, depth): distance from the middle
            plane and length down the cloth [m], shape [n, 2].
        middles: The points in front and behind where the smoothed contour crosses the middle plane [m], shape [2, 3].
    """

    front: np.ndarray
    back: np.ndarray
    middles: np.ndarray


def unroll_neck(points: np.ndarray, body: Body) -> NeckLines | None:
    """Unroll a neck contour into the plane; None where it does not go round the neck from left to right.

    Chest and back are modelled as a cylinder whose rulings run from left to right: a point's distance u from the middle
    plane stays, and its height becomes the length p along the profile, a cubic over its chord fitted to (y, z).

    Args:
        points: The contour [m], shape [n, 3].
        body: The wearer; its joints define left, right and front.
    """
    loop = smooth_loop(points, NECK_SMOOTHING_LENGTH)
    lateral = body.sideways("shoulder")
    size = float(np.linalg.norm(lateral))
    if size < 1e-6:
        return None
    lateral = lateral / size
    off = loop @ lateral
    off = off - (off.max() + off.min()) / 2
    up = MAX_STRAP_LEAN_RATIO * loop[:, 1]
    left, right = int((up + off).argmax()), int((up - off).argmax())
    forward = loop @ np.cross(lateral, (0.0, 1.0, 0.0))
    arcs = [_between(len(loop), left, right), _between(len(loop), right, left)[::-1]]
    lines = [_unroll(loop[arc], off[arc]) for arc in arcs]
    depths = [float(forward[arc].mean()) for arc in arcs]
    front, back = lines if depths[0] > depths[1] else lines[::-1]
    return None if front is None or back is None else NeckLines(front[0], back[0], np.stack([front[1], back[1]]))


def _between(count: int, start: int, end: int) -> np.ndarray:
    """Return the indices of a loop from one of its points to another."""
    return np.arange(start, end + 1 + (count if end < start else 0)) % count


def _unroll(arc: np.ndarray, off: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """Unroll the arc from the left to the right side neck point and find its middle; None where there is none."""
    crossings = np.flatnonzero((off[:-1] > 0) & (off[1:] <= 0))
    if not len(crossings):
        return None
    middle = int(crossings[np.abs(crossings - len(off) / 2).argmin()])
    share = off[middle] / (off[middle] - off[middle + 1])
    centre = arc[middle] + share * (arc[middle + 1] - arc[middle])
    halves = [
        (np.concatenate([arc[: middle + 1], centre[None]]), np.append(off[: middle + 1], 0.0)),
        (np.concatenate([arc[:middle:-1], centre[None]]), np.append(-off[:middle:-1], 0.0)),
    ]
    if min(len(points) for points, _ in halves) < 3:
        return None
    mean = np.mean([_resample(points, width) for points, width in halves], axis=0)
    down = _length_along_profile(mean[:, 1:])
    return None if down is None else (np.stack([mean[:, 0], down], axis=1), centre)


def _length_along_profile(points: np.ndarray) -> np.ndarray | None:
    """Return the length down a profile to each of its points (y, z) [m], shape [n]; None where it has no length."""
    chord = points[-1] - points[0]
    size = float(np.linalg.norm(chord))
    if size < 1e-3:
        return None
    along, across = chord / size, np.array([-chord[1], chord[0]]) / size
    at, off = (points - points[0]) @ along, (points - points[0]) @ across
    slope = np.polynomial.Polynomial.fit(at, off, 3).deriv()
    grid = np.linspace(min(at.min(), 0.0), at.max(), 4 * HALF_NECKLINE_SAMPLE_COUNT)
    steps = np.hypot(np.diff(grid), np.diff(grid) * slope((grid[1:] + grid[:-1]) / 2))
    length = np.concatenate([[0.0], np.cumsum(steps)])
    return np.asarray(np.interp(at, grid, length) - np.interp(at[0], grid, length))


def _resample(points: np.ndarray, width: np.ndarray) -> np.ndarray:
    """Return width, height, place along z and x at equal steps of a half, shape [HALF_NECKLINE_SAMPLE_COUNT, 3]."""
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    at = np.linspace(0.0, length[-1], HALF_NECKLINE_SAMPLE_COUNT)
    return np.stack([np.interp(at, length, column) for column in (width, points[:, 1], points[:, 2])], axis=1)
