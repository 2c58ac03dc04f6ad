"""Find where points of the body are along and around an unrolled arm, leg, trunk or neck."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from scipy.spatial import cKDTree

from ..body.body import JOINTS, Body
from ..body.skinning import skin
from ..geometry.geometry import unit, vertex_normals
from .points import PersonPoints


class Limb(IntEnum):
    """Name a limb that rings go around."""

    TRUNK = 0
    NECK = 1
    LEFT_ARM = 2
    RIGHT_ARM = 3
    LEFT_LEG = 4
    RIGHT_LEG = 5


FOLDED_BODY_PARTS = {
    "pelvis": ("pelvis",), "waist": ("spine1", "spine2"), "chest": ("spine3", "left_collar", "right_collar"),
    "neck": ("neck",), "head": ("head",), "thigh": ("left_hip", "right_hip"), "shank": ("left_knee", "right_knee"),
    "foot": ("left_ankle", "right_ankle", "left_foot", "right_foot"),
    "upper_arm": ("left_shoulder", "right_shoulder"), "forearm": ("left_elbow", "right_elbow"),
    "hand": ("left_wrist", "right_wrist", "left_hand", "right_hand"),
}  # fmt: skip
"""Parts of the body by the joints whose skinning weights they sum, left and right folded."""

BODY_MATCH_NORMAL_LENGTH = 0.06
"""Length that a unit of difference in normals counts as when a scanned point is matched to the body [m]: the normal
alone separates an arm that hangs 6 cm from the trunk, and the flank of a fold is still matched to its own limb."""
CANDIDATE_TRIANGLE_COUNT = 12
"""Number of the body's triangles examined for each sample's nearest point: those around two adjacent vertices."""


@dataclass(frozen=True)
class BodyPlace:
    """Describe the place of each point on the fitted body.

    Attributes:
        foot: The body's point below it [m], shape [n, 3].
        normal: The body's outward normal there, shape [n, 3].
        offset: Height over the body along that normal, negative inside [m], shape [n].
        distance: Distance to it [m], shape [n].
        rest: The body's point in the T-pose [m], feet at y = 0, shape [n, 3].
        parts: Share of each part of `FOLDED_BODY_PARTS`, rows sum to 1, shape [n, 11].
        weights: Skinning weights of the body's point, shape [n, 24].
        limb: The `Limb` of each point, int8, shape [n].
        along: Unit vector along the limb, away from the body's middle, in the pose, shape [n, 3].
        front: Unit vector around the limb towards the T-pose's front, orthogonal to `along`, shape [n, 3].
        station: Length along the limb [m]: of arms from the shoulder joint, of legs from the hip joint, of the trunk
            below the neck joint, of neck and head over it; shape [n].
    """

    foot: np.ndarray
    normal: np.ndarray
    offset: np.ndarray
    distance: np.ndarray
    rest: np.ndarray
    parts: np.ndarray
    weights: np.ndarray
    limb: np.ndarray
    along: np.ndarray
    front: np.ndarray
    station: np.ndarray


def place_on_body(points: PersonPoints, body: Body) -> BodyPlace:
    """Find each sample's place on the fitted body: its nearest point by position and normal.

    The T-pose's model is used, moved to the pose; of a body given as a mesh that is the fitted model too.
    """
    posed = body.vertices
    if len(posed) != len(body.rest_vertices):
        posed = skin(body.rest_vertices, body.rest_weights, body.transforms)
    faces = body.rest_faces
    normals = vertex_normals(posed, faces)
    corners = posed[faces]
    keys = np.hstack([corners.mean(axis=1), BODY_MATCH_NORMAL_LENGTH * unit(normals[faces].sum(axis=1))])
    matched = np.hstack([points.positions, BODY_MATCH_NORMAL_LENGTH * points.normals])
    _, tried = cKDTree(keys).query(matched, k=CANDIDATE_TRIANGLE_COUNT)
    share = closest_in_triangles(points.positions[:, None], corners[tried])
    feet = np.einsum("ntk,ntka->nta", share, corners[tried])
    miss = ((points.positions[:, None] - feet) ** 2).sum(axis=2)
    turned = ((keys[tried, 3:] - matched[:, None, 3:]) ** 2).sum(axis=2)
    best = (miss + turned).argmin(axis=1)
    row = np.arange(len(best))
    share, corner = share[row, best], faces[tried[row, best]]

    def at(values: np.ndarray) -> np.ndarray:
        return np.asarray(np.einsum("nk,nkd->nd", share, values[corner]))

    foot, normal, weights = feet[row, best], unit(at(normals)), at(body.rest_weights)
    rest = at(body.rest_vertices)
    gap = points.positions - foot
    limb, along, front, station = _limb_frame(body, rest, weights)
    turn = np.einsum("nj,jab->nab", weights, body.transforms[:, :3, :3])
    along = unit(np.einsum("nab,nb->na", turn, along))
    front = np.einsum("nab,nb->na", turn, front)
    front = unit(front - np.einsum("na,na->n", front, along)[:, None] * along)
    return BodyPlace(
        foot=foot,
        normal=normal,
        offset=np.einsum("na,na->n", gap, normal),
        distance=np.sqrt((gap**2).sum(axis=1)),
        rest=rest,
        parts=fold_parts(weights),
        weights=weights,
        limb=limb,
        along=along,
        front=front,
        station=station,
    )


def fold_parts(weights: np.ndarray) -> np.ndarray:
    """Sum skinning weights, shape [n, 24], to the parts of `FOLDED_BODY_PARTS`, shape [n, 11]."""
    return np.stack(
        [weights[:, [JOINTS.index(j) for j in joints]].sum(axis=1) for joints in FOLDED_BODY_PARTS.values()], axis=1
    )


def _limb_frame(
    body: Body, rest: np.ndarray, weights: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Find limb, direction along it and to its front in the T-pose, and station [m] of points there."""

    def joint(name: str) -> np.ndarray:
        return np.asarray(body.rest_joints[JOINTS.index(name)])

    def total(*names: str) -> np.ndarray:
        return np.asarray(weights[:, [JOINTS.index(name) for name in names]].sum(axis=1))

    shares = np.zeros((len(rest), len(Limb)))
    shares[:, Limb.TRUNK] = total("pelvis", "spine1", "spine2", "spine3", "left_collar", "right_collar")
    shares[:, Limb.NECK] = total("neck", "head")
    for side, arm, leg in (("left", Limb.LEFT_ARM, Limb.LEFT_LEG), ("right", Limb.RIGHT_ARM, Limb.RIGHT_LEG)):
        shares[:, arm] = total(*(f"{side}_{name}" for name in ("shoulder", "elbow", "wrist", "hand")))
        shares[:, leg] = total(*(f"{side}_{name}" for name in ("hip", "knee", "ankle", "foot")))
    limb = shares.argmax(axis=1).astype(np.int8)
    down = np.array([0.0, -1.0, 0.0])
    along, station = np.tile(down, (len(rest), 1)), joint("neck")[1] - rest[:, 1]
    neck = limb == Limb.NECK
    along[neck], station[neck] = -down, -station[neck]
    sides = (("left", 1, Limb.LEFT_ARM, Limb.LEFT_LEG), ("right", -1, Limb.RIGHT_ARM, Limb.RIGHT_LEG))
    for side, sign, arm, leg in sides:
        members = limb == arm
        along[members] = (sign, 0.0, 0.0)
        station[members] = sign * (rest[members, 0] - joint(f"{side}_shoulder")[0])
        members = limb == leg
        station[members] = joint(f"{side}_hip")[1] - rest[members, 1]
    return limb, along, np.tile([0.0, 0.0, 1.0], (len(rest), 1)), station


