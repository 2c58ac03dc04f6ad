"""Motions as JSON: poses at given times, by name or by joint angles."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from ...run.text import read_json
from ..body import JOINT_PARENTS, JOINTS
from ..builtin import POSES, named_pose
from .errors import MotionBad, MotionTooLarge
from .recording import MAX_MOTION_FRAME_COUNT, Recording

MAX_KEYS_FILE_BYTES = 8 * 1024**2
"""Largest size of a JSON file of keys [bytes]: a thousand poses of all joints are 1 MB."""

FRAME_RATE_RANGE = (1.0, 240.0)
"""Accepted frame rates [1/s] of keys and `.npz` files; of a BVH file the lower bound alone applies."""


def read_keys(path: Path) -> Recording:
    """Read a motion from JSON keys.

        {"fps": 30, "loop": false, "keys": [{"t": 0, "pose": "A"}, {"t": 1, "pose": {"left_knee": [60, 0, 0]}}]}

    A pose is one of `POSES`, or angles in degrees by joint: [x, y, z] rotates about z first, then y, then x, in the
    axes of the parent in the T-pose; other joints are as in the T-pose, or as in the pose that "base" names. A key's
    "move" is the offset of the pelvis from its place [leg lengths]; without any the lower foot stays on the floor.
    Between keys joints are interpolated by slerp.

    Raises:
        MotionBad: where the file is something else, with the key that is wrong.
        MotionTooLarge: where it is too large or too long.
    """
    path = Path(path)
    if path.stat().st_size > MAX_KEYS_FILE_BYTES:
        raise MotionTooLarge(f"{path.name} is larger than {MAX_KEYS_FILE_BYTES >> 20} MB of keys.")
    try:
        document = read_json(path.read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as error:
        raise MotionBad(f"{path.name} is no JSON: {str(error)[:80]}. {MotionBad().message}") from error
    return build_keys(document, path.name)


def build_keys(value: Any, name: str) -> Recording:
    """Build a motion from JSON values; see `read_keys`."""
    keys = value.get("keys") if isinstance(value, dict) else None
    if not isinstance(keys, list) or not keys or not all(isinstance(key, dict) for key in keys):
        raise MotionBad(f'{name}: give {{"fps": 30, "keys": [{{"t": 0, "pose": "A"}}, ...]}}.')
    rate = _number(value.get("fps", 30), f"{name}: fps")
    times = np.array([_number(key.get("t"), f"{name}: t of key {n}") for n, key in enumerate(keys)])
    if not FRAME_RATE_RANGE[0] <= rate <= FRAME_RATE_RANGE[1] or (np.diff(times) <= 0).any():
        raise MotionBad(
            f"{name}: fps must lie in {FRAME_RATE_RANGE[0]:g} to {FRAME_RATE_RANGE[1]:g}, "
            "and each key be later than the last."
        )
    count = int(np.floor((times[-1] - times[0]) * rate + 1e-6)) + 1
    if count > MAX_MOTION_FRAME_COUNT:
        raise MotionTooLarge(
            f"{name}: {count} poses are more than {MAX_MOTION_FRAME_COUNT}. {MotionTooLarge().message}"
        )
    turns = np.stack([_pose(key.get("pose"), f"{name}: key {n}") for n, key in enumerate(keys)])
    moves = [_move(key.get("move"), f"{name}: key {n}") for n, key in enumerate(keys)]
    sampled = times[0] + np.arange(count) / rate
    after = np.clip(np.searchsorted(times, sampled, side="right"), 1, max(len(times) - 1, 1))
    before, after = after - 1, np.minimum(after, len(times) - 1)
    share = np.clip((sampled - times[before]) / np.maximum(times[after] - times[before], 1e-12), 0.0, 1.0)
    local = _slerp(turns[before], turns[after], share)
    found = [np.zeros(3) if move is None else move for move in moves]
    root = None
    if any(move is not None for move in moves):
        root = np.stack([np.interp(sampled, times, [move[d] for move in found]) for d in range(3)], axis=1)
    loops = value.get("loop", False)
    if not isinstance(loops, bool):
        raise MotionBad(f"{name}: loop is true or false.")
    return Recording(rate, chain_rotations(local), np.ones(24, dtype=bool), np.zeros((24, 3)), root, loops)


def _slerp(first: np.ndarray, second: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Interpolate rotations [n, 24, 3, 3] by shares [n] from the first to the second (slerp)."""
    start = Rotation.from_matrix(first.reshape(-1, 3, 3))
    rotation = (start.inv() * Rotation.from_matrix(second.reshape(-1, 3, 3))).as_rotvec()
    turned = start * Rotation.from_rotvec(np.repeat(share, 24)[:, None] * rotation)
    return np.asarray(turned.as_matrix()).reshape(-1, 24, 3, 3)


def chain_rotations(local: np.ndarray) -> np.ndarray:
    """Return world rotations from rotations relative to the parent, shape [n, 24, 3, 3]."""
    world = np.empty_like(local)
    for joint, parent in enumerate(JOINT_PARENTS):
        world[:, joint] = local[:, joint] if parent < 0 else world[:, parent] @ local[:, joint]
    return world


def _pose(value: Any, at: str) -> np.ndarray:
    """Return the rotations relative to the parent of one key's pose, shape [24, 3, 3]."""
    if isinstance(value, str):
        return _named(value, at)
    if not isinstance(value, dict):
        raise MotionBad(f"{at}: pose is one of {', '.join(POSES)}, or angles by joint.")
    turns = _named(value["base"], at) if "base" in value else np.tile(np.eye(3), (24, 1, 1))
    for joint, angles in value.items():
        if joint == "base":
            continue
        if joint not in JOINTS:
            raise MotionBad(f"{at}: no joint '{str(joint)[:40]}'; there are {', '.join(JOINTS)}.")
        turns[JOINTS.index(joint)] = Rotation.from_euler("XYZ", _triple(angles, f"{at}: {joint}"), True).as_matrix()
    return turns


def _named(name: Any, at: str) -> np.ndarray:
    if name not in POSES:
        raise MotionBad(f"{at}: no pose '{str(name)[:40]}'; there are {', '.join(POSES)}.")
    return np.asarray(Rotation.from_rotvec(named_pose(name)).as_matrix())


def _move(value: Any, at: str) -> np.ndarray | None:
    return None if value is None else _triple(value, f"{at}: move")


def _triple(numbers: Any, at: str) -> np.ndarray:
    if not isinstance(numbers, list) or len(numbers) != 3:
        raise MotionBad(f"{at}: give three numbers.")
    return np.array([_number(value, at) for value in numbers])


def _number(value: Any, at: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= 1e6:
        raise MotionBad(f"{at} must be a number, not {str(value)[:40]!r}.")
    return float(value)
