"""The outside of a body's given mesh: the skin that no other part of the body swallows."""

from __future__ import annotations

import numpy as np

from .body import Body
from .distance import is_inside_out

LIFT = 5e-4
"""How far above a face there must be air for it to be skin in the open [m]: the least distance that cloth keeps.
Nearer parts leave it no room."""

INSIDE = 0.5
"""Winding number above which a point is inside; holes and parts that overlap do no more than bend it near them."""

SPLITS = 2
"""Times that a face which a crease cuts is split in four: edges of 2 cm come down to 5 mm, which is how near the rim
of the open skin comes to the crease."""

WITHIN = 0.9
"""Share of the way from a face's middle to its corners at which it is asked whether it is in the open. At the corners
themselves the lift of a face of a hollow ends in the face beside it."""


class BodySurface:
    """Answer signed distances to the outside of a body mesh, positive outside, as often as is asked.

    Inside is where the winding number exceeds one half (the fast one, Barill et al. 2018). Where parts of a body run
    into each other (thighs, a belly over a lap), the skin of one lies inside the other: it is no way out, and the
    nearest point of it leads deeper. So the surface is the skin in the open, and a negative distance the length of the
    shortest way out, which `signed_distance` to the nearest skin of all may be far short of.

    Attributes:
        vertices: Positions [m], shape [vertex_count, 3].
        faces: The skin in the open, outward, faces that creases cut split along them, shape [face_count, 3].
        normals: Unit normals of `faces`, shape [face_count, 3].
    """

    def __init__(self, vertices: np.ndarray, faces: np.ndarray) -> None:
        import igl

        vertices = np.ascontiguousarray(vertices, dtype=np.float64)
        faces = np.ascontiguousarray(faces, dtype=np.int64)
        if is_inside_out(vertices, faces):
            faces = np.ascontiguousarray(faces[:, ::-1])
        self._winding = igl.FastWindingNumberBVH()
        self._winding.init(vertices, faces, 2)
        self.vertices, self.faces = self._keep_open(vertices, faces)
        self.normals = _face_normals(self.vertices, self.faces)
        self._tree = igl.AABB()
        self._tree.init(self.vertices, self.faces)

    @classmethod
    def of(cls, body: Body) -> BodySurface:
        """Take the outside of a body's own mesh, not of the fitted model."""
        return cls(body.vertices, body.faces)

    def _keep_open(self, vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Drop swallowed faces, and of those that are so in part what is; give vertices and faces."""
        kept, whole = [], faces
        mixed = self._beside_creases(vertices, faces)
        for turn in range(SPLITS + 1):
            bare = self._bare(vertices, faces, mixed)
            done = bare.all(axis=1) | ~bare.any(axis=1) | (turn == SPLITS)
            keep = done & bare[:, 0]
            kept.append(faces[keep])
            cut = np.flatnonzero(~done)
            if not len(cut):
                break
            vertices, faces = _split(vertices, faces[cut])
            mixed = np.ones(4 * len(cut), dtype=bool)
        found = np.concatenate(kept)
        # A mesh that encloses nothing has no inside: all of it is as good as any of it.
        return vertices, np.ascontiguousarray(found) if len(found) else whole

    def _beside_creases(self, vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
        """Tell which faces share a vertex with one in the open and with one that is not, shape [face_count]."""
        bare = self._bare(vertices, faces, np.zeros(len(faces), dtype=bool))[:, 0]
        touched = np.zeros((2, len(vertices)), dtype=bool)
        touched[0, faces[bare]] = touched[1, faces[~bare]] = True
        both = touched[0] & touched[1]
        return np.asarray(both[faces].any(axis=1))

    def _bare(self, vertices: np.ndarray, faces: np.ndarray, corners_too: np.ndarray) -> np.ndarray:
        """Tell of each face's middle, and of its corners where asked, whether it is in the open, shape [n, 4]."""
        corners = vertices[faces]
        middle, lift = corners.mean(axis=1), LIFT * _face_normals(vertices, faces)
        bare = np.repeat(~self.contains(middle + lift)[:, None], 4, axis=1)
        asked = np.flatnonzero(corners_too)
        if len(asked):
            near = middle[asked, None] + WITHIN * (corners[asked] - middle[asked, None]) + lift[asked, None]
            bare[asked, 1:] = ~self.contains(near.reshape(-1, 3)).reshape(-1, 3)
        return bare

    def contains(self, points: np.ndarray) -> np.ndarray:
        """Tell which points [m], shape [n, 3], are inside, shape [n]."""
        wound = self._winding.winding_number(np.ascontiguousarray(points, dtype=np.float64))
        return np.asarray(wound).reshape(-1) > INSIDE

    def closest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Give the closest points [m], shape [n, 3], and their rows of `faces`, shape [n]."""
        points = np.ascontiguousarray(points, dtype=np.float64)
        _, face, foot = self._tree.squared_distance(self.vertices, self.faces, points)
        return np.asarray(foot).reshape(-1, 3), np.asarray(face).reshape(-1)

    def measure(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Give the signed distance of points, and its gradient.

        On the surface itself, where the direction to the closest point is lost, the gradient is the normal of the
        closest face.

        Args:
            points: Positions [m], shape [n, 3].

        Returns:
            Distance [m], negative inside, shape [n]; gradient of unit length, shape [n, 3].
        """
        points = np.ascontiguousarray(points, dtype=np.float64).reshape(-1, 3)
        if not len(points):
            return np.zeros(0), np.zeros((0, 3))
        foot, face = self.closest(points)
        offset = points - foot
        distance = np.linalg.norm(offset, axis=1)
        sign = np.where(self.contains(points), -1.0, 1.0)
        gradient = self.normals[face]
        # Below a nanometre the difference of two positions of about 1 m has no direction left in float64.
        far = distance > 1e-9
        gradient[far] = offset[far] * (sign[far] / distance[far])[:, None]
        return sign * distance, gradient


def _face_normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    corners = vertices[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.asarray(normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300))


def _split(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Split each face in four at the middles of its edges; give the vertices with the middles, and those faces."""
    middles = 0.5 * (vertices[faces] + vertices[faces[:, [1, 2, 0]]])
    ab, bc, ca = (len(vertices) + 3 * np.arange(len(faces)) + k for k in range(3))
    a, b, c = faces.T
    parts = np.stack([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]])
    return np.concatenate([vertices, middles.reshape(-1, 3)]), np.ascontiguousarray(
        parts.transpose(2, 0, 1).reshape(-1, 3)
    )
