"""Move points with the triangles of a moving body."""

from __future__ import annotations

import numpy as np

from ...body.exposed import ExposedSurface
from ...geometry.geometry import unit


def move_with_triangles(points: np.ndarray, before: np.ndarray, after: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Move points as the triangles below them move.

    p' = f' + R (p - f): f the foot on the triangle, f' the same place later, R the rotation of (first edge, normal).

    Args:
        points: Positions [m], shape [n, 3].
        before: Corners of each point's triangle [m], shape [n, 3, 3].
        after: The same later [m].
        corners: Barycentric coordinates of each foot, shape [n, 3].
    """
    foot, later = (np.einsum("nk,nkd->nd", corners, each) for each in (before, after))
    local = np.einsum("nda,nd->na", _triangle_frames(before), points - foot)
    found: np.ndarray = later + np.einsum("nda,na->nd", _triangle_frames(after), local)
    return found


def move_anchors(anchors: np.ndarray, skin: ExposedSurface, later: np.ndarray) -> np.ndarray:
    """Move friction's anchors [m], shape [n, 3], with the skin below; `later` are its vertices after the step."""
    found = skin.closest(anchors)
    corners = skin.faces[found.face]
    return move_with_triangles(anchors, skin.vertices[corners], later[corners], found.barycentric)


def _triangle_frames(corners: np.ndarray) -> np.ndarray:
    """Return the frames of triangles as columns: first edge, its in-plane normal, normal; shape [n, 3, 3]."""
    edge = unit(corners[:, 1] - corners[:, 0])
    normal = unit(np.cross(edge, corners[:, 2] - corners[:, 0]))
    return np.stack([edge, np.cross(normal, edge), normal], axis=2)
