"""A motion as a file has it, in our axes and by our joints, before it is fitted to a wearer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..body import JOINTS

MAX_MOTION_FRAME_COUNT = 100_000
"""Largest number of poses: 13 minutes at 120 Hz."""

ESSENTIAL_JOINTS = tuple(
    name
    for name in JOINTS
    if name not in ("left_collar", "right_collar", "left_foot", "right_foot", "left_hand", "right_hand", "neck")
)
"""Joints without which a limb, the trunk or the head is stiff. Good skeletons may lack collars, necks, toes and
fingers; what they carry follows the next joint."""


@dataclass(frozen=True)
class Recording:
    """Describe a motion of a foreign skeleton, y up, facing +z in its rest pose, by the names of `JOINTS`.

    Attributes:
        rate: Poses a second [1/s].
        turns: World rotation of each joint from the rest pose, shape [pose_count, 24, 3, 3]; undefined if unknown.
        known: Which joints the skeleton has, shape [24].
        bones: Unit direction from each joint to its child in the rest pose, shape [24, 3]; 0 where that is our T-pose.
        root: Place of the pelvis [leg lengths], shape [pose_count, 3]; None: the lower foot stays on the floor.
        loops: Whether the first pose follows the last one, which equals it.
        notes: How the file was interpreted, and what was not used, one sentence each.
    """

    rate: float
    turns: np.ndarray
    known: np.ndarray
    bones: np.ndarray
    root: np.ndarray | None
    loops: bool = False
    notes: tuple[str, ...] = ()

    def missing(self) -> tuple[str, ...]:
        """Return the joints of limbs, trunk and head that the skeleton lacks."""
        return tuple(name for name in ESSENTIAL_JOINTS if not self.known[JOINTS.index(name)])

    def doubts(self) -> tuple[str, ...]:
        """Return a sentence on what is stiff in every pose; empty where all limbs and the trunk move."""
        missing = self.missing()
        if not missing:
            return ()
        return (
            f"The motion's skeleton was not understood at {', '.join(missing)}, which will stay stiff; "
            "name its joints as docs/howto/animate.md says.",
        )
