"""Read motions from BVH files of any skeleton."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from .bvh_text import CHANNELS, Skeleton, decode_bvh, parse_bvh
from .errors import MotionTooLarge
from .posed import SkeletonMotion
from .recording import Recording
from .skeleton_map import map_skeleton

MAX_BVH_FILE_BYTES = 64 * 1024**2
"""Largest size of a BVH file [bytes]: twenty minutes of 60 joints at 30 Hz."""


def read_bvh(path: Path) -> Recording:
    """Read a motion from a BVH file; `map_skeleton` has the joints that are recognised.

    Raises:
        MotionBad: where the file is not BVH, with the line that is wrong.
        MotionTooLarge: where it is too large, too long, or has too many joints.
        MotionForeign: where the skeleton is not a person's.
    """
    path = Path(path)
    if path.stat().st_size > MAX_BVH_FILE_BYTES:
        raise MotionTooLarge(f"{path.name} is larger than {MAX_BVH_FILE_BYTES >> 20} MB. {MotionTooLarge().message}")
    text = parse_bvh(decode_bvh(path.read_bytes()), path.name)
    recording = map_skeleton(pose_skeleton(text.skeleton, text.values), text.rate)
    return replace(recording, notes=(*text.notes, *recording.notes))


def pose_skeleton(skeleton: Skeleton, values: np.ndarray) -> SkeletonMotion:
    """Return a skeleton in the poses of channel values, shape [n, channel_count]. A joint's channels are applied in the
    file's order, the first one outermost: for `Zrotation Xrotation Yrotation` R = R_z R_x R_y. Positions replace the
    joint's OFFSET, or add to it if those below the root are nearer to zero than to it."""
    turns = np.zeros((len(values), len(skeleton.names), 3, 3))
    rotations: dict[int, np.ndarray] = {}
    at = 0
    for joint, (parent, channels) in enumerate(zip(skeleton.parents, skeleton.channels, strict=True)):
        columns = values[:, at : at + len(channels)]
        at += len(channels)
        turns[:, joint] = np.eye(3)
        for place, channel in enumerate(channels):
            axis, kind = CHANNELS[channel]
            if kind == "rotation":
                turn = Rotation.from_euler(axis, columns[:, place, None], degrees=True).as_matrix()
                turns[:, joint] = turns[:, joint] @ turn
            else:
                rotations.setdefault(joint, np.full((len(values), 3), np.nan))[:, "XYZ".index(axis)] = columns[:, place]
        if parent >= 0:
            turns[:, joint] = turns[:, parent] @ turns[:, joint]
    moves = _place(skeleton, rotations)
    offsets = skeleton.offsets.copy()
    for joint, rotation in moves.items():
        if skeleton.parents[joint] >= 0 and not offsets[joint].any():
            offsets[joint] = np.median(rotation, axis=0)
    return SkeletonMotion(skeleton.names, skeleton.parents, offsets, turns, moves)


def _place(skeleton: Skeleton, channels: dict[int, np.ndarray]) -> dict[int, np.ndarray]:
    """Return the offset of each joint from its parent, shape [n, 3]; the OFFSET where a channel is missing (NaN)."""
    added = replaced = 0.0
    for joint, rotation in channels.items():
        if skeleton.parents[joint] >= 0:
            added += float(np.nansum(np.abs(rotation)))
            replaced += float(np.nansum(np.abs(rotation - skeleton.offsets[joint])))
    moves = {}
    for joint, rotation in channels.items():
        offset = skeleton.offsets[joint]
        is_added = skeleton.parents[joint] >= 0 and added < replaced
        moves[joint] = np.where(np.isnan(rotation), offset, rotation + offset if is_added else rotation)
    return moves
