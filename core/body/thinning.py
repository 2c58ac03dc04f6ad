"""Thin a scan's points evenly: what a body is fitted to must not count a densely scanned face more than a back."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from .fit import OrientedPoints

CELL = 0.012
"""Edge of the cells [m] that points are averaged in: finer than the fit's points lie apart (2 cm)."""


def thin_points(
    points: np.ndarray, normals: np.ndarray | None, oriented: bool, count: int, seed: int
) -> OrientedPoints | None:
    """Average points in cells, and draw some of the cells.

    Points of a cell are averaged apart by the octant of their normals, where these are known: the two sides of a hem
    are two points.

    Args:
        points: Positions [m], shape [n, 3].
        normals: Unit normals, shape [n, 3], or None: found from the averaged points' neighbours, of either sign.
        oriented: Whether the normals are known to point outward.
        count: Points drawn at most.
        seed: Seeds the draw.

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
    cell = np.floor((points - points.min(axis=0)) / CELL).astype(np.int64)
    shape = cell.max(axis=0) + 1
    key = (cell[:, 0] * shape[1] + cell[:, 1]) * shape[2] + cell[:, 2]
    if normals is not None and oriented:
        normals = normals[kept]
        key = key * 8 + (normals > 0) @ np.array([1, 2, 4])
    elif normals is not None:
        normals = normals[kept]
    _, group, number = np.unique(key, return_inverse=True, return_counts=True)
    centres = np.stack([np.bincount(group, points[:, a]) for a in range(3)], axis=1) / number[:, None]
    if normals is None or not oriented:
        oriented = False
        found = estimate_normals(centres)
    else:
        found = np.stack([np.bincount(group, normals[:, a]) for a in range(3)], axis=1)
        found /= np.maximum(np.linalg.norm(found, axis=1, keepdims=True), 1e-12)
    drawn = np.random.default_rng(seed).permutation(len(centres))[:count]
    return OrientedPoints(centres[drawn], found[drawn], oriented=oriented)


def estimate_normals(positions: np.ndarray, count: int = 16) -> np.ndarray:
    """Estimate unit normals, of either sign, from the plane through each point's neighbours, shape [n, 3]."""
    _, index = cKDTree(positions).query(positions, k=min(count, len(positions)))
    around = positions[index] - positions[index].mean(axis=1, keepdims=True)
    _, vectors = np.linalg.eigh(np.einsum("nka,nkb->nab", around, around))
    return np.asarray(vectors[:, :, 0])
