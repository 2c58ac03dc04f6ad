"""A wearer's motion in time: the rotation of every joint and the place of the pelvis, at any moment."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

from ..body import JOINT_PARENTS, Body
from ..template import articulate, transforms_of


@dataclass(frozen=True)
class Pose:
    """Describe one pose of a skeleton.

    Attributes:
        turns: Rotation of each joint relative to its parent, identities are the T-pose, shape [24, 3, 3].
        pelvis: Place of the pelvis [m], shape [3].
    """

    turns: np.ndarray
    pelvis: np.ndarray

    @classmethod
    def of(cls, body: Body) -> Pose:
        """Return the pose in which a body stands."""
        world = body.transforms[:, :3, :3]
        turns = np.stack([world[j] if p < 0 else world[p].T @ world[j] for j, p in enumerate(JOINT_PARENTS)])
        return cls(turns, world[0] @ body.rest_joints[0] + body.transforms[0, :3, 3])

    def transforms(self, joints: np.ndarray) -> np.ndarray:
        """Return the transforms from rest space, shape [24, 4, 4], of a skeleton with T-pose joints [m], [24, 3]."""
        return transforms_of(*articulate(self.turns, joints, self.pelvis - joints[0]), joints)

    def towards(self, other: Pose, share: float) -> Pose:
        """Return the pose a share of the way to another: each joint turns by that share of the angle (slerp)."""
        start = Rotation.from_matrix(self.turns)
        way = (start.inv() * Rotation.from_matrix(other.turns)).as_rotvec()
        turned = start * Rotation.from_rotvec(share * way)
        return Pose(turned.as_matrix(), (1.0 - share) * self.pelvis + share * other.pelvis)


@dataclass(frozen=True)
class Track:
    """Describe a motion as poses at a steady rate; between them joints turn by slerp.

    Attributes:
        rate: Poses a second [1/s].
        turns: As in `Pose`, shape [pose_count, 24, 3, 3].
        pelvis: Places of the pelvis [m], shape [pose_count, 3].
        loops: True where the first pose follows the last one again, moved on by the way between them.
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
        """Return the pose at a time [s] after the first; before the first and after the last the motion stands still.

        A motion that loops ends with the pose that it begins with, and goes on for ever.
        """
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
        seconds: How long that takes [s]; 0 for a motion that begins in the wearer's own pose.
    """

    start: Pose
    track: Track
    begin: float = 0.0
    seconds: float = 1.0

    def at(self, time: float) -> Pose:
        """Return the pose at a time of the motion [s]; before `begin` the wearer is on the way there.

        The share s (3 - 2 s) s of the way has been gone after the share s of the time: the wearer sets out from rest.
        """
        if self.seconds <= 0 or time >= self.begin:
            return self.track.at(time)
        share = float(np.clip(1.0 + (time - self.begin) / self.seconds, 0.0, 1.0))
        return self.start.towards(self.track.at(time), share * share * (3.0 - 2.0 * share))
