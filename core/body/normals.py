"""Normals of a triangle mesh."""

from __future__ import annotations

import numpy as np


def face_normals(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Give unit face normals, shape [face_count, 3], and face areas [m2], shape [face_count].

    The normal of a face without area is zero.
    """
    cross = _cross(vertices, faces)
    twice = np.linalg.norm(cross, axis=1)
    normals = np.divide(cross, twice[:, None], out=np.zeros_like(cross), where=twice[:, None] > 0.0)
    return normals, 0.5 * twice


def vertex_normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Give unit vertex normals, area-weighted, shape [vertex_count, 3]; zero where a vertex has no area."""
    cross, total = _cross(vertices, faces), np.zeros_like(vertices)
    for k in range(3):
        np.add.at(total, faces[:, k], cross)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return np.asarray(total / np.where(length > 0.0, length, 1.0))


def _cross(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Give each face's normal times twice its area [m2], shape [face_count, 3]."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return np.cross(b - a, c - a)
