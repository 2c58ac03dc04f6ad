"""A triangle surface: closest points, normals, areas and samples."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from .connectivity import HalfEdges
from .geometry import area_vectors, face_areas, lump, unit, vertex_normals

if TYPE_CHECKING:
    import scipy.sparse as sp

    from .box_tree import BoxTree


@dataclass(frozen=True)
class ClosestPoints:
    """Describe the closest points of a triangle surface to query points.

    Attributes:
        foot: The points [m], shape [n, 3].
        face: Face of each, shape [n].
        barycentric: Coordinates in the face, 0 to 1, sum to 1, shape [n, 3].
        distance: Distance from the query point, not signed [m], shape [n].
    """

    foot: np.ndarray
    face: np.ndarray
    barycentric: np.ndarray
    distance: np.ndarray

    def interpolate(self, values: np.ndarray, faces: np.ndarray) -> np.ndarray:
        """Interpolate vertex values, shape [vertex_count, k], linearly at the points, shape [n, k]."""
        found: np.ndarray = np.einsum("nk,nkd->nd", self.barycentric, values[faces[self.face]])
        return found

    def interpolation(self, faces: np.ndarray, count: int) -> sp.csr_matrix:
        """Return the matrix of `interpolate` for `count` vertices, shape [n, count]."""
        import scipy.sparse as sp

        rows = np.repeat(np.arange(len(self.face)), 3)
        shape = (len(self.face), count)
        return sp.csr_matrix((self.barycentric.ravel(), (rows, faces[self.face].ravel())), shape)


class TriangleSurface:
    """Answer queries to a triangle mesh of vertices [m], shape [vertex_count, 3], and faces, shape [face_count, 3];
    search tree, normals and areas are computed on first use."""

    def __init__(self, vertices: np.ndarray, faces: np.ndarray) -> None:
        self.vertices = np.ascontiguousarray(vertices, dtype=np.float64)
        self.faces = np.ascontiguousarray(faces, dtype=np.int64)

    @cached_property
    def half_edges(self) -> HalfEdges:
        """Return the connectivity of the faces."""
        return HalfEdges.of(self.faces, len(self.vertices))

    @cached_property
    def face_normals(self) -> np.ndarray:
        """Return unit face normals, 0 for a face without area, shape [face_count, 3]."""
        return unit(area_vectors(self.vertices, self.faces))

    @cached_property
    def face_areas(self) -> np.ndarray:
        """Return face areas [m2], shape [face_count]."""
        return face_areas(self.vertices, self.faces)

    @cached_property
    def vertex_normals(self) -> np.ndarray:
        """Return unit area-weighted vertex normals, shape [vertex_count, 3]."""
        return vertex_normals(self.vertices, self.faces)

    @cached_property
    def vertex_areas(self) -> np.ndarray:
        """Return a third of the area of the faces around each vertex [m2], shape [vertex_count]."""
        return lump(self.face_areas, self.faces, len(self.vertices))

    @cached_property
    def border_faces(self) -> np.ndarray:
        """Mark faces with two corners or more on the border, shape [face_count]."""
        return np.asarray(self.half_edges.border_vertices[self.faces].sum(axis=1) > 1)

    def moved(self, vertices: np.ndarray) -> TriangleSurface:
        """Return the surface of the same faces with other vertices [m], shape [vertex_count, 3]; connectivity and the
        order of the search tree are those of this one."""
        found = TriangleSurface(vertices, self.faces)
        for name in ("half_edges", "border_faces"):
            if name in self.__dict__:
                found.__dict__[name] = self.__dict__[name]
        found.__dict__["_tree"] = self._tree.refit(found.vertices)
        return found

    def closest(self, points: np.ndarray, hints: np.ndarray | None = None) -> ClosestPoints:
        """Find the closest point of the surface to each point [m], shape [n, 3]; exact.

        Args:
            points: Positions.
            hints: Face of each that is near, such as the one found before, shape [n]. It saves time; of several equally
                near faces another one may be found.
        """
        distance, face, foot, coordinates = self._tree.search(_as_points(points), hints)
        return ClosestPoints(foot, face, coordinates, distance)

    def normals_at(self, found: ClosestPoints) -> np.ndarray:
        """Return the unit vertex normals interpolated at closest points, shape [n, 3]. On an edge they do not depend on
        which of its faces was found."""
        return unit(found.interpolate(self.vertex_normals, self.faces))

    def distance(self, points: np.ndarray) -> np.ndarray:
        """Compute the unsigned distances [m], shape [n], of points [m], shape [n, 3], from the surface."""
        return self._tree.search(_as_points(points))[0]

    def heights(self, points: np.ndarray) -> np.ndarray:
        """Compute the heights of points [m], shape [n, 3], over their closest points along the vertex normals
        interpolated there; negative inside, shape [n]."""
        found = self.closest(points)
        normals = found.interpolate(self.vertex_normals, self.faces)
        return np.asarray(((points - found.foot) * normals).sum(axis=1))

    def sample(self, count: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        """Draw points uniformly by area: one in each equal slice of the area, with less scatter than independent draws.

        Args:
            count: Number of points.
            rng: The same state draws the same points.

        Returns:
            The points [m], shape [count, 3], and the face of each, shape [count].
        """
        cumulative = np.cumsum(self.face_areas)
        slices = (np.arange(count) + rng.random(count)) / count * cumulative[-1]
        face = np.minimum(np.searchsorted(cumulative, slices, side="right"), len(self.faces) - 1)
        root = np.sqrt(rng.random(count))[:, None]
        along = rng.random(count)[:, None]
        a, b, c = (self.vertices[self.faces[face, k]] for k in range(3))
        return (1.0 - root) * a + root * (1.0 - along) * b + root * along * c, face

    @cached_property
    def _tree(self) -> BoxTree:
        from .box_tree import BoxTree

        return BoxTree(self.vertices, self.faces)


def _as_points(points: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(points, dtype=np.float64).reshape(-1, 3)


def barycentric_coordinates(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Compute barycentric coordinates of points in the planes of triangles, clipped to 0..1 against rounding.

    Equation: p = a + u (b - a) + v (c - a), solved by the 2 x 2 normal equations; coordinates (1 - u - v, u, v).

    Args:
        points: Positions [m], shape [n, 3].
        corners: The triangle of each point [m], shape [n, 3, 3].

    Returns:
        Shape [n, 3]; the first corner's for a triangle without area.
    """
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    offset = points - corners[:, 0]
    a, b, c = (first * first).sum(1), (first * second).sum(1), (second * second).sum(1)
    p, q = (first * offset).sum(1), (second * offset).sum(1)
    determinant = np.maximum(a * c - b * b, 1e-30)
    u, v = (c * p - b * q) / determinant, (a * q - b * p) / determinant
    found: np.ndarray = np.clip(np.stack([1 - (u + v), u, v], axis=1), 0.0, 1.0)
    return found
