"""Normals of points without faces: estimated from neighbours, oriented outward, averaged; and points thinned evenly."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .geometry import unit

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

NORMAL_NEIGHBOUR_COUNT = 24
"""Number of points to which a plane is fitted: with 2 mm of noise at 5 mm of spacing the error is about 10 degrees."""
MAX_NORMAL_POINT_COUNT = 200_000
"""Largest number of points at which planes are fitted; in a denser cloud the others have the nearest one's normal."""
NORMAL_BATCH_POINT_COUNT = 50_000
"""Number of points in a batch, so that their neighbours take 30 MB."""
MIN_NORMAL_AGREEMENT_SHARE = 0.8
"""Smallest share of agreeing neighbours' normals in an oriented cloud; random ones reach 0.5."""


def estimate_normals(
    points: np.ndarray, drawn: np.ndarray | None = None, count: int = NORMAL_NEIGHBOUR_COUNT
) -> np.ndarray:
    """Estimate unit normals from the plane through each point's neighbours, shape [m, 3]; of either sign.

    It is the direction of least variance (H. Hoppe et al., Surface Reconstruction from Unorganized Points, 1992).

    Args:
        points: Positions [m], shape [n, 3].
        drawn: Indices of the points in question, shape [m], or None: all.
        count: Neighbours, itself included.
    """
    tree, queries = _make_tree(points), points if drawn is None else points[drawn]
    found = []
    for start in range(0, len(queries), NORMAL_BATCH_POINT_COUNT):
        neighbours = points[tree.query(queries[start : start + NORMAL_BATCH_POINT_COUNT], min(count, len(points)))[1]]
        neighbours = neighbours - neighbours.mean(axis=1, keepdims=True)
        found.append(np.linalg.eigh(np.einsum("nka,nkb->nab", neighbours, neighbours))[1][:, :, 0])
    return np.concatenate(found) if found else np.zeros((0, 3))


def find_normals(points: np.ndarray) -> np.ndarray:
    """Estimate unit normals of either sign, shape [n, 3], beyond `MAX_NORMAL_POINT_COUNT` points from a subset."""
    if len(points) <= MAX_NORMAL_POINT_COUNT:
        return estimate_normals(points)
    subset = points[thin_points(points, MAX_NORMAL_POINT_COUNT)]
    normals, tree = estimate_normals(subset), _make_tree(subset)
    return np.concatenate(
        [
            normals[tree.query(points[s : s + NORMAL_BATCH_POINT_COUNT])[1]]
            for s in range(0, len(points), NORMAL_BATCH_POINT_COUNT)
        ]
    )


def smooth_normals(points: np.ndarray, normals: np.ndarray, drawn: np.ndarray, count: int = 12) -> np.ndarray:
    """Average the normals around drawn points, shape [drawn, 3], of length 1.

    With 5 mm of noise on edges of 7 mm, one vertex normal in five points inward, and bodies fitted below are too thin.

    Args:
        points: Positions [m], shape [n, 3].
        normals: Normals, weighted by their length, shape [n, 3].
        drawn: Indices of the points in question.
        count: Neighbours, itself included: a disk of 2.5 cm radius at 12 mm spacing.
    """
    _, index = _make_tree(points).query(points[drawn], k=min(count, len(points)))
    mean = normals[index].sum(axis=1)
    return np.asarray(mean / np.maximum(np.linalg.norm(mean, axis=1, keepdims=True), 1e-12))


def orient_normals(
    positions: np.ndarray,
    normals: np.ndarray,
    inner_points: np.ndarray,
    inner_normals: np.ndarray,
    rounds: int = 10,
) -> np.ndarray:
    """Orient normals outward by those of a known surface below, and by their neighbours where those are perpendicular.

    Args:
        positions: Positions [m], shape [n, 3].
        normals: Unit normals of either sign, shape [n, 3].
        inner_points: Points of the surface below [m], shape [k, 3].
        inner_normals: Their outward unit normals, shape [k, 3].
        rounds: Number of iterations over the neighbours; a fold's flank is within a few of them.
    """
    _, nearest = _make_tree(inner_points).query(positions)
    trust = np.einsum("na,na->n", normals, inner_normals[nearest])
    _, index = _make_tree(positions).query(positions, k=min(10, len(positions)))
    alike = np.einsum("nka,na->nk", normals[index], normals)
    confidence = trust.copy()
    for _ in range(rounds):
        confidence = np.tanh(2.0 * (trust + (alike * confidence[index]).mean(axis=1)))
    return np.asarray(normals * np.where(confidence < 0, -1.0, 1.0)[:, None])


def find_normal_orientation(points: np.ndarray, normals: np.ndarray) -> int:
    """Find whether the normals of a closed surface's points face outward (1), inward (-1), or disagree (0)."""
    rows = thin_points(points, 20_000)
    neighbours = _make_tree(points[rows]).query(points[rows], min(7, len(rows)))[1][:, 1:]
    agree = np.einsum("nki,ni->nk", normals[rows][neighbours], normals[rows]) > 0.0
    if agree.mean() < MIN_NORMAL_AGREEMENT_SHARE:
        return 0
    flux = float(((points[rows] - points[rows].mean(axis=0)) * normals[rows]).sum())
    return 1 if flux > 0.0 else -1


MIN_NOISY_NORMAL_SPREAD = 0.08
"""Spread of normals [1] (1 - length of the mean of `NORMAL_AVERAGING_COUNT`) from which they are noise: 0.01 to 0.02
with the scanner's noise of 1 to 2 mm, 0.21 with 5 mm."""
NORMAL_AVERAGING_COUNT = 8
"""Number of points whose normals are averaged where they are noise: at 7 mm of spacing a disk of 1 cm radius."""


def denoise_normals(positions: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Average unit normals, shape [n, 3], over their neighbours of the same side where they are mostly noise."""
    _, neighbours = _make_tree(positions).query(positions, k=min(NORMAL_AVERAGING_COUNT, len(positions)))
    around = normals[neighbours]
    if np.median(1.0 - np.linalg.norm(around.mean(axis=1), axis=1)) < MIN_NOISY_NORMAL_SPREAD:
        return normals
    same = np.einsum("nka,na->nk", around, normals) > 0
    return np.asarray(unit((around * same[:, :, None]).sum(axis=1)))


def thin_points(points: np.ndarray, count: int) -> np.ndarray:
    """Choose about `count` points evenly in space, one for each cell of a grid: their indices, ascending."""
    if len(points) <= count:
        return np.arange(len(points))
    low = points.min(axis=0)
    edge = float(np.ptp(points, axis=0).max()) / np.sqrt(count)
    rows = np.arange(len(points))
    for _ in range(4):
        cell = np.minimum((points - low) / edge, 2**20 - 1).astype(np.int64)
        _, rows = np.unique((cell[:, 0] << 40) | (cell[:, 1] << 20) | cell[:, 2], return_index=True)
        if 0.8 * count <= len(rows) <= 1.1 * count:
            break
        edge *= float(np.sqrt(len(rows) / count))  # points of a surface: cells grow with the square of 1 / edge
    return np.sort(rows)


def _make_tree(points: np.ndarray) -> cKDTree:
    from scipy.spatial import cKDTree  # on first use: the API imports this module without using it

    return cKDTree(points)
