"""Motions in SMPL's format: axis-angles of the joints and places of the pelvis, as plain arrays in an `.npz` file."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from ...run.npy import read_array
from .errors import MotionBad, MotionTooLarge
from .keys import FRAME_RATE_RANGE, chain_rotations
from .recording import MAX_MOTION_FRAME_COUNT, Recording

RATE_NAMES = ("mocap_framerate", "mocap_frame_rate", "fps", "framerate")
"""Names of the frame rate [1/s] in files; without any it is 30."""

MAX_POSE_VALUE_COUNT = 400
"""Largest number of values of one pose: SMPL-X has 165."""

SMPL_LEG_LENGTH = 0.8
"""Length of thigh and shin of SMPL's mean body [m], by which `trans` is scaled."""

Y_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
"""Rotation from z up to y up."""

POSE_PART_NAMES = (("root_orient", "global_orient"), ("pose_body", "body_pose"))
"""Names, in files without `poses`, of the rotation of the pelvis [n, 3] and those of the 21 joints after it [n, 63]."""

TRANSLATION_NAMES = ("trans", "transl")
"""Names of the places of the pelvis in files."""


def read_smpl_motion(path: Path) -> Recording:
    """Read `poses` [n, 72 or more], or `root_orient` [n, 3] and `pose_body` [n, 63] (rad), and `trans` [n, 3] (m).

    The first 24 joints are used; with more than 72 values a pose (hands, a face) the first 22, and the hands' bones
    follow the wrists. Up is y or z, by the mean posture of the whole motion; a motion with z up, as in most
    collections, is rotated. Nothing is unpickled.

    Raises:
        MotionBad: where an array is missing or of another shape or kind.
        MotionTooLarge: where there are more than `MAX_MOTION_FRAME_COUNT` poses.
    """
    arrays = _read(Path(path))
    poses = _join_poses(arrays, path.name)
    joints = 24 if poses.shape[1] == 72 else 22
    local = np.tile(np.eye(3), (len(poses), 24, 1, 1))
    turned = Rotation.from_rotvec(poses[:, : 3 * joints].reshape(-1, 3)).as_matrix()
    local[:, :joints] = turned.reshape(-1, joints, 3, 3)
    trans = next((arrays[name] for name in TRANSLATION_NAMES if name in arrays), np.zeros((len(poses), 3)))
    if trans.shape != (len(poses), 3) or not np.isfinite(trans).all():
        raise MotionBad(f"{path.name}: trans has the shape {trans.shape}, expected {(len(poses), 3)} in metres.")
    rate = next((float(arrays[name].ravel()[0]) for name in RATE_NAMES if name in arrays and arrays[name].size), 30.0)
    if not FRAME_RATE_RANGE[0] <= rate <= FRAME_RATE_RANGE[1]:
        raise MotionBad(
            f"{path.name}: a rate of {rate:g} a second is outside {FRAME_RATE_RANGE[0]:g} to {FRAME_RATE_RANGE[1]:g}."
        )
    upright = local[:, 0, :, 1].mean(axis=0)
    is_z_up = bool(upright[2] > upright[1])
    if is_z_up:
        local[:, 0], trans = Y_UP @ local[:, 0], trans @ Y_UP.T
    known = np.arange(24) < joints
    note = f"Up is +{'z' if is_z_up else 'y'} of the file, as the pelvis is held on the mean of the whole motion."
    return Recording(rate, chain_rotations(local), known, np.zeros((24, 3)), trans / SMPL_LEG_LENGTH, notes=(note,))


def _join_poses(arrays: dict[str, np.ndarray], name: str) -> np.ndarray:
    """Return the axis-angles of each pose, shape [n, 66 or more]; raise `MotionBad` where shape or kind are wrong."""
    names = ("poses",) if "poses" in arrays else [each for piece in POSE_PART_NAMES for each in piece if each in arrays]
    parts = [arrays[each] for each in names]
    shapes = ", ".join(str(each.shape) for each in parts)
    if not all(each.ndim >= 2 and len(each) == len(parts[0]) for each in parts):
        raise MotionBad(f"{name}: poses have the shape {shapes}, expected [n, 72].")
    joined = np.concatenate([each.reshape(len(each), int(np.prod(each.shape[1:]))) for each in parts], axis=1)
    if joined.shape[1] < 66 or not len(joined) or not np.isfinite(joined).all():
        raise MotionBad(f"{name}: poses have the shape {shapes}, expected [n, 72] in radians.")
    return joined


def _read(path: Path) -> dict[str, np.ndarray]:
    def judge(shape: tuple[int, ...], kind: np.dtype) -> None:
        if kind.hasobject or kind.kind not in "iuf":
            raise MotionBad(f"{path.name} holds {kind}, not numbers. {MotionBad().message}")
        if len(shape) > 3 or int(np.prod(shape, dtype=object)) > MAX_MOTION_FRAME_COUNT * MAX_POSE_VALUE_COUNT:
            raise MotionTooLarge(f"{path.name}: an array of the shape {shape}. {MotionTooLarge().message}")

    try:
        with zipfile.ZipFile(path) as archive:
            names = {name.removesuffix(".npy") for name in archive.namelist()}
            if "poses" not in names and not all(any(each in names for each in piece) for piece in POSE_PART_NAMES):
                raise MotionBad(
                    f"{path.name} has no array 'poses', nor 'root_orient' and 'pose_body'. {MotionBad().message}"
                )
            found = {}
            pose_names = ("poses",) if "poses" in names else tuple(each for piece in POSE_PART_NAMES for each in piece)
            for name in (*pose_names, *TRANSLATION_NAMES, *RATE_NAMES):
                if name in names:
                    with archive.open(f"{name}.npy") as entry:
                        found[name] = np.asarray(read_array(entry, judge), dtype=np.float64)
    except (MotionBad, MotionTooLarge):
        raise
    except Exception as error:  # zipfile, zlib, lzma and numpy's header reader fail in any way on a hostile file
        raise MotionBad(f"{path.name} cannot be read: {str(error)[:80]}. {MotionBad().message}") from error
    count = max(len(found[name]) if found[name].ndim else 0 for name in pose_names if name in found)
    if count > MAX_MOTION_FRAME_COUNT:
        raise MotionTooLarge(f"{path.name}: {count} poses. {MotionTooLarge().message}")
    return found
