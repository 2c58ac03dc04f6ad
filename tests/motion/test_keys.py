"""JSON keys, SMPL's arrays and the shipped motions."""

from __future__ import annotations

import json

import numpy as np
import pytest
from garmentq.core.body.body import JOINTS
from garmentq.core.body.builtin import builtin_body, named_pose
from garmentq.core.body.motion.errors import MotionBad
from garmentq.core.body.motion.moving_body import MovingBody
from garmentq.core.body.motion.read import load_motion
from garmentq.core.body.motion.retarget import retarget
from garmentq.core.body.motion.shipped import SHIPPED_MOTIONS, find_shipped_motion
from garmentq.core.body.motion.track import LeadIn, Pose
from garmentq.core.body.template import rotations_of
from scipy.spatial.transform import Rotation


@pytest.fixture(scope="module")
def body():
    return builtin_body("builtin:female,height=1.70,pose=A")


def keys(tmp_path, value):
    path = tmp_path / "m.json"
    path.write_text(json.dumps(value), encoding="utf-8")
    return path


def test_between_two_keys_joints_turn_by_slerp(tmp_path, body):
    """Broken where angles are mixed instead of rotations, or the pose by name is another one."""
    given = {"fps": 10, "keys": [{"t": 0, "pose": "A"}, {"t": 1, "pose": {"left_knee": [80, 0, 0]}}]}
    track = retarget(load_motion(keys(tmp_path, given)), body)
    np.testing.assert_allclose(track.at(0.0).turns, rotations_of(named_pose("A")), atol=1e-12)
    half = track.at(0.55)
    assert np.degrees(Rotation.from_matrix(half.turns[JOINTS.index("left_knee")]).magnitude()) == pytest.approx(44.0)
    arm = JOINTS.index("left_shoulder")
    assert Rotation.from_matrix(half.turns[arm]).magnitude() == pytest.approx(
        0.45 * np.linalg.norm(named_pose("A")[arm])
    )


def test_angles_are_turned_about_z_first(tmp_path, body):
    """Broken where the order of a joint's three angles is another: an arm that hangs would swing sideways."""
    given = {"keys": [{"t": 0, "pose": {"base": "arms-down", "left_shoulder": [30, 0, -90]}}]}
    track = retarget(load_motion(keys(tmp_path, given)), body)
    arm = track.at(0.0).turns[JOINTS.index("left_shoulder")] @ [1.0, 0.0, 0.0]
    np.testing.assert_allclose(arm, [0.0, -np.cos(np.pi / 6), -np.sin(np.pi / 6)], atol=1e-12)


@pytest.mark.parametrize(
    "given",
    [
        [], {}, {"keys": []}, {"keys": [1]}, {"keys": [{"t": 0, "pose": "B"}]}, {"keys": [{"t": "x", "pose": "A"}]},
        {"keys": [{"t": 1, "pose": "A"}, {"t": 1, "pose": "A"}]}, {"keys": [{"t": 0, "pose": {"nose": [0, 0, 0]}}]},
        {"keys": [{"t": 0, "pose": {"head": [0, 0]}}]}, {"fps": 1e9, "keys": [{"t": 0, "pose": "A"}]},
        {"keys": [{"t": 0, "pose": "A", "move": [0, None, 0]}]}, {"keys": [{"t": 0, "pose": {"head": [1e400, 0, 0]}}]},
        {"keys": [{"t": 10**400, "pose": "A"}]},
    ],
)  # fmt: skip
def test_wrong_keys_end_in_codes(given, tmp_path):
    """Broken where one of these is a traceback or a motion."""
    with pytest.raises(MotionBad):
        load_motion(keys(tmp_path, given))


@pytest.mark.parametrize("name", SHIPPED_MOTIONS)
def test_shipped_motions_stand_on_the_floor_and_loop(name, body):
    """Broken where a shipped motion sinks into the floor, jumps at its seam, or leaves the place."""
    track, mover = retarget(load_motion(find_shipped_motion(name)), body), MovingBody(body)
    floor = body.vertices[:, 1].min()
    lowest = min(mover.vertices(track.at(t))[:, 1].min() for t in np.linspace(0, 1, 7))
    assert lowest == pytest.approx(floor, abs=0.02)
    step = [
        np.abs(mover.vertices(track.at(t + 1 / 60)) - mover.vertices(track.at(t))).max() for t in (0.5, 0.9917, 2.3)
    ]
    assert max(step) < 0.15
    np.testing.assert_allclose(track.at(3.25).turns, track.at(0.25).turns, atol=1e-9)


