"""The part of a surface's border beyond which another surface may go on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .connectivity import HalfEdges
from .surface import ClosestPoints, TriangleSurface

RIM_STRIP_WIDTH = 0.01
"""Width of the strip along a rim that counts as the rim for points farther away than it is wide [m]: a scan curls and
frays where another surface lies over it, and a point ahead of the rim is then nearest to a place just inside."""
RIM_STRIP_SHARE = 0.5
"""Width of the strip along a rim as a share of a point's distance, where that is more than `RIM_STRIP_WIDTH`: cloth
that bends away to the hem of what lies over it, welded to that by a coarse scan, is 2 cm wide; what is hidden 12 cm
above is nearest to any place of it."""


@dataclass(frozen=True)
class Rim:
    """Edges and vertices of a surface's border at which a closest point means that the surface ends.

    Attributes:
        faces: The surface's faces, shape [face_count, 3].
        edges: True where the edge opposite each corner lies on the rim, shape [face_count, 3].
        vertices: True for the vertices on it, shape [vertex_count].
    """

    faces: np.ndarray
    edges: np.ndarray
    vertices: np.ndarray

    @classmethod
    def of(cls, half_edges: HalfEdges, faces: np.ndarray, chosen: np.ndarray) -> Rim:
        """Return the rim of some half-edges of the border, given by their indices."""
        vertices = np.zeros(half_edges.vertex_count, dtype=bool)
        vertices[half_edges.tail[chosen]] = vertices[half_edges.head[chosen]] = True
        edges = np.zeros(3 * len(faces), dtype=bool)
        edges[chosen] = True
        # the half-edge opposite corner k is the one after that which leaves it
        return cls(faces, np.roll(edges.reshape(-1, 3), -1, axis=1), vertices)

    @classmethod
    def between(cls, faces: np.ndarray, marked: np.ndarray) -> Rim:
        """Return the rim of the border's edges between two marked vertices, bool, shape [vertex_count]."""
        half_edges = HalfEdges.of(faces, len(marked))
        border = half_edges.border
        return cls.of(half_edges, faces, border[marked[half_edges.tail[border]] & marked[half_edges.head[border]]])

    def holds(self, points: ClosestPoints) -> np.ndarray:
        """Check which closest points lie on the rim, bool, shape [point_count]."""
        near = points.barycentric < 1e-6
        on_edge = (near & self.edges[points.face]).any(axis=1)
        corner = self.faces[points.face, np.argmax(points.barycentric, axis=1)]
        return np.asarray(on_edge | ((near.sum(axis=1) == 2) & self.vertices[corner]))

    def lies_ahead(self, surface: TriangleSurface, points: ClosestPoints) -> np.ndarray:
        """Check which points the surface ends before, bool, shape [point_count].

        Those whose closest point is on the rim; and of those farther away than `RIM_STRIP_WIDTH`, whose closest point
        is as near to it, or within `RIM_STRIP_SHARE` of how far away they are.

        Args:
            surface: The rim's surface.
            points: Its points that are closest to those.
        """
        from scipy.spatial import cKDTree

        ahead = self.holds(points)
        far = np.flatnonzero(~ahead & (points.distance > RIM_STRIP_WIDTH))
        if len(far) and self.vertices.any():
            inside = cKDTree(surface.vertices[self.vertices]).query(points.foot[far])[0]
            ahead[far] = inside < np.maximum(RIM_STRIP_WIDTH, RIM_STRIP_SHARE * points.distance[far])
        return ahead
