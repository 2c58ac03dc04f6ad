"""A wearer's motion in time: the rotation of every joint and the place of the pelvis at any time."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

from ..body import JOINT_PARENTS, Body
from ..template import articulate, transforms_of


@dataclass(frozen=True)
class Pose:
    """Describe one pose of a skeleton: each joint's rotation relative to its parent, shape [24, 3, 3], where identities
    are the T-pose; and the place of the pelvis [m], shape [3]."""

    turns: np.ndarray
    pelvis: np.ndarray

    @classmethod
    def of(cls, body: Body) -> Pose:
        """Return a body's own pose."""
        world = body.transforms[:, :3, :3]
        turns = np.stack([world[j] if p < 0 else world[p].T @ world[j] for j, p in enumerate(JOINT_PARENTS)])
        return cls(turns, world[0] @ body.rest_joints[0] + body.transforms[0, :3, 3])

    def transforms(self, joints: np.ndarray) -> np.ndarray:
        """Return the transforms from rest space, shape [24, 4, 4], of a skeleton with T-pose joints [m], [24, 3]."""
        return transforms_of(*articulate(self.turns, joints, self.pelvis - joints[0]), joints)

    def towards(self, other: Pose, share: float) -> Pose:
        """Interpolate to another pose by a share: each joint turns by that share of the angle (slerp)."""
        start = Rotation.from_matrix(self.turns)
        rotation = (start.inv() * Rotation.from_matrix(other.turns)).as_rotvec()
        turned = start * Rotation.from_rotvec(share * rotation)
        return Pose(turned.as_matrix(), (1.0 - share) * self.pelvis + share * other.pelvis)


@dataclass(frozen=True)
class Track:
    """Describe a motion as poses at a constant rate; between them joints are interpolated by slerp.

    Attributes:
        rate: Poses a second [1/s].
        turns: As in `Pose`, shape [pose_count, 24, 3, 3].
        pelvis: Places of the pelvis [m], shape [pose_count, 3].
        loops: Whether the first pose follows the last one again, translated by the way between them.
    """

    rate: float
    turns: np.ndarray
    pelvis: np.ndarray
    loops: bool = False

    @cached_property
    def seconds(self) -> float:
        """Return the time from the first pose to the last [s]."""
        return (len(self.turns) - 1) / self.rate

    def at(self, time: float) -> Pose:
        """Return the pose at a time [s] after the first; outside of the motion its first or last pose. A motion that
        loops ends with the pose that it begins with, and continues without end."""
        rounds = 0.0
        if self.loops and self.seconds > 0:
            rounds = float(np.floor(time / self.seconds))
        place = float(np.clip((time - rounds * self.seconds) * self.rate, 0.0, len(self.turns) - 1))
        first = min(int(place), max(len(self.turns) - 2, 0))
        second = min(first + 1, len(self.turns) - 1)
        pose = Pose(self.turns[first], self.pelvis[first]).towards(
            Pose(self.turns[second], self.pelvis[second]), place - first
        )
        return replace(pose, pelvis=pose.pelvis + rounds * (self.pelvis[-1] - self.pelvis[0]))


@dataclass(frozen=True)
class LeadIn:
    """Blend from a wearer's own pose into a motion.

    Attributes:
        start: The wearer's own pose.
        track: The motion.
        begin: Time of the motion at which it is joined [s].
        seconds: Duration of the blend [s]; 0 for a motion that begins in the wearer's own pose.
    """

    start: Pose
    track: Track
    begin: float = 0.0
    seconds: float = 1.0

    def at(self, time: float) -> Pose:
        """Return the pose at a time of the motion [s]; before `begin` that of the blend. After the share s of the
        duration (3 - 2 s) s^2 of the way is done, so that the wearer starts from rest."""
        if self.seconds <= 0 or time >= self.begin:
            return self.track.at(time)
        share = float(np.clip(1.0 + (time - self.begin) / self.seconds, 0.0, 1.0))
        return self.start.towards(self.track.at(time), share * share * (3.0 - 2.0 * share))
