"""The gaps between a body's limbs and the rest of it, and how they widen as a limb is spread."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...geometry.geometry import unit, vertex_normals
from ...geometry.surface import TriangleSurface
from ..body import JOINT_PARENTS, JOINTS, Body

MAX_LIMB_GAP = 0.05
"""Largest width of a gap, and largest depth of an overlap, that is measured [m]: a third of a thigh's width."""

LIMB_FACING_COSINE = 0.3
"""Cosine between the normals of two skins below which they face each other; a shoulder beside a neck does not."""

MIN_GAP_NORMAL_COSINE = 0.5
"""Smallest cosine between a gap's direction and the normal at its foot; feet on the limb's cut rim have less."""

MIN_GAP_WIDENING = 0.08
"""Smallest widening of a gap as a limb turns [m/rad]: 1.4 mm a degree. Nearer to the joint skin creases at every angle:
at an arm 35 degrees from the trunk, beside which a T-shirt has room, creases would require 4 to 8 degrees more."""

MIN_SPREAD_AXIS_SINE = 0.5
"""Sine of the angle between a limb and the sideways axis below which the limb spreads by less than the given angle. A
limb along that axis has no outward direction; this keeps motions through it smooth."""


@dataclass(frozen=True)
class Limb:
    """Describe a limb that can be spread.

    Attributes:
        joint: Index of the joint about which it turns.
        end: Index of the joint at the end of its first bone.
        centre: Index of the joint along whose sideways axis it is spread.
        side: +1 where that axis points along +x in the T-pose, else -1.
    """

    joint: int
    end: int
    centre: int
    side: float

    @classmethod
    def named(cls, side: str, part: str) -> Limb:
        """Return the `left` or `right` limb that starts at a `shoulder` or a `hip`."""
        end, centre = {"shoulder": ("elbow", "spine3"), "hip": ("knee", "pelvis")}[part]
        joint, last = (JOINTS.index(f"{side}_{name}") for name in (part, end))
        return cls(joint, last, JOINTS.index(centre), 1.0 if side == "left" else -1.0)

    @cached_property
    def joints(self) -> tuple[int, ...]:
        """Return the indices of its joints."""
        chosen = {self.joint}
        for child, parent in enumerate(JOINT_PARENTS):
            if parent in chosen:
                chosen.add(child)
        return tuple(sorted(chosen))

    def axis(self, transforms: np.ndarray, joints: np.ndarray) -> np.ndarray:
        """Return the axis of its spreading, of unit length at most, in a pose's world axes, shape [3].

        Args:
            transforms: From rest space to the pose, shape [24, 4, 4].
            joints: Of the pose [m], shape [24, 3].
        """
        bone = joints[self.end] - joints[self.joint]
        across = np.cross(bone / np.linalg.norm(bone), self.side * transforms[self.centre, :3, 0])
        return np.asarray(across / max(float(np.linalg.norm(across)), MIN_SPREAD_AXIS_SINE))


@dataclass(frozen=True)
class Gaps:
    """Describe the gaps between a limb and other skin that faces it.

    Attributes:
        width: Distance of the two skins, negative where they overlap [m], shape [n].
        widening: Its derivative by the angle of the limb, or of both legs [m/rad], shape [n].
        ends: Vertices whose mean is the limb's point, and those around its foot, shape [n, 2, 3].
    """

    width: np.ndarray
    widening: np.ndarray
    ends: np.ndarray


class LimbGaps:
    """Measure gaps between parts of a wearer in any pose.

    Args:
        wearer: The wearer in any pose; only faces and skinning weights are used.
    """

    def __init__(self, wearer: Body) -> None:
        self._weights, self._faces = wearer.weights, wearer.faces

    def share(self, limbs: tuple[Limb, ...]) -> np.ndarray:
        """Return the share of each vertex that moves with some limbs, shape [vertex_count]."""
        return np.asarray(self._weights[:, [joint for limb in limbs for joint in limb.joints]].sum(axis=1))

    def measure(self, body: Body, moved: tuple[Limb, ...], part: np.ndarray, other: np.ndarray) -> Gaps:
        """Measure the gaps between faces of a limb and other skin.

        Args:
            body: The wearer in a pose.
            moved: The limbs that are spread together.
            part: Faces of the limb, at whose corners and centres gaps are measured, shape [own_count].
            other: Faces of the other skin, shape [other_count].
        """
        vertices = body.vertices
        part, other = self._near(vertices, part, other)
        if not len(part) or not len(other):
            return Gaps(np.zeros(0), np.zeros(0), np.zeros((0, 2, 3), dtype=int))
        normals = vertex_normals(vertices, self._faces)
        corners = np.concatenate([np.repeat(np.unique(self._faces[part])[:, None], 3, axis=1), self._faces[part]])
        points, facing = vertices[corners].mean(axis=1), unit(normals[corners].sum(axis=1))
        found = TriangleSurface(vertices, self._faces[other]).closest(points)
        beyond = self._faces[other][found.face]
        outward = unit(np.einsum("nk,nkd->nd", found.barycentric, normals[beyond]))
        offset = points - found.foot
        width = np.where((offset * outward).sum(axis=1) < 0, -1.0, 1.0) * found.distance
        along = outward.copy()
        is_far = found.distance > 1e-9  # nearer, the direction is inaccurate
        along[is_far] = offset[is_far] / width[is_far, None]
        kept = np.flatnonzero(
            (found.distance < MAX_LIMB_GAP)
            & ((facing * outward).sum(axis=1) < LIMB_FACING_COSINE)
            & ((along * outward).sum(axis=1) > MIN_GAP_NORMAL_COSINE)
        )
        widening = np.zeros(len(points))
        for limb in moved:
            share = self.share((limb,))
            axis, joint = limb.axis(body.transforms, body.joints), body.joints[limb.joint]
            feet = np.einsum("nk,nk->n", found.barycentric, share[beyond])
            move = share[corners].mean(axis=1)[:, None] * np.cross(axis, points - joint)
            move -= feet[:, None] * np.cross(axis, found.foot - joint)
            widening += (move * along).sum(axis=1)
        return Gaps(width[kept], widening[kept], np.stack([corners, beyond], axis=1)[kept])

    def _near(self, vertices: np.ndarray, part: np.ndarray, other: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the faces of both parts that are in each other's bounding box."""
        middles = vertices[self._faces].mean(axis=1)
        for _ in range(2):
            if len(part):
                low, high = middles[part].min(axis=0) - MAX_LIMB_GAP, middles[part].max(axis=0) + MAX_LIMB_GAP
                other = other[((middles[other] > low) & (middles[other] < high)).all(axis=1)]
            part, other = other, part
        return part, other
