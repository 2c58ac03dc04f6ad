"""Exact signed distance to a body's given mesh."""

from __future__ import annotations

import numpy as np

from .body import Body


def signed_distance(body: Body, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Give the signed distance of points to a body, and its gradient.

    The distance is exact (closest point on a triangle, libigl). The sign comes from the fast winding number (Barill et
    al. 2018), negative where it is above one half, so that holes and intersections in the mesh do no more than bend the
    inside near them. On the surface itself, where the direction to the closest point is lost, the gradient is the
    normal of the closest face.

    Args:
        body: The body; its `vertices` and `faces` count, not the fitted model.
        points: Positions [m], shape [n, 3].

    Returns:
        Distance [m], negative inside, shape [n]; gradient of unit length, shape [n, 3].
    """
    import igl

    vertices = np.ascontiguousarray(body.vertices, dtype=np.float64)
    faces = np.ascontiguousarray(body.faces, dtype=np.int64)
    points = np.ascontiguousarray(points, dtype=np.float64).reshape(-1, 3)
    if not len(points):
        return np.zeros(0), np.zeros((0, 3))
    squared, face, closest = igl.point_mesh_squared_distance(points, vertices, faces)
    sign = np.where(igl.fast_winding_number(vertices, faces, points) > 0.5, -1.0, 1.0)
    distance = np.sqrt(np.atleast_1d(squared))
    corners = vertices[faces[np.atleast_1d(face)]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    # Below a nanometre the difference of two positions of about 1 m has no direction left in float64.
    far = distance > 1e-9
    gradient = normal.copy()
    gradient[far] = (points - closest.reshape(-1, 3))[far] * (sign[far] / distance[far])[:, None]
    return sign * distance, gradient
