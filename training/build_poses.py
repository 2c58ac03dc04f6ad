"""Make `core/body/assets/poses.npz`, poses that differ as much as they can, from the motions of DeepMimic.

Run it as `python -m garmentq.training.build_poses FOLDER`, where FOLDER holds the `humanoid3d_*.txt` of `data/motions`
of xbpeng/DeepMimic (MIT): walks, runs, jumps, kicks, punches, spins, dances, rolls, crawls, and getting up.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from ..core.body.body import JOINT_PARENTS, JOINTS
from ..core.body.fit import axis_angles_of
from ..core.body.motion.recording import Recording
from ..core.body.motion.retarget import retarget
from ..core.body.person_search import POSE_FILE
from ..core.body.template import Template, load_template
from .wearer import stand

COUNT = 240
"""Poses that are kept: beyond them the next one has its joints within 5 cm of one that is kept."""

JOINT_ORDER = (
    ("pelvis", 4), ("spine3", 4), ("neck", 4), ("right_hip", 4), ("right_knee", 1), ("right_ankle", 4),
    ("right_shoulder", 4), ("right_elbow", 1), ("left_hip", 4), ("left_knee", 1), ("left_ankle", 4),
    ("left_shoulder", 4), ("left_elbow", 1),
)  # fmt: skip
"""Joints of a file's rows and the numbers of each: a quaternion w, x, y, z, or the angle of a hinge about z."""

PARENTS = {
    "spine3": "pelvis", "neck": "spine3", "right_hip": "pelvis", "right_knee": "right_hip", "right_ankle": "right_knee",
    "right_shoulder": "spine3", "right_elbow": "right_shoulder", "left_hip": "pelvis", "left_knee": "left_hip",
    "left_ankle": "left_knee", "left_shoulder": "spine3", "left_elbow": "left_shoulder",
}  # fmt: skip
"""Parent of each joint in the files' skeleton."""

TO_OUR_AXES = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
"""From the files' axes, x ahead and z to the right, to ours, z ahead and x to the left."""


def read_clip(path: Path) -> Recording:
    """Return the motion of a file."""
    frames = np.array(json.loads(path.read_text())["Frames"])
    turns = np.tile(np.eye(3), (len(frames), 24, 1, 1))
    known, column = np.zeros(24, bool), 4
    for name, size in JOINT_ORDER:
        values = frames[:, column : column + size]
        local = Rotation.from_quat(np.roll(values, -1, axis=1)) if size == 4 else _hinge(values)
        column += size
        own = TO_OUR_AXES @ local.as_matrix() @ TO_OUR_AXES.T
        joint = JOINTS.index(name)
        turns[:, joint] = own if name == "pelvis" else turns[:, JOINTS.index(PARENTS[name])] @ own
        known[joint] = True
    bones = np.zeros((24, 3))
    for side in ("left", "right"):
        for name in ("shoulder", "elbow", "hip", "knee"):
            bones[JOINTS.index(f"{side}_{name}")] = [0.0, -1.0, 0.0]
    return Recording(30.0, turns, known, bones, None)


def _hinge(angles: np.ndarray) -> Rotation:
    """Return rotations about z, shape [n, 1]."""
    return Rotation.from_rotvec(angles * [0.0, 0.0, 1.0])


def choose_poses(template: Template, angles: np.ndarray, count: int) -> np.ndarray:
    """Return the indices of poses, [n, 24, 3], that lie farthest apart by the places of their joints, one by one."""
    body = [stand(template, template.means["male"], one).joints for one in angles]
    places = np.array([joints - joints[0] for joints in body])
    chosen = [0]
    away = np.full(len(places), np.inf)
    while len(chosen) < min(count, len(places)):
        away = np.minimum(away, np.linalg.norm(places - places[chosen[-1]], axis=2).mean(axis=1))
        chosen.append(int(away.argmax()))
    return np.array(chosen)


def build(folder: Path, path: Path = POSE_FILE, count: int = COUNT) -> int:
    """Write the poses and return their number."""
    template = load_template()
    body = stand(template, template.means["male"], np.zeros((len(JOINT_PARENTS), 3)))
    angles, clips = [], []
    for file in sorted(folder.glob("humanoid3d_*.txt")):
        track = retarget(read_clip(file), body)
        own = np.array([axis_angles_of(turns) for turns in track.turns])
        angles.append(own)
        clips += [file.stem.removeprefix("humanoid3d_")] * len(own)
    every = np.concatenate(angles)
    chosen = choose_poses(template, every, count)
    np.savez_compressed(path, angles=every[chosen].astype(np.float16), clips=np.array(clips)[chosen])
    return len(chosen)


def main() -> None:
    """Write the file from a folder."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder", type=Path)
    options = parser.parse_args()
    print(f"{build(options.folder)} poses in {POSE_FILE}, {POSE_FILE.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
