"""A foreign skeleton in motion, as its file has it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

MAX_STILL_JOINT_ANGLE = float(np.deg2rad(0.05))
"""Angle within which a joint counts as not turning [rad]: files round to 0.01 or 0.001 degrees."""


@dataclass(frozen=True)
class SkeletonMotion:
    """Describe a foreign skeleton in motion, in the file's unit and axes.

    Attributes:
        names: Of its joints.
        parents: Index of each joint's parent, which comes first; -1 for the root.
        offsets: From the parent in the rest pose, shape [joint_count, 3].
        turns: Rotation of each joint in the world, shape [n, joint_count, 3, 3].
        moves: Offsets that change, by joint index, from the parent in its axes, of the root in the world, shape [n, 3].
    """

    names: tuple[str, ...]
    parents: tuple[int, ...]
    offsets: np.ndarray
    turns: np.ndarray
    moves: dict[int, np.ndarray] = field(default_factory=dict)

    def places(self, turns: np.ndarray) -> np.ndarray:
        """Return the joints of one pose (world rotations, [joint_count, 3, 3]), the root at 0."""
        found = np.zeros_like(self.offsets)
        for joint, parent in enumerate(self.parents):
            if parent >= 0:
                found[joint] = found[parent] + turns[parent] @ self.offsets[joint]
        return found

    def position(self, joint: int) -> np.ndarray:
        """Return the place of a joint in the world, shape [n, 3]."""
        found = np.zeros((len(self.turns), 3))
        while joint >= 0:
            parent, offset = self.parents[joint], np.atleast_2d(self.moves.get(joint, self.offsets[joint]))
            found += offset if parent < 0 else (self.turns[:, parent] @ offset[:, :, None])[:, :, 0]
            joint = parent
        return found

    def fixed_joints(self) -> frozenset[int]:
        """Return the joints that never turn relative to their parents, from the rest pose on."""
        found = set()
        for joint, parent in enumerate(self.parents):
            before = self.turns[:, parent] if parent >= 0 else np.eye(3)
            if np.abs(self.turns[:, joint] - before).max() < MAX_STILL_JOINT_ANGLE:
                found.add(joint)
        return frozenset(found)

    def turn_above(self, joint: int) -> np.ndarray | None:
        """Return the world rotation [3, 3] of a joint's parent if it is the same in all poses, else None."""
        parent = self.parents[joint]
        if parent < 0:
            return np.eye(3)
        turns = self.turns[:, parent]
        return np.asarray(turns[0]) if np.abs(turns - turns[0]).max() < MAX_STILL_JOINT_ANGLE else None
