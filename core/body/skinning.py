"""Map points between the rest pose and the pose of a body by linear blend skinning."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..geometry.geometry import face_areas
from .body import Body

SMOOTHING_LENGTH = 0.03
"""Width [m] over which weights around a body are blended: about a finger's width, less than half a wrist's, so that
cloth under an arm does not jump from the arm's bone to the trunk's between neighbouring vertices."""


def blend(weights: np.ndarray, transforms: np.ndarray) -> np.ndarray:
    """Return each point's own transform, the weighted mean of the joints', shape [n, 4, 4]."""
    found: np.ndarray = (weights @ transforms.reshape(len(transforms), 16)).reshape(-1, 4, 4)
    return found


def skin(points: np.ndarray, weights: np.ndarray, transforms: np.ndarray) -> np.ndarray:
    """Map points from rest space into the pose.

    Args:
        points: Positions in rest space [m], shape [n, 3].
        weights: Skinning weights, rows sum to 1, shape [n, 24].
        transforms: From rest space to the pose, shape [24, 4, 4].

    Returns:
        Positions in the pose [m], shape [n, 3].
    """
    blended = blend(weights, transforms)
    found: np.ndarray = np.einsum("nab,nb->na", blended[:, :3, :3], points) + blended[:, :3, 3]
    return found


def unskin(points: np.ndarray, weights: np.ndarray, transforms: np.ndarray) -> np.ndarray:
    """Map points from the pose back into rest space: the exact inverse of `skin` at the same weights."""
    blended = blend(weights, transforms)
    return np.linalg.solve(blended[:, :3, :3], (points - blended[:, :3, 3])[..., None])[..., 0]


def weights_at(body: Body, points: np.ndarray, rest: bool) -> np.ndarray:
    """Compute smooth skinning weights for points around a body.

    The surface's weights are averaged with Gaussian weights of width `SMOOTHING_LENGTH` plus half the point's distance
    to the body, so that they blend more the further the cloth is from the body.

    Args:
        body: The body.
        points: Positions [m], shape [n, 3].
        rest: True for points around the rest pose (T-pose), False around the body's own pose.

    Returns:
        Weights, rows sum to 1, shape [n, 24].
    """
    from scipy.sparse import csr_matrix
    from scipy.spatial import cKDTree

    vertices, faces, weights = (
        (body.rest_vertices, body.rest_faces, body.rest_weights) if rest else (body.vertices, body.faces, body.weights)
    )
    centres, area = vertices[faces].mean(axis=1), face_areas(vertices, faces)
    values = weights[faces].mean(axis=1)
    # 128 faces of 1.5 cm cover a disk of 10 cm radius: three widths of the blend.
    reach = min(128, len(centres))
    distance, index = cKDTree(centres).query(points, k=reach)
    distance, index = distance.reshape(len(points), reach), index.reshape(len(points), reach)
    nearest = distance[:, :1]
    width = SMOOTHING_LENGTH + 0.5 * nearest
    # The nearest squared distance is subtracted so that far points do not underflow.
    gauss = area[index] * np.exp(-(distance**2 - nearest**2) / (2 * width**2))
    gauss /= gauss.sum(axis=1, keepdims=True)
    # As a sparse product: gathering the weights of every face within reach would take 25 kB per point.
    rows = np.arange(0, gauss.size + 1, reach)
    found: np.ndarray = csr_matrix((gauss.ravel(), index.ravel(), rows), shape=(len(points), len(centres))) @ values
    return found


def rest_body(body: Body) -> Body:
    """Return the fitted model in its T-pose as a body of its own: feet at y = 0, facing +z, transforms identity."""
    return replace(
        body,
        vertices=body.rest_vertices,
        faces=body.rest_faces,
        joints=body.rest_joints,
        weights=body.rest_weights,
        transforms=np.tile(np.eye(4), (24, 1, 1)),
        heading=np.eye(3),
        fit_rms=0.0,
    )