def test_the_lead_in_begins_in_the_own_pose(body):
    """Broken where an animation starts with a jump, or joins the motion late."""
    track = retarget(load_motion(find_shipped_motion("walk")), body)
    lead = LeadIn(Pose.of(body), track, 0.5, 1.0)
    np.testing.assert_allclose(lead.at(-0.5).turns, Pose.of(body).turns, atol=1e-12)
    np.testing.assert_allclose(lead.at(0.5).turns, track.at(0.5).turns, atol=1e-12)


def test_smpl_poses_are_read(tmp_path, body):
    """Broken where poses are reordered, or z-up collections lie on their back."""
    poses = np.zeros((3, 72))
    poses[:, 3 * JOINTS.index("right_elbow") + 1] = 1.0
    lying = poses.copy()
    lying[:, 0] = np.pi / 2
    trans = np.array([[0.0, 0.0, 0.0], [0.0, -0.4, 0.0], [0.0, -0.8, 0.0]])
    for name, each in (("a", poses), ("b", lying)):
        path = tmp_path / f"{name}.npz"
        np.savez(path, poses=each, trans=trans, mocap_framerate=60.0)
        recording = load_motion(path)
        assert recording.rate == 60.0
        track = retarget(recording, body)
        elbow = Rotation.from_matrix(track.turns[1, JOINTS.index("right_elbow")]).as_rotvec()
        np.testing.assert_allclose(elbow, [0.0, 1.0, 0.0], atol=1e-9)
    assert np.ptp(track.pelvis[:, 2]) > 0.7  # -y of a lying file is the front
    np.savez(tmp_path / "e.npz", poses=np.zeros((0, 72)))
    with pytest.raises(MotionBad):
        load_motion(tmp_path / "e.npz")
    np.savez(tmp_path / "c.npz", poses=np.array([{}, {}], dtype=object))
    with pytest.raises(MotionBad):
        load_motion(tmp_path / "c.npz")
    (tmp_path / "d.npz").write_bytes(b"PK\3\4 no zip")
    with pytest.raises(MotionBad):
        load_motion(tmp_path / "d.npz")


@pytest.mark.parametrize("name", ["walk", "straight"])
def test_a_part_of_a_motion_begins_where_the_wearer_stands(name, tmp_path, body):
    """Broken where a motion joined late has the wearer flung in the lead-in to where the motion has gone by then."""
    walked = {"keys": [
        {"t": 0, "pose": "A"},
        {"t": 4, "pose": {"pelvis": [0, 90, 0]}, "move": [8, 0, 4]},
        {"t": 8, "pose": {"pelvis": [0, 90, 0]}, "move": [16, 0, 8]},
    ]}  # fmt: skip
    path = find_shipped_motion("walk") if name == "walk" else keys(tmp_path, walked)
    track, own = retarget(load_motion(path), body, begin=4.0), Pose.of(body)
    joined = track.at(4.0)
    np.testing.assert_allclose(joined.pelvis[[0, 2]], own.pelvis[[0, 2]], atol=1e-9)
    front = joined.turns[0] @ [0.0, 0.0, 1.0]
    assert np.arctan2(front[0], front[2]) == pytest.approx(0.0, abs=1e-9)
    floor = min(MovingBody(body).vertices(track.at(t))[:, 1].min() for t in np.linspace(0, 8, 9))
    assert floor == pytest.approx(body.vertices[:, 1].min(), abs=0.02)


@pytest.mark.parametrize("move", [[1000, 0, 0], [1e6, 0, 0]])
def test_a_leap_is_refused(move, tmp_path):
    """Broken where a pelvis that goes a kilometre between two poses is stepped after for ever."""
    leap = {"keys": [{"t": 0, "pose": "A"}, {"t": 1, "pose": "A", "move": move}]}
    with pytest.raises(MotionBad, match="pelvis goes"):
        load_motion(keys(tmp_path, leap))


@pytest.mark.parametrize("wrong", [{"trans": 1e308}, {"trans": 1e200}, {"poses": 1e308}])
def test_numbers_that_cannot_be_reckoned_with_are_refused(wrong, tmp_path):
    """Broken where an overflow becomes rotations or places that are none, and a worker fails on them."""
    arrays = {"poses": np.zeros((2, 72)), "trans": np.zeros((2, 3))}
    for name, value in wrong.items():
        arrays[name][1] = value
    np.savez(tmp_path / "m.npz", **arrays)
    with np.errstate(all="ignore"), pytest.raises(MotionBad):
        load_motion(tmp_path / "m.npz")
