"""The part of a surface's border beyond which another surface may continue."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .connectivity import HalfEdges
from .surface import ClosestPoints, TriangleSurface

RIM_STRIP_WIDTH = 0.01
"""Width of the strip along a rim that counts as the rim for points further away than it is wide [m]: a scan curls and
frays below another surface, and the point nearest to one ahead of the rim is then just inside."""
RIM_STRIP_SHARE = 0.5
"""Width of that strip as a share of a point's distance, where that is more: cloth that a coarse scan welds to the hem
over it is 2 cm wide, and any of its points may be nearest to what is hidden 12 cm above."""


@dataclass(frozen=True)
class Rim:
    """Describe edges and vertices of a surface's border at which a closest point means that the surface ends.

    Attributes:
        faces: The surface's faces, shape [face_count, 3].
        edges: Whether the edge opposite each corner is on the rim, shape [face_count, 3].
        vertices: Whether each vertex is on it, shape [vertex_count].
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
        # the half-edge opposite corner k follows the one that starts there
        return cls(faces, np.roll(edges.reshape(-1, 3), -1, axis=1), vertices)

    @classmethod
    def between(cls, faces: np.ndarray, marked: np.ndarray) -> Rim:
        """Return the rim of the border's edges between two marked vertices, bool, shape [vertex_count]."""
        half_edges = HalfEdges.of(faces, len(marked))
        border = half_edges.border
        return cls.of(half_edges, faces, border[marked[half_edges.tail[border]] & marked[half_edges.head[border]]])

    def contains(self, points: ClosestPoints) -> np.ndarray:
        """Check which closest points are on the rim, bool, shape [point_count]."""
        at_border = points.barycentric < 1e-6
        on_edge = (at_border & self.edges[points.face]).any(axis=1)
        corner = self.faces[points.face, np.argmax(points.barycentric, axis=1)]
        return np.asarray(on_edge | ((at_border.sum(axis=1) == 2) & self.vertices[corner]))

    def is_ahead(self, surface: TriangleSurface, points: ClosestPoints) -> np.ndarray:
        """Check which points are ahead of the surface's end, bool, shape [point_count].

        Their closest point is on the rim; or they are further than `RIM_STRIP_WIDTH` away, and it is within that of the
        rim or within `RIM_STRIP_SHARE` of their distance.

        Args:
            surface: The rim's surface.
            points: The surface's closest points to them.
        """
        from scipy.spatial import cKDTree

        contained = self.contains(points)
        outside = np.flatnonzero(~contained & (points.distance > RIM_STRIP_WIDTH))
        if len(outside) and self.vertices.any():
            inside = cKDTree(surface.vertices[self.vertices]).query(points.foot[outside])[0]
            contained[outside] = inside < np.maximum(RIM_STRIP_WIDTH, RIM_STRIP_SHARE * points.distance[outside])
        return contained