def closest_in_triangles(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Compute barycentric coordinates of triangles' nearest points: the plane's foot if inside, else an edge's nearest.

    Args:
        points: Positions [m], shape [n, t, 3] or broadcastable.
        corners: A triangle for each, shape [n, t, 3, 3].

    Returns:
        Coordinates, 0 to 1, rows sum to 1, shape [n, t, 3].
    """
    a, b, c = (corners[..., k, :] for k in range(3))
    inside = _plane_barycentric(points - a, b - a, c - a)
    within = np.asarray((inside >= 0).all(axis=-1))
    best = np.full(inside.shape[:-1], np.inf)
    edges = np.zeros_like(inside)
    for k, (start, end) in enumerate(((a, b), (b, c), (c, a))):
        edge = end - start
        t = np.einsum("...a,...a->...", points - start, edge) / np.maximum((edge**2).sum(axis=-1), 1e-30)
        t = np.clip(t, 0.0, 1.0)
        miss = ((points - start - t[..., None] * edge) ** 2).sum(axis=-1)
        closer = np.asarray(miss < best)
        best = np.where(closer, miss, best)
        is_closest = np.zeros_like(inside)
        is_closest[..., k], is_closest[..., (k + 1) % 3] = 1.0 - t, t
        edges = np.where(closer[..., None], is_closest, edges)
    return np.asarray(np.where(within[..., None], inside, edges))


def _plane_barycentric(arm: np.ndarray, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Compute coordinates (1 - s - t, s, t) of arm = s u + t v + normal part, by the normal equations."""
    uu, uv, vv = ((x * y).sum(axis=-1) for x, y in ((u, u), (u, v), (v, v)))
    au, av = (arm * u).sum(axis=-1), (arm * v).sum(axis=-1)
    det = np.maximum(uu * vv - uv**2, 1e-30)
    s, t = (vv * au - uv * av) / det, (uu * av - uv * au) / det
    return np.stack([1.0 - s - t, s, t], axis=-1)
