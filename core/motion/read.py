"""Read a motion's file by its kind."""

from __future__ import annotations

from pathlib import Path

from .bvh import read_bvh
from .errors import MotionBad
from .keys import read_keys
from .recording import Recording
from .smpl_motion import read_smpl_motion

READERS = {".json": read_keys, ".bvh": read_bvh, ".npz": read_smpl_motion}
"""Reader of each kind of file, by its ending."""


def is_motion(name: str) -> bool:
    """Return whether a file's name ends as a motion's does."""
    return Path(name).suffix.lower() in READERS


def load_motion(path: Path) -> Recording:
    """Read a motion: BVH, `.npz` of `poses` and `trans`, or JSON keys.

    Raises:
        MotionBad, MotionTooLarge, MotionForeign: where the file is none that is understood; says why.
    """
    reader = READERS.get(Path(path).suffix.lower())
    if reader is None:
        raise MotionBad(f"{Path(path).name}: {MotionBad().message}")
    return reader(Path(path))
