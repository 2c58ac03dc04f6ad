"""Motions of SMPL's format: axis-angle of each joint and the way of the pelvis, as plain arrays in an `.npz` file."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from ..npy import read_array
from .errors import MotionBad, MotionTooLarge
from .keys import RATES, chain_turns
from .recording import MOST_FRAMES, Recording

RATE_NAMES = ("mocap_framerate", "mocap_frame_rate", "fps", "framerate")
"""Names under which files hold their rate [1/s]; without any it is 30."""

WIDEST = 400
"""Values of one pose at most: SMPL-X has 165."""

LEG = 0.8
"""Length of thigh and shin of SMPL's mean body [m]: what `trans` is measured in."""

Y_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
"""From z up to y up."""


def read_smpl_motion(path: Path) -> Recording:
    """Read `poses` [n, 72 or more] (rad) and `trans` [n, 3] (m) of an `.npz` file.

    The first 24 joints count; where there are more than 72 values a pose (hands, a face), the first 22, and the hands'
    bones keep to the wrists. A person who lies on the back at first stands with z up, as in most collections: the
    motion is then turned to y up. Nothing is unpickled.

    Raises:
        MotionBad: where an array is missing or of another shape or kind.
        MotionTooLarge: where there are more than `MOST_FRAMES` poses.
    """
    arrays = _read(Path(path))
    poses = arrays["poses"]
    poses = poses.reshape(len(poses), int(np.prod(poses.shape[1:])))
    if poses.shape[1] < 66 or not len(poses) or not np.isfinite(poses).all():
        raise MotionBad(f"{path.name}: poses have the shape {arrays['poses'].shape}, expected [n, 72] in radians.")
    joints = 24 if poses.shape[1] == 72 else 22
    local = np.tile(np.eye(3), (len(poses), 24, 1, 1))
    turned = Rotation.from_rotvec(poses[:, : 3 * joints].reshape(-1, 3)).as_matrix()
    local[:, :joints] = turned.reshape(-1, joints, 3, 3)
    trans = arrays.get("trans", np.zeros((len(poses), 3)))
    if trans.shape != (len(poses), 3) or not np.isfinite(trans).all():
        raise MotionBad(f"{path.name}: trans has the shape {trans.shape}, expected {(len(poses), 3)} in metres.")
    rate = next((float(arrays[name].ravel()[0]) for name in RATE_NAMES if name in arrays and arrays[name].size), 30.0)
    if not RATES[0] <= rate <= RATES[1]:
        raise MotionBad(f"{path.name}: a rate of {rate:g} a second is outside {RATES[0]:g} to {RATES[1]:g}.")
    if local[0, 0, 2, 1] > np.sqrt(0.5):  # the pelvis' up lies along +z
        local[:, 0], trans = Y_UP @ local[:, 0], trans @ Y_UP.T
    known = np.arange(24) < joints
    return Recording(rate, chain_turns(local), known, np.zeros((24, 3)), trans / LEG)


def _read(path: Path) -> dict[str, np.ndarray]:
    def judge(shape: tuple[int, ...], kind: np.dtype) -> None:
        if kind.hasobject or kind.kind not in "iuf":
            raise MotionBad(f"{path.name} holds {kind}, not numbers. {MotionBad().message}")
        if len(shape) > 3 or int(np.prod(shape, dtype=object)) > MOST_FRAMES * WIDEST:
            raise MotionTooLarge(f"{path.name}: an array of the shape {shape}. {MotionTooLarge().message}")

    try:
        with zipfile.ZipFile(path) as archive:
            names = {name.removesuffix(".npy") for name in archive.namelist()}
            if "poses" not in names:
                raise MotionBad(f"{path.name} has no array 'poses'. {MotionBad().message}")
            found = {}
            for name in ("poses", "trans", *RATE_NAMES):
                if name in names:
                    with archive.open(f"{name}.npy") as entry:
                        found[name] = np.asarray(read_array(entry, judge), dtype=np.float64)
    except (MotionBad, MotionTooLarge):
        raise
    except Exception as error:  # zipfile, zlib, lzma and numpy's header reader fail in any way on a hostile file
        raise MotionBad(f"{path.name} cannot be read: {str(error)[:80]}. {MotionBad().message}") from error
    if found["poses"].shape[:1] > (MOST_FRAMES,):
        raise MotionTooLarge(f"{path.name}: {len(found['poses'])} poses. {MotionTooLarge().message}")
    if found["poses"].ndim < 2:
        raise MotionBad(f"{path.name}: poses have the shape {found['poses'].shape}, expected [n, 72].")
    return found
