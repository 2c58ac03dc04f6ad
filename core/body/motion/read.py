"""Read a motion from a file of any known kind."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .bvh import read_bvh
from .errors import MotionBad
from .keys import read_keys
from .recording import Recording
from .smpl_motion import read_smpl_motion

READERS = {".json": read_keys, ".bvh": read_bvh, ".npz": read_smpl_motion}
"""Reader of each file extension."""

MAX_PELVIS_SPEED = 50.0
"""Largest speed of the pelvis [leg lengths/s]: 40 m/s, three times a sprinter's. The number of simulation steps grows
with the distance, so a leap over kilometres would never finish."""


def load_motion(path: Path) -> Recording:
    """Read a motion: BVH, `.npz` of `poses` and `trans`, or JSON keys.

    Raises:
        MotionBad, MotionTooLarge, MotionForeign: where the file cannot be read or is no body's motion, with the reason.
    """
    reader = READERS.get(Path(path).suffix.lower())
    if reader is None:
        raise MotionBad(f"{Path(path).name}: {MotionBad().message}")
    recording = reader(Path(path))
    _check(recording, Path(path).name)
    return recording


def _check(recording: Recording, name: str) -> None:
    """Check that a body can make a motion; raise `MotionBad` where a number is out of range or the pelvis leaps."""
    numbers = [recording.turns[:, recording.known], recording.bones]
    if recording.root is not None:
        numbers.append(recording.root)
    if not all(np.isfinite(each).all() for each in numbers):
        raise MotionBad(f"{name}: lengths or angles are too large or too small. {MotionBad().message}")
    if recording.root is None:
        return
    speed = np.linalg.norm(np.diff(recording.root, axis=0), axis=1).max(initial=0.0) * recording.rate
    if not speed <= MAX_PELVIS_SPEED:
        raise MotionBad(
            f"{name}: the pelvis goes {speed:.3g} legs' lengths a second, more than {MAX_PELVIS_SPEED:g}; "
            "cut leaps out of the motion, or correct its unit."
        )
