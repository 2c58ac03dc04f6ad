"""Exact signed distance to a body's given mesh."""

from __future__ import annotations

import numpy as np

from ..mesh import face_normals
from .body import Body
from .solid import Solid


def signed_distance(body: Body, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Give the signed distance of points to a body, and its gradient.

    The distance is exact (closest point on a triangle, libigl), negative inside (`Solid`). On the surface itself, where
    the direction to the closest point is lost, the gradient is the normal of the closest face.

    Args:
        body: The body; its `vertices` and `faces` count, not the fitted model.
        points: Positions [m], shape [n, 3].

    Returns:
        Distance [m], negative inside, shape [n]; gradient of unit length, shape [n, 3].
    """
    import igl

    solid = Solid(body.vertices, body.faces)
    points = np.ascontiguousarray(points, dtype=np.float64).reshape(-1, 3)
    if not len(points):
        return np.zeros(0), np.zeros((0, 3))
    squared, face, closest = igl.point_mesh_squared_distance(points, solid.vertices, solid.faces)
    sign = np.where(solid.contains(points), -1.0, 1.0)
    distance = np.sqrt(np.atleast_1d(squared))
    gradient, _ = face_normals(solid.vertices, solid.faces[np.atleast_1d(face)])
    # Below a nanometre the difference of two positions of about 1 m has no direction left in float64.
    far = distance > 1e-9
    gradient[far] = (points - closest.reshape(-1, 3))[far] * (sign[far] / distance[far])[:, None]
    return sign * distance, gradient
