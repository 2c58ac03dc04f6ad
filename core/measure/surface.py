"""Angles and stretches of a mesh's faces."""

from __future__ import annotations

import numpy as np


def face_angles(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Give the three inner angles of each face [rad], shape [face_count, 3]."""
    corners = vertices[faces]
    angles = np.zeros((len(faces), 3))
    for k in range(3):
        u = corners[:, (k + 1) % 3] - corners[:, k]
        v = corners[:, (k + 2) % 3] - corners[:, k]
        angles[:, k] = np.arctan2(np.linalg.norm(np.cross(u, v), axis=1), np.einsum("ij,ij->i", u, v))
    return angles


def stretches(nodes: np.ndarray, faces: np.ndarray, rest: np.ndarray) -> np.ndarray:
    """Give the singular values of each face's map from its flat rest triangle, larger first, shape [face_count, 2].

    Equation: F = Ds Dm^-1, with Ds = [x1 - x0, x2 - x0] in space and Dm the same in the pattern (thesis 2.7.3).

    Args:
        nodes: Positions in space [m], shape [node_count, 3].
        faces: Node indices, shape [face_count, 3].
        rest: Flat rest triangles [m], shape [face_count, 3, 2].
    """
    corners = nodes[faces]
    spatial = np.stack([corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]], axis=2)
    flat = np.stack([rest[:, 1] - rest[:, 0], rest[:, 2] - rest[:, 0]], axis=2)
    gradient = spatial @ np.linalg.inv(flat)
    # Singular values from the 2 x 2 Cauchy-Green tensor: exact, and much quicker than an SVD of each face.
    cauchy = np.swapaxes(gradient, 1, 2) @ gradient
    half_trace = 0.5 * (cauchy[:, 0, 0] + cauchy[:, 1, 1])
    radius = np.hypot(0.5 * (cauchy[:, 0, 0] - cauchy[:, 1, 1]), cauchy[:, 0, 1])
    larger = np.sqrt(half_trace + radius)
    determinant = np.linalg.norm(np.cross(gradient[:, :, 0], gradient[:, :, 1]), axis=1)
    smaller = np.divide(determinant, larger, out=np.zeros_like(larger), where=larger > 0.0)
    return np.stack([larger, smaller], axis=1)
