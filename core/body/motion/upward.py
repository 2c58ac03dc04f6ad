"""Find where up is in a motion's file, over the whole motion and not its first pose."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

MIN_UP_AGREEMENT_COSINE = 0.5
"""Smallest cosine between the mean upright of a motion and the rest pose's up at which both agree: 60 degrees, by which
a person who works bent over leans on the mean."""

MIN_MEAN_RESULTANT_LENGTH = 0.8
"""Smallest length of the mean of unit directions at which a person is held one way through the whole motion, 37 degrees
about it. Walks have 0.98; a person who rolls on the floor has less than 0.5."""

MEAN_AXIS_COSINE = 0.94
"""Cosine to an axis of the file above which a mean is that axis: 20 degrees."""

FLOOR_HEIGHT_RANGE = (-0.05, 0.35)
"""Range of the height of the lowest joint over 0 in which a file's floor is at 0 [leg lengths]. An ankle's height is
0.1. That of a person who goes about the origin of the file at the pelvis' height is negative, whatever direction is
up."""


@dataclass(frozen=True)
class SampledPoses:
    """Describe how a person is held in some poses of a motion, in the file's axes.

    Attributes:
        uprights: Unit direction from the legs to the trunk, shape [n, 3].
        places: Of joints, in legs' lengths, shape [n, joint_count, 3].
    """

    uprights: np.ndarray
    places: np.ndarray


@dataclass(frozen=True)
class UpDirection:
    """Describe where up is: the unit direction in the file's axes, shape [3], and a sentence on what was decided."""

    direction: np.ndarray
    note: str


def find_up(rest: np.ndarray, sampled: SampledPoses) -> UpDirection:
    """Return where up is in the world of a motion.

    That is the rest pose's up; but where the person is held along another axis of the file through the whole motion (a
    file whose rest pose is turned by its own channels), it is that axis. Who lies on the floor of the rest pose's up
    all the time lies.

    Args:
        rest: Up in the rest pose, unit, shape [3].
        sampled: Poses spread over the motion.
    """
    mean = sampled.uprights.mean(axis=0)
    if mean @ rest > MIN_UP_AGREEMENT_COSINE:
        return UpDirection(rest, f"Up is {name_direction(rest)} of the file, by the rest pose and the whole motion.")
    axis = int(np.abs(mean).argmax())
    held = np.eye(3)[axis] * np.sign(mean[axis])
    steady = float(
        np.linalg.norm(mean)
    ) > MIN_MEAN_RESULTANT_LENGTH and mean @ held > MEAN_AXIS_COSINE * np.linalg.norm(mean)
    if steady and (_has_floor(sampled, held) or not _has_floor(sampled, rest)):
        return UpDirection(
            held,
            f"Up is {name_direction(held)} of the file, along which the person is held through the whole motion; "
            f"the rest pose stands along {name_direction(rest)}.",
        )
    return UpDirection(
        rest,
        f"Up is {name_direction(rest)} of the file, by the rest pose; "
        "the person is not upright on the mean of the motion.",
    )


def _has_floor(sampled: SampledPoses, up: np.ndarray) -> bool:
    """Check whether the lowest joints are about the height 0."""
    return bool(FLOOR_HEIGHT_RANGE[0] <= float(np.median((sampled.places @ up).min(axis=1))) <= FLOOR_HEIGHT_RANGE[1])


def name_direction(direction: np.ndarray) -> str:
    """Return a direction as people name it: `+y`, `-z`, or its components where it lies along no axis."""
    axis = int(np.abs(direction).argmax())
    if abs(direction[axis]) > 1.0 - 1e-6:
        return f"{'+' if direction[axis] > 0 else '-'}{'xyz'[axis]}"
    return f"({', '.join(f'{value:.2f}' for value in direction)})"
