"""The oracle of signed distances: to the nearest skin of a mesh, swallowed or not, sign by the winding number."""

from __future__ import annotations

from typing import Any

import igl
import numpy as np
from garmentq.core.body.solid import Solid
from garmentq.core.geometry.geometry import face_normals


def signed_distance(body: Any, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return exact distances [m], negative inside, and unit gradients of points [m], shape [n, 3], to a body's mesh."""
    solid = Solid(body.vertices, body.faces)
    points = np.ascontiguousarray(points, dtype=np.float64).reshape(-1, 3)
    if not len(points):
        return np.zeros(0), np.zeros((0, 3))
    squared, face, closest = igl.point_mesh_squared_distance(points, solid.vertices, solid.faces)
    sign = np.where(solid.contains(points), -1.0, 1.0)
    distance = np.sqrt(np.atleast_1d(squared))
    gradient, _ = face_normals(solid.vertices, solid.faces[np.atleast_1d(face)])
    far = distance > 1e-9
    gradient[far] = (points - closest.reshape(-1, 3))[far] * (sign[far] / distance[far])[:, None]
    return sign * distance, gradient
