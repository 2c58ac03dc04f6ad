"""The exposed skin of a body: the part of its mesh that lies inside no other part of the body."""

from __future__ import annotations

from copy import copy
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..geometry.geometry import face_normals
from ..geometry.surface import ClosestPoints, TriangleSurface
from .body import Body
from .solid import Solid

CREASE_SUBDIVISION_COUNT = 2
"""Number of times that a face crossed by a crease is split in four: from 2 cm to 5 mm, the error of the border."""

CORNER_SAMPLE_SHARE = 0.9
"""Share of the way from a face's centre to its corners at which exposure is tested; in a hollow, corners would fail."""

CERTAIN_OUTSIDE_COSINE = 0.97
"""Cosine between the way to a point and the normal at its foot above which the point is outside without a further test,
away from creases. From a point inside, the nearest skin faces away."""

SKIN_BOX_MARGIN = 0.15
"""Margin around given points within which skin is tested for exposure [m]: cloth's distance plus a step's motion."""

CREASE_RING_COUNT = 3
"""Number of edges around hidden skin within which every point's side is tested. Beside a crease the skin in front of a
point may be exposed while the part that contains the point is taken for hidden."""


class ExposedSurface:
    """Describe the exposed skin of a body mesh, for repeated queries of signed distances to it, positive outside.

    Where parts of a body intersect (thighs, a belly over a lap), the skin of one is inside the other: the nearest point
    of such skin leads deeper, not out. So the surface is the exposed skin alone. A negative distance is the shortest
    way out, which may be much longer than the distance to the nearest skin of all.

    Args:
        vertices: Positions [m], shape [vertex_count, 3].
        faces: The body's mesh, shape [face_count, 3].
        splits: Times that a face crossed by a crease is split in four; 0 classifies it whole by its centre.
        near: Points [m], shape [n, 3], around which queries will be. Skin further than `SKIN_BOX_MARGIN` from their box
            is assumed to be exposed, which saves half of the time. None: all skin is tested.

    Attributes:
        vertices: Positions [m], shape [vertex_count, 3].
        faces: The exposed skin, outward, split along creases, shape [face_count, 3].
        normals: Unit normals of `faces`, shape [face_count, 3].
    """

    def __init__(
        self,
        vertices: np.ndarray,
        faces: np.ndarray,
        splits: int = CREASE_SUBDIVISION_COUNT,
        measured: np.ndarray | None = None,
    ) -> None:
        self._solid, self._near = Solid(vertices, faces), measured
        self._strict: ExposedSurface | None = None
        split_vertices, kept, self._parents = self._keep_open(splits)
        self._surface = TriangleSurface(split_vertices, kept)
        self.vertices, self.faces = self._surface.vertices, self._surface.faces
        self.normals = self._surface.face_normals

    @classmethod
    def of(cls, body: Body, splits: int = CREASE_SUBDIVISION_COUNT) -> ExposedSurface:
        """Compute the exposed skin of a body's own mesh, not of the fitted model."""
        return cls(body.vertices, body.faces, splits)

    @cached_property
    def whole(self) -> ExposedSurface:
        """Return the same skin with faces that creases cross classified whole, by their centres."""
        if self._strict is not None:
            return self._strict.whole.sparing_pinched
        return ExposedSurface(self._solid.vertices, self._solid.faces, splits=0, measured=self._near)

    @cached_property
    def sparing_pinched(self) -> ExposedSurface:
        """Return the same skin with points that the body's parts pinch counted as outside. Their distance is half the
        excess of the way to exposed skin over that to hidden skin: how far they can move and stay pinched."""
        other = copy(self)
        other.__dict__.pop("whole", None)  # the copy has one of its own
        other._strict = self
        return other

    @cached_property
    def hidden_skin(self) -> TriangleSurface | None:
        """Return the hidden skin: that of intersecting parts, where it is inside the body; None where there is none."""
        if self._strict is not None:
            return self._strict.hidden_skin
        solid = self._solid
        inside = ~self._bare
        return TriangleSurface(solid.vertices, solid.faces[inside]) if inside.any() else None

    @cached_property
    def _bare(self) -> np.ndarray:
        """Return which faces of the given mesh have exposed centres, shape [n]."""
        return self._bare_middles(self._solid.vertices, self._solid.faces)

    @cached_property
    def _creased(self) -> np.ndarray:
        """Return which of `faces` are, or were split from, a face beside hidden skin, shape [n]."""
        faces = self._solid.faces
        beside = np.zeros(len(self._solid.vertices), dtype=bool)
        beside[faces[~self._bare]] = True
        for _ in range(CREASE_RING_COUNT):
            beside[faces[beside[faces].any(axis=1)]] = True
        creased = np.asarray(beside[faces].any(axis=1))
        return np.asarray(creased[self._parents])

    def _keep_open(self, splits: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Drop hidden faces and the hidden parts of faces that creases cross; return vertices, faces, and the indices
        of the given faces that these are or were split from."""
        vertices, faces = self._solid.vertices, self._solid.faces
        bare, parents = self._bare, np.arange(len(faces))
        mixed = _find_crease_faces(vertices, faces, bare)
        kept, origins = [], []
        for _ in range(splits):
            corners = self._bare_corners(vertices, faces[mixed])
            cut = mixed[(corners != bare[mixed, None]).any(axis=1)]
            whole = np.setdiff1d(np.flatnonzero(bare), cut)
            kept.append(faces[whole])
            origins.append(parents[whole])
            vertices, faces = _split(vertices, faces[cut])
            parents = np.repeat(parents[cut], 4)
            bare, mixed = self._bare_middles(vertices, faces), np.arange(len(faces))
        found, origin = np.concatenate([*kept, faces[bare]]), np.concatenate([*origins, parents[bare]])
        if not len(found):  # A mesh that encloses nothing has no inside; all of it is exposed.
            found, origin = self._solid.faces, np.arange(len(self._solid.faces))
        return vertices, np.ascontiguousarray(found), origin

    def _bare_middles(self, vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
        """Return which faces' centres are exposed, shape [n]."""
        middles, normals = vertices[faces].mean(axis=1), face_normals(vertices, faces)[0]
        if self._near is None:
            return self._solid.exposed(middles, normals)
        low, high = self._near.min(axis=0) - SKIN_BOX_MARGIN, self._near.max(axis=0) + SKIN_BOX_MARGIN
        queried = ((middles >= low) & (middles <= high)).all(axis=1)
        bare = np.ones(len(faces), dtype=bool)
        bare[queried] = self._solid.exposed(middles[queried], normals[queried])
        return bare

    def _bare_corners(self, vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
        """Return which of the faces' corners are exposed, shape [n, 3]."""
        middle = vertices[faces].mean(axis=1, keepdims=True)
        samples = middle + CORNER_SAMPLE_SHARE * (vertices[faces] - middle)
        normals = np.repeat(face_normals(vertices, faces)[0], 3, axis=0)
        return self._solid.exposed(samples.reshape(-1, 3), normals).reshape(-1, 3)

    def contains(self, points: np.ndarray) -> np.ndarray:
        """Return which points [m], shape [n, 3], are inside, shape [n]."""
        return self._solid.contains(points)

    def depths(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the inside ones of points [m], shape [n, 3], and the lengths of their ways to the exposed skin [m]."""
        distance, _ = self.measure(points)
        return points[distance < 0.0], -distance[distance < 0.0]

    def pinch(self, inside: np.ndarray, distance: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Find which points inside the body are pinched by its parts.

        A point is pinched if it is nearer to hidden than to exposed skin: between intersecting parts, outside of none.

        Args:
            inside: Points [m], shape [n, 3].
            distance: Their distances to the exposed skin [m], shape [n].

        Returns:
            Which are pinched, shape [n], and their distances to hidden skin [m], infinite where there is none.
        """
        hidden_skin = self.hidden_skin
        if hidden_skin is None or not len(inside):
            return np.zeros(len(inside), dtype=bool), np.full(len(inside), np.inf)
        depth = hidden_skin.distance(inside)
        return depth < distance, depth

    def closest(self, points: np.ndarray) -> ClosestPoints:
        """Find the closest points of the exposed skin to points [m], shape [n, 3]."""
        return self._surface.closest(points)

    def measure(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Compute the signed distance of points, and its gradient.

        On the surface itself, where the direction to the closest point is undefined, the gradient is the face's normal.

        Args:
            points: Positions [m], shape [n, 3].

        Returns:
            Distance [m], negative inside, shape [n]; gradient of unit length, shape [n, 3].
        """
        points = np.ascontiguousarray(points, dtype=np.float64).reshape(-1, 3)
        if not len(points):
            return np.zeros(0), np.zeros((0, 3))
        found = self.closest(points)
        offset = points - found.foot
        distance = np.linalg.norm(offset, axis=1)
        gradient, sign = self.normals[found.face], np.ones(len(points))
        doubtful = np.flatnonzero(
            self._creased[found.face] | ((offset * gradient).sum(axis=1) < CERTAIN_OUTSIDE_COSINE * distance)
        )  # the winding number of a point costs more than its foot
        sign[doubtful] = np.where(self.contains(points[doubtful]), -1.0, 1.0)
        # Below a nanometre, the difference of two positions of about 1 m has no accurate direction in float64.
        is_far = distance > 1e-9
        gradient[is_far] = offset[is_far] * (sign[is_far] / distance[is_far])[:, None]
        signed = sign * distance
        if self._strict is not None:
            inside = np.flatnonzero(signed < 0.0)
            pinched, depth = self.pinch(points[inside], distance[inside])
            signed[inside[pinched]] = 0.5 * (distance[inside] - depth)[pinched]
        return signed, gradient


def _find_crease_faces(vertices: np.ndarray, faces: np.ndarray, bare: np.ndarray) -> np.ndarray:
    """Find the faces that share vertices with both exposed and hidden faces."""
    touched = np.zeros((2, len(vertices)), dtype=bool)
    touched[0, faces[bare]] = touched[1, faces[~bare]] = True
    return np.flatnonzero((touched[0] & touched[1])[faces].any(axis=1))


def _split(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Split each face in four at its edges' midpoints; return vertices with the midpoints, and faces."""
    middles = 0.5 * (vertices[faces] + vertices[faces[:, [1, 2, 0]]])
    ab, bc, ca = (len(vertices) + 3 * np.arange(len(faces)) + k for k in range(3))
    a, b, c = faces.T
    parts = np.stack([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]])
    return np.concatenate([vertices, middles.reshape(-1, 3)]), np.ascontiguousarray(
        parts.transpose(2, 0, 1).reshape(-1, 3)
    )


def penetration_depth(nodes: np.ndarray, faces: np.ndarray, skin: ExposedSurface) -> float:
    """Compute the greatest depth of a garment's nodes and face centres in a body [m], by the way to its exposed skin.

    Args:
        nodes: Garment positions [m], shape [node_count, 3].
        faces: Garment faces, shape [face_count, 3].
        skin: The body.
    """
    return float(_depths(nodes, faces, skin)[1].max(initial=0.0))


class PinchedDepth(NamedTuple):
    """Describe how deep a garment is in a body [m]; 0 where it is outside.

    Attributes:
        free: Greatest way to exposed skin, of points that are not pinched.
        exit: Greatest way to exposed skin, of pinched points (`ExposedSurface.pinch`).
        pinched: Greatest distance of pinched points from the nearer part's skin: how far flesh has to yield.
    """

    free: float
    exit: float
    pinched: float


def pinched_depth(nodes: np.ndarray, faces: np.ndarray, skin: ExposedSurface) -> PinchedDepth:
    """Compute how deep a garment is in a body, separately for free points and for points that the body's parts pinch.

    Args:
        nodes: Garment positions [m], shape [node_count, 3].
        faces: Garment faces, shape [face_count, 3].
        skin: The body.
    """
    inside, distance = _depths(nodes, faces, skin)
    pinched, depth = skin.pinch(inside, distance)
    found = (distance[~pinched], distance[pinched], depth[pinched])
    return PinchedDepth(*(float(each.max(initial=0.0)) for each in found))


def _depths(nodes: np.ndarray, faces: np.ndarray, skin: ExposedSurface) -> tuple[np.ndarray, np.ndarray]:
    """Return a garment's nodes and face centres inside a body [m], [n, 3], and their ways to its exposed skin [m]."""
    points = np.concatenate([nodes, nodes[faces].mean(axis=1)])
    return skin.depths(points)
