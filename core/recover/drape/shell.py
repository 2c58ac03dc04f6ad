"""The outside of a body in a pose: the skin that another part of the body does not swallow, quick to look up."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ...body.signed_distance import SignedDistance
from ...body.solid import Solid
from ...geometry.geometry import edge_curvature, vertex_normals
from .follow import PbdSettings

OPPOSITE_CANDIDATE_COUNT = 12
"""Number of nearest vertices that are searched for an opposite surface: a disk of 3 cm around the nearest on bodies of
7000 vertices, wider than the 2 cm within which two surfaces touch the same cloth."""

OPPOSITE_NORMAL_COSINE = 0.3
"""Cosine between two normals below which they belong to two surfaces; on one limb it falls so low only 6 cm apart."""

SHELL_CONTACT_THICKNESS = PbdSettings.thickness
"""Distance that cloth keeps from each surface [m]; a gap of less than twice that is too narrow for it."""

MIN_HOLLOW_COSINE = 0.2
"""Smallest cosine between the bisector of a hollow and the normals of its surfaces: a wedge of 23 degrees. In narrower
ones the bisector is mostly noise, and the way out is measured as if they were as wide."""

MAX_CURVATURE_DISTANCE = 0.02
"""Tangential distance up to which a vertex's curvature is trusted [m]: the spacing of the body's vertices."""

MAX_BODY_CURVATURE = 50.0
"""Largest curvature used [1/m]: a finger's; what is sharper is a crease of the mesh."""

NO_SURFACE_DISTANCE = 1.0
"""Distance that is returned where there is no second surface [m]: beyond every contact."""


@dataclass(frozen=True)
class Shell:
    """Describe the vertices of a body that are in the open, and their normals.

    Where skin passes into skin (the armpit of a hanging arm, the groin of a seated body) it pushes cloth no longer: the
    nearest point of a swallowed surface leads deeper into the body.

    Attributes:
        vertices: Positions [m], shape [n, 3].
        normals: Outward, unit length, shape [n, 3].
        bends: Mean curvature [1/m], positive where convex, shape [n].
        tree: Finds the nearest of them.
    """

    vertices: np.ndarray
    normals: np.ndarray
    bends: np.ndarray
    tree: cKDTree

    @classmethod
    def of(cls, vertices: np.ndarray, faces: np.ndarray, bare: np.ndarray | None = None) -> Shell:
        """Keep the open vertices of a body's mesh (vertices [m], [n, 3]); `bare` tells which they are, where known."""
        normals = vertex_normals(vertices, faces)
        bare = Solid(vertices, faces).exposed(vertices, normals) if bare is None else bare
        bends = np.clip(edge_curvature(vertices, normals, faces), -MAX_BODY_CURVATURE, MAX_BODY_CURVATURE)
        return cls(vertices[bare], normals[bare], bends[bare], cKDTree(vertices[bare]))

    def surfaces(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return the distance to the surface at the nearest vertex, and to an opposite surface near by.

        A surface is a paraboloid over the tangent plane of its vertex: at a tangential distance t it is lower than
        the plane by t^2 / 2 times its mean curvature. Planes alone find gaps too narrow that are not.

        A surface is opposite where each of the two vertices lies in front of the other's plane: across a gap or in the
        hollow of a joint, never around the edge of one limb.

        Args:
            points: Positions [m], shape [n, 3].

        Returns:
            Distances to both [m], shape [n], the second one `NO_SURFACE_DISTANCE` where there is none, and their
            normals, [n, 3].
        """
        _, index = self.tree.query(points, k=OPPOSITE_CANDIDATE_COUNT)
        normals = self.normals[index]
        offset = points[:, None] - self.vertices[index]
        heights = np.einsum("nkd,nkd->nk", offset, normals)
        aside = np.minimum(np.einsum("nkd,nkd->nk", offset, offset) - heights**2, MAX_CURVATURE_DISTANCE**2)
        heights = heights + 0.5 * self.bends[index] * aside
        ahead = self.vertices[index] - self.vertices[index[:, :1]]
        before = np.einsum("nkd,nd->nk", ahead, normals[:, 0]) > 0
        behind = np.einsum("nkd,nkd->nk", ahead, normals) < 0
        facing = np.einsum("nkd,nd->nk", normals, normals[:, 0]) < OPPOSITE_NORMAL_COSINE
        other = np.argmax(facing & before & behind, axis=1)
        row = np.arange(len(points))
        return (
            heights[:, 0],
            np.where(other > 0, heights[row, other], NO_SURFACE_DISTANCE),
            normals[:, 0],
            normals[row, other],
        )

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
        """Push points out of gaps too narrow for cloth along the bisector of both surfaces, not from one to the other.

        Along m = (n_1 + n_2) / |n_1 + n_2| both distances grow by |n_1 + n_2| / 2 a metre, so the way out of a hollow
        in which one is d short is d over that.
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


@dataclass(frozen=True)
class ShellDistance:
    """A body's signed distance with the opposite surfaces and the hollows that it blurs, which its shell knows.

    Attributes:
        shell: The vertices in the open.
        body: The same body, its nearest surface better known.
    """

    shell: Shell
    body: SignedDistance

    def measure(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the distances to both surfaces [m] and their gradients, shapes [2 n] and [2 n, 3]."""
        distance, gradient = self.body.measure(points)
        return Shell.open_hollows(*self.shell.surfaces(points), distance, gradient)
