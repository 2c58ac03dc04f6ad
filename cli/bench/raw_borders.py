"""Measure the distance between the found and the true contours of the garments, on the scan itself."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ...core.geometry.connectivity import HalfEdges
from ...core.people.part import GARMENTS, Part

CLOUD_EDGE_COUNT = 8
"""Number of points of a cloud that each point is joined to: as many as a mesh has around a vertex, and two more for
gaps."""

MAX_CLOUD_EDGE_RATIO = 3.0
"""Largest ratio of the distance of a neighbour in a cloud to the median distance. A neighbour further away is across a
gap."""


@dataclass(frozen=True)
class BorderScore:
    """Describe the distances between the contours of garments.

    Attributes:
        median: Median distance of all border points to the other labelling's border [m]; inf if half have none.
        p95: 95th percentile of it [m].
        by_part: The median of each garment by its word; inf if only one labelling has it.
    """

    median: float
    p95: float
    by_part: dict[str, float]


def find_edges(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Find the neighbouring points of a scan: a mesh's edges, or in a cloud each point's nearest ones.

    Args:
        points: Positions [m], shape [n, 3].
        faces: Triangles, shape [m, 3]; empty for a cloud.

    Returns:
        Pairs of points, shape [edge_count, 2].
    """
    if len(faces):
        return HalfEdges.of(faces, len(points)).edges
    distance, neighbours = cKDTree(points).query(points, k=CLOUD_EDGE_COUNT + 1)
    origin = np.repeat(np.arange(len(points)), CLOUD_EDGE_COUNT)
    close = distance[:, 1:].ravel() <= MAX_CLOUD_EDGE_RATIO * np.median(distance[:, 1:])
    pairs = np.sort(np.stack([origin, neighbours[:, 1:].ravel()], axis=1)[close], axis=1)
    return np.unique(pairs, axis=0)


def measure_borders(points: np.ndarray, edges: np.ndarray, truth: np.ndarray, found: np.ndarray) -> BorderScore:
    """Measure the distance between the true and the found contours of every garment.

    A garment's border is the set of midpoints of the edges that lead from it to another part. Its contour is its border
    without edges to hair or to objects that are not part of the person: these cover the garment and do not end it.
    Distances are measured from every point of the true contours to the nearest point of the found border of the same
    garment, and from every point of the found contours to the true border, and both are pooled.

    Args:
        points: Positions [m], shape [n, 3].
        edges: Neighbours, `find_edges`.
        truth: True label of each point, shape [n].
        found: Found label of each point, shape [n].
    """
    pooled, by_part = [], {}
    for part in GARMENTS:
        one, one_border = _find_contour(points, edges, truth, part)
        other, other_border = _find_contour(points, edges, found, part)
        distances = np.concatenate([_distance(one, other_border), _distance(other, one_border)])
        if len(distances):
            by_part[part.word] = float(np.median(distances))
            pooled.append(distances)
    every = np.concatenate(pooled) if pooled else np.full(1, np.inf)
    return BorderScore(_quantile(every, 0.5), _quantile(every, 0.95), by_part)


def _quantile(values: np.ndarray, share: float) -> float:
    """Return a quantile that may be infinite: the smallest value that is not below the share of all."""
    return float(np.sort(values)[min(len(values) - 1, int(share * len(values)))])


def _distance(points: np.ndarray, others: np.ndarray) -> np.ndarray:
    if not len(others):
        return np.full(len(points), np.inf)
    return np.asarray(cKDTree(others).query(points)[0]).reshape(len(points))


def _find_contour(
    points: np.ndarray, edges: np.ndarray, labels: np.ndarray, part: int, over: Sequence[int] = (Part.HAIR, Part.OTHER)
) -> tuple[np.ndarray, np.ndarray]:
    """Find the points of a garment's contour and of its whole border [m]."""
    ends = labels[edges]
    inside = ends == part
    crossing = inside[:, 0] != inside[:, 1]
    middles = points[edges[crossing]].mean(axis=1)
    beyond = np.where(inside[crossing, 0], ends[crossing, 1], ends[crossing, 0])
    return middles[~np.isin(beyond, [int(each) for each in over])], middles
