"""Limbs that a motion takes into the wearer are spread, smoothly and no more than that takes."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.body.body import JOINTS
from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.exposed import ExposedSurface
from garmentq.core.body.motion.clear_limbs import LIMB_GROUPS, MAX_LIMB_SPREAD_ANGLE, clear_limbs, spread_limbs
from garmentq.core.body.motion.moving_body import MovingBody
from garmentq.core.body.motion.track import Pose, Track
from scipy.spatial.transform import Rotation

ARM = list(LIMB_GROUPS).index("left arm")


@pytest.fixture(scope="module")
def body():
    return builtin_body("builtin:female,height=1.70,pose=A")


def lower(body, angles, rate=30.0, loops=False):
    """Return a motion of the left arm, by the angle between it and the T-pose in each pose [degrees]."""
    turns = np.tile(Pose.of(body).turns, (len(angles), 1, 1, 1))
    turns[:, JOINTS.index("left_collar")] = np.eye(3)
    turns[:, JOINTS.index("left_shoulder")] = Rotation.from_euler(
        "z", -np.array(angles)[:, None], degrees=True
    ).as_matrix()
    return Track(rate, turns, np.tile(Pose.of(body).pelvis, (len(angles), 1)), loops)


def swallowed(body, pose):
    found = ExposedSurface(MovingBody(body).vertices(pose), body.faces, splits=0).hidden_skin
    return 0 if found is None else len(found.faces)


def clear(body, track, cloth=True):
    return clear_limbs(track, body, np.full(len(body.vertices), cloth), 0.0, track.seconds)


def test_an_arm_in_the_trunk_is_spread_until_it_is_out(body):
    """Broken where it stays inside, turns the wrong way, or goes further than the cloth needs."""
    track = lower(body, [80.0])
    found = clear(body, track)
    assert np.deg2rad(2) < found.angles[0, ARM] <= MAX_LIMB_SPREAD_ANGLE
    before, after = (swallowed(body, each.at(0.0)) for each in (track, found.track))
    assert after < 0.6 * before
    assert clear(body, track, cloth=False).angles[0, ARM] < found.angles[0, ARM]
    elbow = JOINTS.index("left_elbow")
    out = [MovingBody(body).posed(each.at(0.0)).joints[elbow, 0] for each in (track, found.track)]
    assert out[1] > out[0] + 0.01


def test_what_is_clear_stays_as_it_is(body):
    """Broken where a motion that has room is changed at all."""
    track = lower(body, [30.0, 35.0, 40.0])
    found = clear(body, track)
    assert not found.angles.any() and not found.missed.any()
    np.testing.assert_array_equal(found.track.turns, track.turns)
    np.testing.assert_array_equal(found.track.pelvis, track.pelvis)


def test_angles_change_smoothly_and_are_never_less_than_needed(body):
    """Broken where limbs jump, a pose between gets less than it needs, or a loop does not close."""
    angles = np.full(31, 40.0)
    angles[0] = angles[30] = 80.0
    need = clear(body, lower(body, [80.0])).angles[0, ARM]
    found = clear(body, lower(body, angles, loops=True)).angles[:, ARM]
    assert found[0] == found[30] and found[0] >= need - 1e-9
    assert found[15] < 0.1 * need
    assert np.abs(np.diff(found, 2)).max() < 0.1 * need


def test_spread_legs_leave_the_feet_on_the_floor_and_flat(body):
    """Broken where a wearer who stands wider hovers, or stands on the edges of the soles."""
    pose, angles = Pose.of(body), np.zeros(3)
    angles[list(LIMB_GROUPS).index("legs")] = np.deg2rad(8)
    mover = MovingBody(body)
    before, after = mover.posed(pose), mover.posed(spread_limbs(pose, body.rest_joints, angles))
    for name in ("left_ankle", "right_foot"):
        joint = JOINTS.index(name)
        np.testing.assert_allclose(after.transforms[joint, :3, :3], before.transforms[joint, :3, :3], atol=1e-12)
        assert abs(after.joints[joint, 0]) > abs(before.joints[joint, 0]) + 0.05
    assert after.joints[:, 1].min() == pytest.approx(before.joints[:, 1].min(), abs=1e-9)
