"""Signed distance to the exact body mesh, with the direction out of it."""

from __future__ import annotations

import igl
import numpy as np

from .operators import face_vectors, half_edges, twins, unit
from .surface import Surface

ON_CORNER = 1e-9
"""Barycentric coordinate below which a closest point counts as lying on the edge or corner beside it."""

WINDING_REACH = 0.05
"""Distance beyond which a point that the pseudonormal calls outside is not asked for its winding number [m]."""


LIFT = 5e-4
"""How far above a face's middle there must be air for it to be skin in the open [m]: the distance that cloth keeps.
Nearer parts leave it no room."""


class BodyDistance:
    """Answer signed distances to a closed body mesh, positive outside.

    Inside is where the winding number exceeds one half, which stands small holes and parts that overlap (thighs, arms
    against the trunk). Skin that another part swallows is no way out, so only faces in the open are the surface that
    distances and directions are taken from. At the surface itself, where an offset has no direction, the way out is
    the angle-weighted pseudonormal (Baerentzen and Aanaes 2005). A mesh that is inside out is turned.
    """

    def __init__(self, vertices: np.ndarray, faces: np.ndarray) -> None:
        corner = vertices[faces]
        if np.einsum("ij,ij", corner[:, 0], np.cross(corner[:, 1], corner[:, 2])) < 0:
            faces = faces[:, ::-1]
        whole = Surface(vertices, faces)
        vertices, faces = whole.vertices, whole.faces
        self._winding = igl.FastWindingNumberBVH()
        self._winding.init(vertices, faces, 2)
        self._face = unit(face_vectors(vertices, faces))
        corner = vertices[faces]
        ahead = unit(np.roll(corner, -1, axis=1) - corner)
        back = unit(np.roll(corner, 1, axis=1) - corner)
        angle = np.arccos(np.clip((ahead * back).sum(2), -1.0, 1.0))
        self._corner = np.zeros_like(vertices)
        for k in range(3):
            np.add.at(self._corner, faces[:, k], angle[:, k, None] * self._face)
        self._corner = unit(self._corner)
        _, owner = half_edges(faces)
        pairs, _ = twins(faces)
        edge = self._face[owner]
        both = unit(edge[pairs[:, 0]] + edge[pairs[:, 1]])
        edge[pairs[:, 0]], edge[pairs[:, 1]] = both, both
        above = vertices[faces].mean(axis=1) + LIFT * self._face
        open_air = np.asarray(self._winding.winding_number(np.ascontiguousarray(above))).reshape(-1) <= 0.5
        self._surface = whole if open_air.all() else Surface(vertices, faces[open_air])
        self._face, self._edge = self._face[open_air], edge.reshape(-1, 3, 3)[open_air]

    def __call__(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Give signed distances [m], unit directions out of the body, and closest points [m]."""
        found = self._surface.closest(points)
        faces = self._surface.faces
        foot = found.of(self._surface.vertices, faces)
        normal = self._face[found.face].copy()
        inner = found.weights > ON_CORNER
        on = inner.sum(1)
        edge = np.flatnonzero(on == 2)
        normal[edge] = self._edge[found.face[edge], np.argmin(inner[edge], axis=1)]
        corner = np.flatnonzero(on == 1)
        normal[corner] = self._corner[faces[found.face[corner], np.argmax(inner[corner], axis=1)]]
        offset = points - foot
        distance = np.linalg.norm(offset, axis=1)
        sign = np.where((offset * normal).sum(1) >= 0, 1.0, -1.0)
        near = np.flatnonzero((distance < WINDING_REACH) | (sign < 0))
        if len(near):
            wound = self._winding.winding_number(np.ascontiguousarray(points[near], dtype=np.float64))
            sign[near] = np.where(np.asarray(wound).reshape(-1) > 0.5, -1.0, 1.0)
        # nearer than a micrometre the offset has no direction of its own
        direction = np.where((distance > 1e-6)[:, None], offset * (sign / np.maximum(distance, 1e-30))[:, None], normal)
        return sign * distance, direction, foot
