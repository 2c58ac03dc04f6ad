"""A body as it stands to be measured, and the tape laid on it: level, upright and slanted cuts and their hulls."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from ..geometry.connectivity import HalfEdges, find_components
from .body import JOINTS, Body
from .posing import pose_body

MAX_TRUNK_LEAN = np.radians(15.0)
"""Largest angle between trunk and upright at which a mesh is measured as it stands [rad]; scanned persons sway less."""

MAX_LEG_LEAN = np.radians(25.0)
"""Largest angle between a thigh and upright at which a mesh is measured as it stands [rad]."""

ARM_ANGLES = (np.radians(-10.0), np.radians(65.0))
"""Least and largest angle of the upper arms below level at which a mesh is measured as it stands [rad]: beyond, they
cover the chest's sides, or raise it."""

LEG_REACH = 0.02
"""Distance from the median plane up to which a leg's own cut may reach to the other side [m]."""

ARM_JOINTS = tuple(
    JOINTS.index(f"{side}_{joint}") for side in ("left", "right") for joint in ("shoulder", "elbow", "wrist", "hand")
)


@dataclass(frozen=True)
class StandingBody:
    """Describe a mesh that stands on y = 0 and faces +z, with the pelvis at x = 0.

    Attributes:
        vertices: Positions [m], shape [vertex_count, 3].
        faces: Triangles, shape [face_count, 3].
        joints: Joints [m], order of `JOINTS`, shape [24, 3].
        is_arm: Whether a vertex is on an arm, shape [vertex_count].
        is_given: Whether it is the given mesh in its own pose; else the fitted model.
    """

    vertices: np.ndarray
    faces: np.ndarray
    joints: np.ndarray
    is_arm: np.ndarray
    is_given: bool

    def joint(self, name: str) -> np.ndarray:
        """Return the position of a joint [m], shape [3]."""
        return np.asarray(self.joints[JOINTS.index(name)])

    @cached_property
    def trunk_faces(self) -> np.ndarray:
        """Return the faces without those of the arms, shape [n, 3]."""
        return np.asarray(self.faces[~self.is_arm[self.faces].all(axis=1)])

    @cached_property
    def edges(self) -> np.ndarray:
        """Return the edges of the mesh, shape [edge_count, 2]."""
        return HalfEdges.of(self.faces).edges

    def level(self, height: float) -> np.ndarray:
        """Return the points of the level cut of trunk and legs at a height [m], shape [n, 3]."""
        return cut_faces(self.vertices, self.trunk_faces, np.array([0.0, 1.0, 0.0]), height)[0]

    def legs(self, height: float) -> tuple[tuple[np.ndarray, ...], bool]:
        """Return the points of each leg's level cut [m], shape [n, 3], the left first, and whether the legs are apart:
        no part of the cut reaches from one to the other."""
        points, part = cut_faces(self.vertices, self.trunk_faces, np.array([0.0, 1.0, 0.0]), height)
        across = points[:, 0]
        low, high = (np.full(part.max(initial=-1) + 1, value) for value in (np.inf, -np.inf))
        np.minimum.at(low, part, across)
        np.maximum.at(high, part, across)
        is_apart = not bool(((low < -LEG_REACH) & (high > LEG_REACH)).any())
        middles = (low + high)[part] / 2.0 if len(part) else across
        return (points[middles > 0.0], points[middles < 0.0]), is_apart


def stand(body: Body) -> StandingBody:
    """Return a body as it is measured: a given mesh in its own pose where it stands upright with its arms away from the
    trunk, else the fitted model with its arms at 45 degrees."""
    is_given = body.source.startswith("mesh:") and stands_upright(body)
    chosen = body if is_given else pose_body(body, "A")
    turn = _facing(chosen)
    vertices, joints = chosen.vertices @ turn.T, chosen.joints @ turn.T
    shift = np.array([joints[0, 0], vertices[:, 1].min(), joints[0, 2]])
    is_arm = chosen.weights[:, ARM_JOINTS].sum(axis=1) > 0.5
    return StandingBody(vertices - shift, chosen.faces, joints - shift, is_arm, is_given)


def _facing(body: Body) -> np.ndarray:
    """Return the rotation [3, 3] about the upright that turns hips and shoulders square to +z."""
    across = body.sideways("hip") / np.linalg.norm(body.sideways("hip"))
    across = across + body.sideways("shoulder") / np.linalg.norm(body.sideways("shoulder"))
    along = across / np.linalg.norm(across)
    return np.stack([along, [0.0, 1.0, 0.0], np.cross(along, [0.0, 1.0, 0.0])])


