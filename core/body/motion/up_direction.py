"""Find the up direction of a motion's file from the whole motion, not its first pose."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

MIN_UP_AGREEMENT_COSINE = 0.5
"""Smallest cosine between a motion's mean upright direction and the rest pose's up at which both agree: 60 degrees, the
mean lean of a person who works bent over."""

MIN_MEAN_RESULTANT_LENGTH = 0.8
"""Smallest length of the mean of unit directions [1] at which a person's posture is constant, within 37 degrees. Walks
have 0.98; a person who rolls on the floor has less than 0.5."""

MEAN_AXIS_COSINE = 0.94
"""Cosine to an axis of the file above which a mean direction is that axis: 20 degrees."""

FLOOR_HEIGHT_RANGE = (-0.05, 0.35)
"""Range of the height of the lowest joint above 0 at which a file's floor is at 0 [leg lengths]. An ankle's height is
0.1; with the origin at the pelvis the height is negative for every up direction."""


@dataclass(frozen=True)
class SampledPoses:
    """Describe a person's posture in some poses of a motion, in the file's axes: unit directions from legs to trunk,
    shape [n, 3], and joints [leg lengths], shape [n, joint_count, 3]."""

    uprights: np.ndarray
    places: np.ndarray


@dataclass(frozen=True)
class UpDirection:
    """Describe the up direction: the unit vector in the file's axes, shape [3], and a sentence on how it was found."""

    direction: np.ndarray
    note: str


def find_up(rest: np.ndarray, sampled: SampledPoses) -> UpDirection:
    """Find the up direction in the world of a motion.

    It is the rest pose's, unless the person is upright along another axis of the file through the whole motion (a file
    whose rest pose is rotated by its own channels): then that axis. For a person who lies down all the time it is the
    rest pose's.

    Args:
        rest: Up in the rest pose, unit, shape [3].
        sampled: Poses spread over the motion.
    """
    mean = sampled.uprights.mean(axis=0)
    if mean @ rest > MIN_UP_AGREEMENT_COSINE:
        return UpDirection(rest, f"Up is {name_direction(rest)} of the file, by the rest pose and the whole motion.")
    axis = int(np.abs(mean).argmax())
    mean_axis = np.eye(3)[axis] * np.sign(mean[axis])
    steady = float(
        np.linalg.norm(mean)
    ) > MIN_MEAN_RESULTANT_LENGTH and mean @ mean_axis > MEAN_AXIS_COSINE * np.linalg.norm(mean)
    if steady and (_has_floor(sampled, mean_axis) or not _has_floor(sampled, rest)):
        return UpDirection(
            mean_axis,
            f"Up is {name_direction(mean_axis)} of the file, along which the person is held through the whole motion; "
            f"the rest pose stands along {name_direction(rest)}.",
        )
    return UpDirection(
        rest,
        f"Up is {name_direction(rest)} of the file, by the rest pose; "
        "the person is not upright on the mean of the motion.",
    )


def _has_floor(sampled: SampledPoses, up: np.ndarray) -> bool:
    """Check whether the lowest joints are near height 0."""
    return bool(FLOOR_HEIGHT_RANGE[0] <= float(np.median((sampled.places @ up).min(axis=1))) <= FLOOR_HEIGHT_RANGE[1])


def name_direction(direction: np.ndarray) -> str:
    """Return a direction's name: `+y`, `-z`, or its components where it is along no axis."""
    axis = int(np.abs(direction).argmax())
    if abs(direction[axis]) > 1.0 - 1e-6:
        return f"{'+' if direction[axis] > 0 else '-'}{'xyz'[axis]}"
    return f"({', '.join(f'{value:.2f}' for value in direction)})"
