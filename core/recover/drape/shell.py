"""Find distances to the exposed surface of a body in a pose, and to opposite surfaces near by."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ...body.signed_distance import SignedDistance
from ...body.solid import Solid
from ...geometry.geometry import edge_curvature, vertex_normals
from ...run.kernels import kernel
from .pbd import PbdSettings

OPPOSITE_CANDIDATE_COUNT = 12
"""Number of nearest vertices that are searched for an opposite surface: a disk of 3 cm around the nearest on bodies of
7000 vertices, wider than the 2 cm within which two surfaces touch the same cloth."""

OPPOSITE_NORMAL_COSINE = 0.3
"""Cosine between two normals below which they belong to two surfaces; on one limb it falls so low only 6 cm apart."""

SHELL_CONTACT_THICKNESS = PbdSettings.thickness
"""Distance that cloth keeps from each surface [m]; a gap of less than twice that is too narrow for it."""

MIN_HOLLOW_COSINE = 0.2
"""Smallest cosine between the bisector of a hollow and the normals of its surfaces: a wedge of 23 degrees. In narrower
ones the bisector is mostly noise, and the way out is computed as if they were as wide."""

MAX_CURVATURE_DISTANCE = 0.02
"""Tangential distance up to which a vertex's curvature is used [m]: the spacing of the body's vertices."""

MAX_BODY_CURVATURE = 50.0
"""Largest curvature used [1/m]: a finger's; sharper ones are creases of the mesh."""

OPPOSITE_REACH = PbdSettings.thickness + PbdSettings.travel + MAX_CURVATURE_DISTANCE
"""Distance of a point from the nearest vertex above which no opposite surface is searched [m]: cloth that far from the
nearest surface touches neither in a step. The last part is the spacing of the body's vertices."""

NO_SURFACE_DISTANCE = 1.0
"""Distance that is returned where there is no second surface [m]: beyond every contact."""


