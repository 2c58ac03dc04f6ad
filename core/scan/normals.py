"""Normals of point clouds: found from neighbours, then turned outward by the body below them."""

from __future__ import annotations

import numpy as np

from ..mesh import unit

NEIGHBOURS = 24
"""Points that a plane is fitted to: with 2 mm of noise at 5 mm of spacing the normal is within some 10 degrees."""
MOST = 200_000
"""Points that planes are fitted at; of a denser cloud the others take the nearest's."""
BLOCK = 50_000
"""Points that are worked on at a time, so that their neighbours take 30 MB."""
AGREE = 0.8
"""Share of neighbours' normals that must point the same way for a cloud to be oriented; random ones reach 0.5."""


def find_normals(points: np.ndarray) -> np.ndarray:
    """Find unit normals from neighbours, shape [n, 3]; which way they point is not known.

    The normal is the direction in which the neighbours spread least (H. Hoppe et al., Surface Reconstruction from
    Unorganized Points, 1992).
    """
    from scipy.spatial import cKDTree

    rows = np.arange(len(points)) if len(points) <= MOST else thin_points(points, MOST)
    subset = points[rows]
    tree = cKDTree(subset)
    count = min(NEIGHBOURS, len(subset))
    found = []
    for start in range(0, len(subset), BLOCK):
        near = subset[tree.query(subset[start : start + BLOCK], count)[1]]
        near = near - near.mean(axis=1, keepdims=True)
        found.append(np.linalg.eigh(np.einsum("nki,nkj->nij", near, near))[1][:, :, 0])
    normals = np.concatenate(found)
    if len(rows) == len(points):
        return normals
    return np.concatenate([normals[tree.query(points[s : s + BLOCK])[1]] for s in range(0, len(points), BLOCK)])


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


def faces_outward(points: np.ndarray, normals: np.ndarray) -> int:
    """Find whether the normals of a closed surface's points face outward (1), inward (-1), or disagree (0)."""
    from scipy.spatial import cKDTree

    rows = thin_points(points, 20_000)
    near = cKDTree(points[rows]).query(points[rows], min(7, len(rows)))[1][:, 1:]
    agree = np.einsum("nki,ni->nk", normals[rows][near], normals[rows]) > 0.0
    if agree.mean() < AGREE:
        return 0
    flux = float(((points[rows] - points[rows].mean(axis=0)) * normals[rows]).sum())
    return 1 if flux > 0.0 else -1


def orient_normals(
    normals: np.ndarray, points: np.ndarray, body_points: np.ndarray, body_normals: np.ndarray, rounds: int = 3
) -> np.ndarray:
    """Turn unoriented normals outward by those of the body below, and let neighbours agree.

    Args:
        normals: Unit normals of the cloud, shape [n, 3].
        points: The cloud [m], shape [n, 3].
        body_points: Points of the fitted body's surface [m], shape [k, 3].
        body_normals: Their outward unit normals, shape [k, 3].
        rounds: How often each sign follows the mean of its neighbours.

    Returns:
        Unit normals, shape [n, 3].
    """
    from scipy.spatial import cKDTree

    nearest = cKDTree(body_points).query(points)[1]
    outward = unit(body_normals[nearest] + 0.5 * unit(points - body_points[nearest] + 1e-12))
    sign = np.where(np.einsum("ij,ij->i", normals, outward) < 0.0, -1.0, 1.0)
    turned = normals * sign[:, None]
    near = cKDTree(points).query(points, min(9, len(points)))[1]
    for _ in range(rounds):
        mean = turned[near].sum(axis=1)
        turned = np.where((np.einsum("ij,ij->i", turned, mean) < 0.0)[:, None], -turned, turned)
    return turned