def stands_upright(body: Body) -> bool:
    """Check whether a body stands upright with its arms away from its trunk."""
    up = np.array([0.0, 1.0, 0.0])
    trunk = angle_between(body.joint("neck") - body.joint("pelvis"), up)
    thighs = [angle_between(body.joint(f"{side}_hip") - body.joint(f"{side}_knee"), up) for side in ("left", "right")]
    arms = [
        np.pi / 2 - angle_between(body.joint(f"{s}_shoulder") - body.joint(f"{s}_elbow"), up) for s in ("left", "right")
    ]
    low, high = ARM_ANGLES
    return trunk < MAX_TRUNK_LEAN and max(thighs) < MAX_LEG_LEAN and all(low < angle < high for angle in arms)


def angle_between(one: np.ndarray, other: np.ndarray) -> float:
    """Return the angle between two vectors [rad], shape [3] each."""
    return float(np.arctan2(np.linalg.norm(np.cross(one, other)), one @ other))


def cut_faces(
    vertices: np.ndarray, faces: np.ndarray, normal: np.ndarray, offset: float
) -> tuple[np.ndarray, np.ndarray]:
    """Cut faces by the plane normal . p = offset.

    Returns:
        The points at which it crosses their edges [m], two for each face that it crosses, shape [n, 3], and the
        connected part of the cut of each, shape [n].
    """
    side = vertices @ normal - offset
    above = side[faces] > 0.0
    crossed = faces[above.any(axis=1) & ~above.all(axis=1)]
    if not len(crossed):
        return np.zeros((0, 3)), np.zeros(0, dtype=np.int64)
    ahead = np.roll(crossed, -1, axis=1)
    is_cut = (side[crossed] > 0.0) != (side[ahead] > 0.0)
    first, second = np.minimum(crossed, ahead)[is_cut], np.maximum(crossed, ahead)[is_cut]
    share = side[first] / (side[first] - side[second])
    points = vertices[first] + share[:, None] * (vertices[second] - vertices[first])
    _, number = np.unique(first * len(vertices) + second, return_inverse=True)
    pairs = number.reshape(-1, 2)
    _, part = find_components(int(number.max()) + 1, pairs[:, 0], pairs[:, 1])
    return points, part[number]


def hull_of(flat: np.ndarray) -> np.ndarray:
    """Return the corners of the convex hull of points, shape [n, 2], counter-clockwise, by their numbers; none where
    all lie on one line."""
    try:
        return np.asarray(ConvexHull(flat).vertices)
    except (QhullError, ValueError):
        return np.zeros(0, dtype=np.int64)


def girth_of(points: np.ndarray, axis: int) -> tuple[float, np.ndarray]:
    """Return the perimeter of the hull of points of a cut [m], shape [n, 3], seen along an axis, and the closed line of
    it, shape [m + 1, 3]; NaN where there is none."""
    corners = hull_of(np.delete(points, axis, axis=1))
    if not len(corners):
        return float("nan"), np.zeros((0, 3))
    line = points[[*corners, corners[0]]]
    return length_of_line(line), line


def taut_path(points: np.ndarray, start: np.ndarray, end: np.ndarray, outward: np.ndarray) -> np.ndarray:
    """Return the tape from a start to an end over points of one plane, pulled taut on the side that faces outward.

    It is the part of the convex hull of all of them between both ends on that side.

    Args:
        points: Points on the skin between both [m], shape [n, 3].
        start, end: Its ends [m], shape [3] each.
        outward: Unit vector in the plane, away from the body, shape [3].

    Returns:
        Its corners [m], shape [m, 3].
    """
    along = end - start
    along = along / max(float(np.linalg.norm(along)), 1e-12)
    out = outward - (outward @ along) * along
    out = out / max(float(np.linalg.norm(out)), 1e-12)
    every = np.concatenate([start[None], points, end[None]])
    flat = np.stack([(every - start) @ along, (every - start) @ out], axis=1)
    kept = flat[:, 1] >= -1e-9
    order = np.flatnonzero(kept)[np.lexsort((flat[kept, 1], flat[kept, 0]))]
    top: list[int] = []  # Andrew's monotone chain, the upper half
    for number in order:
        while len(top) > 1 and _turns_left(flat[top[-2]], flat[top[-1]], flat[number]):
            top.pop()
        top.append(int(number))
    return np.asarray(every[top])


def _turns_left(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> bool:
    return bool((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) >= 0.0)


def length_of_line(line: np.ndarray) -> float:
    """Return the length of a polyline [m], shape [n, 3]."""
    return float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())
