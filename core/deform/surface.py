"""Closest points: on a triangle surface (libigl's AABB tree) and on a closed curve."""

from __future__ import annotations

from dataclasses import dataclass

import igl
import numpy as np
from numba import njit


@dataclass(frozen=True)
class SurfacePoints:
    """Hold points on a triangle surface.

    Attributes:
        face: Face of each point, shape [point_count].
        weights: Barycentric coordinates, sum to 1, shape [point_count, 3].
    """

    face: np.ndarray
    weights: np.ndarray

    def of(self, values: np.ndarray, faces: np.ndarray) -> np.ndarray:
        """Interpolate vertex values at the points, shape [point_count, ...]."""
        return np.einsum("nk,nkd->nd", self.weights, values[faces[self.face]])


class Surface:
    """Answer closest-point queries on a fixed triangle mesh."""

    def __init__(self, vertices: np.ndarray, faces: np.ndarray) -> None:
        self.vertices = np.ascontiguousarray(vertices, dtype=np.float64)
        self.faces = np.ascontiguousarray(faces, dtype=np.int64)
        self._tree = igl.AABB()
        self._tree.init(self.vertices, self.faces)

    def closest(self, points: np.ndarray) -> SurfacePoints:
        """Find the closest surface point of each point [m], shape [point_count, 3]."""
        points = np.ascontiguousarray(points, dtype=np.float64)
        _, face, foot = self._tree.squared_distance(self.vertices, self.faces, points)
        face = np.asarray(face).reshape(-1)
        return SurfacePoints(face, barycentric(np.asarray(foot), self.vertices[self.faces[face]]))


def barycentric(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Give the barycentric coordinates, clipped to the triangle, of points in its plane, shape [point_count, 3]."""
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    offset = points - corners[:, 0]
    a, b, c = (first * first).sum(1), (first * second).sum(1), (second * second).sum(1)
    p, q = (first * offset).sum(1), (second * offset).sum(1)
    determinant = np.maximum(a * c - b * b, 1e-30)
    u = np.clip((c * p - b * q) / determinant, 0.0, 1.0)
    v = np.clip((a * q - b * p) / determinant, 0.0, 1.0)
    over = np.maximum(u + v, 1.0)
    u, v = u / over, v / over
    return np.stack([1 - u - v, u, v], axis=1)


@njit(cache=True)
def closest_on_curve(points, start, end):
    """Find the segment (start[i], end[i]) nearest to each point and the parameter in 0..1 along it."""
    count = points.shape[0]
    segment = np.zeros(count, np.int64)
    along = np.zeros(count)
    for i in range(count):
        best = np.inf
        for j in range(start.shape[0]):
            length = 0.0
            dot = 0.0
            for k in range(3):
                d = end[j, k] - start[j, k]
                length += d * d
                dot += d * (points[i, k] - start[j, k])
            t = min(max(dot / max(length, 1e-30), 0.0), 1.0)
            distance = 0.0
            for k in range(3):
                r = points[i, k] - start[j, k] - t * (end[j, k] - start[j, k])
                distance += r * r
            if distance < best:
                best = distance
                segment[i] = j
                along[i] = t
    return segment, along