@dataclass(frozen=True)
class Shell:
    """Describe the exposed vertices of a body and their normals.

    Skin inside another part of the body (the armpit of a hanging arm, the groin of a seated body) must not push cloth:
    the nearest point of such a surface leads deeper into the body.

    Attributes:
        vertices: Positions [m], shape [n, 3].
        normals: Outward, unit length, shape [n, 3].
        bends: Mean curvature [1/m], positive where convex, shape [n].
        tree: Search tree of the vertices.
        clearance: Distance of a point from each vertex, its nearest, up to which no opposite vertex is among the
            candidates [m], shape [n]: half of what the nearest opposite vertex is further than the last candidate.
    """

    vertices: np.ndarray
    normals: np.ndarray
    bends: np.ndarray
    tree: cKDTree
    clearance: np.ndarray

    @classmethod
    def of(cls, vertices: np.ndarray, faces: np.ndarray, bare: np.ndarray | None = None) -> Shell:
        """Return the exposed vertices of a body's mesh (vertices [m], [n, 3]); `bare` marks them, computed if None."""
        normals = vertex_normals(vertices, faces)
        bare = Solid(vertices, faces).exposed(vertices, normals) if bare is None else bare
        bends = np.clip(edge_curvature(vertices, normals, faces), -MAX_BODY_CURVATURE, MAX_BODY_CURVATURE)
        return cls.of_points(vertices[bare], normals[bare], bends[bare])

    @classmethod
    def of_points(cls, vertices: np.ndarray, normals: np.ndarray, bends: np.ndarray) -> Shell:
        """Return the shell of positions [m], unit normals, shapes [n, 3], and mean curvatures [1/m], shape [n]."""
        tree = cKDTree(vertices)
        last = tree.query(vertices, k=min(OPPOSITE_CANDIDATE_COUNT, len(vertices)))[0][:, -1]
        opposite = _find_nearest_opposite(vertices, normals, last + 2 * OPPOSITE_REACH)
        return cls(vertices, normals, bends, tree, 0.5 * (opposite - last))

    def surfaces(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return the distance to the surface at the nearest vertex, and to an opposite surface near by.

        A surface is a paraboloid over the tangent plane of its vertex: at a tangential distance t it is lower than the
        plane by t^2 / 2 times its mean curvature. Planes alone would find gaps too narrow that are not. A surface is
        opposite if each of the two vertices is in front of the other's plane: across a gap or hollow.

        Args:
            points: Positions [m], shape [n, 3].

        Returns:
            Distances to both [m], shape [n], the second may be `NO_SURFACE_DISTANCE`, and their normals, shape [n, 3].
        """
        away, nearest = self.tree.query(points)
        normals = self.normals[nearest]
        heights = self._heights(points[:, None], nearest[:, None])[:, 0]
        second, opposite = np.full(len(points), NO_SURFACE_DISTANCE), normals.copy()
        near = np.flatnonzero((away < OPPOSITE_REACH) & (away >= self.clearance[nearest]))
        if len(near):
            second[near], opposite[near] = self._find_opposite(points[near], normals[near])
        return heights, second, normals, opposite

    def _heights(self, points: np.ndarray, index: np.ndarray) -> np.ndarray:
        """Return heights [m] of points, shape [n, 1, 3], over the paraboloids of vertices, shape [n, k]."""
        offset = points - self.vertices[index]
        heights = np.einsum("nkd,nkd->nk", offset, self.normals[index])
        aside = np.minimum(np.einsum("nkd,nkd->nk", offset, offset) - heights**2, MAX_CURVATURE_DISTANCE**2)
        found: np.ndarray = heights + 0.5 * self.bends[index] * aside
        return found

    def _find_opposite(self, points: np.ndarray, first: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return distances [m] to surfaces opposite the nearest, whose normals are `first`, and their normals."""
        _, index = self.tree.query(points, k=OPPOSITE_CANDIDATE_COUNT)
        normals, ahead = self.normals[index], self.vertices[index] - self.vertices[index[:, :1]]
        before = np.einsum("nkd,nd->nk", ahead, first) > 0
        behind = np.einsum("nkd,nkd->nk", ahead, normals) < 0
        facing = np.einsum("nkd,nd->nk", normals, first) < OPPOSITE_NORMAL_COSINE
        other = np.argmax(facing & before & behind, axis=1)
        row = np.arange(len(points))
        heights = self._heights(points[:, None], index[row, other][:, None])[:, 0]
        return np.where(other > 0, heights, NO_SURFACE_DISTANCE), normals[row, other]

    def measure(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the distances to both surfaces [m] and their gradients, shapes [2 n] and [2 n, 3]."""
        first, second, normal, opposite = self.surfaces(points)
        return self.open_hollows(first, second, normal, opposite, first, normal)

    @staticmethod
    def open_hollows(
        first: np.ndarray,
        second: np.ndarray,
        normal: np.ndarray,
        opposite: np.ndarray,
        distance: np.ndarray,
        gradient: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Replace distances in gaps too narrow for cloth, so that points leave along the bisector of both surfaces.

        Along m = (n_1 + n_2) / |n_1 + n_2| both distances grow by |n_1 + n_2| / 2 a metre, which divides the shortfall.
        """
        tight = first + second < 2 * SHELL_CONTACT_THICKNESS
        way_out = normal[tight] + opposite[tight]
        size = np.linalg.norm(way_out, axis=1)
        short = SHELL_CONTACT_THICKNESS - np.minimum(first, second)[tight]
        distance, gradient = distance.copy(), gradient.copy()
        distance[tight] = SHELL_CONTACT_THICKNESS - short / np.maximum(0.5 * size, MIN_HOLLOW_COSINE)
        gradient[tight] = way_out / np.maximum(size, 1e-9)[:, None]
        second = np.where(tight, NO_SURFACE_DISTANCE, second)
        return np.concatenate([distance, second]), np.concatenate([gradient, opposite])


def _find_nearest_opposite(vertices: np.ndarray, normals: np.ndarray, reach: np.ndarray) -> np.ndarray:
    """Return each vertex's distance to the nearest one of an opposite surface, or its `reach` where that is nearer
    [m], shape [n]."""
    column = np.floor(vertices[:, 0] / reach.max()).astype(np.int64)
    column -= column.min()
    order = np.lexsort((vertices[:, 1], column))
    starts = np.searchsorted(column[order], np.arange(column.max() + 2))
    found = np.zeros(len(vertices))
    found[order] = _search_columns(vertices[order], normals[order], reach[order], column[order], starts)
    return found


@kernel()
def _search_columns(vertices, normals, reach, column, starts):  # type: ignore[no-untyped-def]
    """Search the columns of vertices beside each vertex's own; those of a column ascend in height."""
    found = reach.copy()
    for i in range(len(vertices)):
        x, y, z = vertices[i, 0], vertices[i, 1], vertices[i, 2]
        u, v, w = normals[i, 0], normals[i, 1], normals[i, 2]
        for c in range(max(column[i] - 1, 0), min(column[i] + 2, len(starts) - 1)):
            first, end = starts[c], starts[c + 1]
            j = first + np.searchsorted(vertices[first:end, 1], y - found[i])
            while j < end and vertices[j, 1] < y + found[i]:
                dx, dy, dz = vertices[j, 0] - x, vertices[j, 1] - y, vertices[j, 2] - z
                length = np.sqrt(dx * dx + dy * dy + dz * dz)
                if length < found[i]:
                    p, q, r = normals[j, 0], normals[j, 1], normals[j, 2]
                    is_across = dx * u + dy * v + dz * w > 0.0 > dx * p + dy * q + dz * r
                    if is_across and u * p + v * q + w * r < OPPOSITE_NORMAL_COSINE:
                        found[i] = length
                j += 1
    return found


@dataclass(frozen=True)
class ShellDistance:
    """Describe a body's signed distance, with opposite surfaces and hollows from its shell.

    Attributes:
        shell: The exposed vertices.
        body: The same body, with a more accurate distance to the nearest surface.
    """

    shell: Shell
    body: SignedDistance

    def measure(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the distances to both surfaces [m] and their gradients, shapes [2 n] and [2 n, 3]."""
        distance, gradient = self.body.measure(points)
        first, second = np.full(len(points), NO_SURFACE_DISTANCE), np.full(len(points), NO_SURFACE_DISTANCE)
        normal, opposite = np.zeros_like(gradient), np.zeros_like(gradient)
        near = np.flatnonzero(distance < OPPOSITE_REACH)
        if len(near):
            first[near], second[near], normal[near], opposite[near] = self.shell.surfaces(points[near])
        return Shell.open_hollows(first, second, normal, opposite, distance, gradient)
