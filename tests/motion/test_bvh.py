"""BVH: rotations are those that the file says, foreign skeletons are understood, hostile files end in codes."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from garmentq.core.body.body import JOINTS
from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.motion.bvh import pose_skeleton
from garmentq.core.body.motion.bvh_text import parse_bvh
from garmentq.core.body.motion.errors import MotionBad, MotionForeign, MotionTooLarge
from garmentq.core.body.motion.moving_body import MovingBody
from garmentq.core.body.motion.read import load_motion
from garmentq.core.body.motion.retarget import retarget
from garmentq.core.body.motion.track import Pose
from scipy.spatial.transform import Rotation

LEG = "OFFSET {x} 0 0\nCHANNELS 3 {order}\nJOINT {side}{knee} {{\nOFFSET 0 -40 0\nCHANNELS 3 {order}\n" \
    "JOINT {side}{ankle} {{\nOFFSET 0 -40 0\nCHANNELS 0\nEnd Site {{\nOFFSET 0 -5 10\n}}\n}}\n}}\n"  # fmt: skip


THIGHS = ("Hips", "UpLeg", "Leg", "Foot")


def make_bvh(rows, order="Zrotation Xrotation Yrotation", names=THIGHS, sides=("Left", "Right"), frames=None):
    """Return a file of pelvis and two legs; each row holds root position, root angles, then three for each joint."""
    root, hip, knee, ankle = names
    text = f"HIERARCHY\nROOT {root}\n{{\nOFFSET 0 0 0\nCHANNELS 6 Xposition Yposition Zposition {order}\n"
    for side, x in zip(sides, (10, -10), strict=True):
        text += f"JOINT {side}{hip} {{\n" + LEG.format(x=x, order=order, side=side, knee=knee, ankle=ankle) + "}\n"
    text += (
        f"JOINT Tail {{\nOFFSET 0 5 0\nCHANNELS 0\n}}\n}}\nMOTION\nFrames: {frames or len(rows)}\nFrame Time: 0.05\n"
    )
    return text + "\n".join(" ".join(str(value) for value in row) for row in rows) + "\n"


def write(tmp_path, text, name="m.bvh"):
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("order", ["Zrotation Xrotation Yrotation", "Xrotation Yrotation Zrotation"])
def test_rotations_are_those_of_the_channels(order, tmp_path):
    """Broken where a channel order is read backwards, or a joint's turn is not chained to its parent's."""
    angles = np.random.default_rng(3).uniform(-60, 60, (2, 15))
    text = make_bvh(np.concatenate([np.zeros((2, 3)), angles], axis=1), order)
    found = parse_bvh(text, "m")
    turns = pose_skeleton(found.skeleton, found.values).turns
    axes = "".join(word[0] for word in order.split())
    for frame in range(2):
        root, hip, knee = (Rotation.from_euler(axes, angles[frame, k : k + 3], degrees=True) for k in (0, 3, 6))
        np.testing.assert_allclose(turns[frame, 2], (root * hip * knee).as_matrix(), atol=1e-12)
    assert found.rate == pytest.approx(20.0)


@pytest.mark.parametrize(
    ("names", "sides"),
    [
        (("Hips", "UpLeg", "Leg", "Foot"), ("Left", "Right")),
        (("mixamorig:Hips", "UpLeg", "Leg", "Foot"), ("mixamorig:Left", "mixamorig:Right")),
        (("Pelvis", "Hip", "Knee", "Ankle"), ("L_", "R_")),
        (("Bip01", " Thigh", " Calf", " Foot"), ("Bip01 L", "Bip01 R")),
        (("Hips", "Hip", "Knee", "Ankle"), ("Left", "Right")),
    ],
)
def test_a_bent_knee_is_a_bent_knee(names, sides, tmp_path):
    """Broken where a foreign name is not understood, left and right are swapped, or the angle changes on the way."""
    rows = [[0.0] * 18, [0, 0, 0, *[0.0] * 3, *[0.0] * 3, 0, 60, 0, *[0.0] * 6]]
    body = builtin_body("builtin:female,height=1.70,pose=A")
    recording = load_motion(write(tmp_path, make_bvh(rows, names=names, sides=sides)))
    track = retarget(recording, body)
    pose = track.at(0.05)
    bent = Rotation.from_matrix(pose.turns[JOINTS.index("left_knee")]).magnitude()
    assert np.degrees(bent) == pytest.approx(60.0, abs=10.0)  # our shin is not in line with our thigh
    assert np.degrees(Rotation.from_matrix(pose.turns[JOINTS.index("right_knee")]).magnitude()) < 10.0
    joints = MovingBody(body).posed(pose).joints
    shin = joints[JOINTS.index("left_ankle")] - joints[JOINTS.index("left_knee")]
    shin /= np.linalg.norm(shin)
    np.testing.assert_allclose(shin, [0.0, -np.cos(np.pi / 3), -np.sin(np.pi / 3)], atol=1e-9)  # the file's shin
    assert any("Tail" in note for note in recording.notes)


def test_the_way_is_scaled_by_the_legs(tmp_path):
    """Broken where centimetres, or longer legs, make longer steps: half a leg is half a leg."""
    rows = [[0.0] * 18, [0, 0, 40.0, *[0.0] * 15]]
    body = builtin_body("builtin:female,height=1.70")
    track = retarget(load_motion(write(tmp_path, make_bvh(rows))), body)
    legs = [np.linalg.norm(body.joint(f"left_{a}") - body.joint(f"left_{b}")) for a, b in
            (("hip", "knee"), ("knee", "ankle"))]  # fmt: skip
    assert np.ptp(track.pelvis[:, 2]) == pytest.approx(0.5 * sum(legs), rel=0.02)
    assert MovingBody(body).vertices(track.at(0.0))[:, 1].min() == pytest.approx(0.0, abs=0.01)


@pytest.mark.parametrize(
    ("scale", "unit"), [(1.0, "centimetres"), (0.01, "metres"), (1 / 2.54, "inches"), (0.3, "not")]
)
def test_the_unit_and_foreign_names_are_told(scale, unit, tmp_path):
    """Broken where a user cannot see how a foreign file was understood, or another unit makes another motion."""
    rows = np.zeros((2, 18))
    rows[1, 2] = 40.0
    plain = load_motion(write(tmp_path, make_bvh(rows)))
    rows[1, 2] *= scale
    text = make_bvh(rows, sides=("mixamorig:Left", "mixamorig:Right"))
    text = text.replace("-40", str(-40 * scale)).replace("OFFSET 10", f"OFFSET {10 * scale}")
    recording = load_motion(write(tmp_path, text.replace("OFFSET -10", f"OFFSET {-10 * scale}")))
    np.testing.assert_allclose(recording.root, plain.root, atol=1e-6)
    assert any(unit in note and "long" in note for note in recording.notes)
    assert any("left_hip is mixamorig:LeftUpLeg" in note for note in recording.notes)


def test_feet_are_looked_at_in_blocks(tmp_path, monkeypatch):
    """Broken where a block of a long motion is left out, or ends a pose early."""
    rows = np.random.default_rng(2).uniform(-40, 40, (10, 18))
    body, recording = builtin_body("builtin:female,height=1.70"), load_motion(write(tmp_path, make_bvh(rows)))
    whole = retarget(recording, body)
    monkeypatch.setattr(sys.modules["garmentq.core.body.motion.retarget"], "POSE_BLOCK_SIZE", 4)
    np.testing.assert_allclose(retarget(recording, body).pelvis, whole.pelvis, atol=1e-12)


def test_the_own_pose_comes_back(tmp_path):
    """Broken where skinning to the own pose, from which every animation starts, is not the given mesh."""
    body = builtin_body("builtin:male,height=1.80,pose=stride")
    np.testing.assert_allclose(MovingBody(body).vertices(Pose.of(body)), body.vertices, atol=1e-12)


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("", "motion.bad"),
        ("HIERARCHY\nROOT a\n{\nOFFSET 0 0\n}\nMOTION\nFrames: 1\nFrame Time: 0.1\n", "motion.bad"),
        ("HIERARCHY\nROOT a\n{\n" * 1 + "JOINT b\n{\n" * 600, "motion.bad"),
        ("HIERARCHY\nROOT a\n{\n" + "JOINT b\n{\n" * 600 + "MOTION", "motion.too_large"),
        ("HIERARCHY\n}\nMOTION\n", "motion.bad"),
        ("HIERARCHY\nROOT a\n{\nCHANNELS 3 Up Down Strange\n}\nMOTION\n", "motion.bad"),
        (make_bvh([[0.0] * 18], frames=10**9), "motion.too_large"),
        (make_bvh([[0.0] * 17]), "motion.bad"),
        (make_bvh([["nan"] * 18]), "motion.bad"),
        (make_bvh([["x"] * 18]), "motion.bad"),
        (make_bvh([[0.0] * 18], names=("a", "b", "c", "d")), "motion.foreign"),
    ],
)
def test_hostile_files_end_in_codes(text, code, tmp_path):
    """Broken where such a file is a traceback, or is read as something that it does not say."""
    with pytest.raises((MotionBad, MotionTooLarge, MotionForeign)) as caught:
        load_motion(write(tmp_path, text))
    assert caught.value.code == code
