"""Thin a scan's points evenly, so that a densely scanned face does not count more than a back in the fit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..geometry.point_normals import estimate_normals, smooth_normals
from .fit import OrientedPoints

THINNING_CELL_SIZE = 0.012
"""Edge of the cells [m] in which points are averaged: less than the spacing of the fit's points (2 cm)."""
THINNED_NEIGHBOUR_COUNT = 16
"""Number of averaged points from which a normal is estimated: a disk of 2.5 cm radius."""


@dataclass(frozen=True)
class ThinnedPoints(OrientedPoints):
    """Describe some of a scan's cells, in random order; `total` is the number of all cells with points."""

    total: int = 0


def average_points(
    points: np.ndarray, normals: np.ndarray | None, oriented: bool, count: int, seed: int
) -> ThinnedPoints | None:
    """Average points in cells, and draw some of the cells.

    Args:
        points: Positions [m], shape [n, 3].
        normals: Unit normals, shape [n, 3], or None.
        oriented: Whether the normals are known to point outward; if not, or without normals, they are computed from the
            averaged points' neighbours, of either sign.
        count: Largest number of points drawn.
        seed: Seed of the draw.

    Returns:
        The points in random order, or None where there are none.
    """
    points = np.asarray(points, dtype=np.float64)
    kept = np.isfinite(points).all(axis=1)
    if normals is not None:
        normals = np.asarray(normals, dtype=np.float64)
        kept &= np.isfinite(normals).all(axis=1)
    if not kept.any():
        return None
    points = points[kept]
    cell = np.floor((points - points.min(axis=0)) / THINNING_CELL_SIZE).astype(np.int64)
    shape = cell.max(axis=0) + 1
    _, group, number = np.unique(
        (cell[:, 0] * shape[1] + cell[:, 1]) * shape[2] + cell[:, 2], return_inverse=True, return_counts=True
    )
    centres = np.stack([np.bincount(group, points[:, a]) for a in range(3)], axis=1) / number[:, None]
    drawn = np.random.default_rng(seed).permutation(len(centres))[:count]
    if normals is None or not oriented:
        found = estimate_normals(centres, drawn, THINNED_NEIGHBOUR_COUNT)
    else:
        sums = np.stack([np.bincount(group, column) for column in normals[kept].T], axis=1)
        found = smooth_normals(centres, sums, drawn)
    return ThinnedPoints(centres[drawn], found, oriented=normals is not None and oriented, total=len(centres))
