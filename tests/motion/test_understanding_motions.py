"""Where up is, which joints matter, and what a reader makes of SMPL's arrays and of rows that are not as stated."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.body.body import JOINTS
from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.motion.errors import MotionBad, MotionForeign
from garmentq.core.body.motion.joint_words import Part, name_part, split_name
from garmentq.core.body.motion.read import load_motion
from garmentq.core.body.motion.retarget import retarget
from scipy.spatial.transform import Rotation

from .foreign import FRAMES, TO_Z_UP, make_reference, still, turn_axes, write_bvh
from .test_foreign_skeletons import names_of


def load(content, tmp_path, name="m.bvh"):
    """Return the recording of a file."""
    path = tmp_path / name
    path.write_bytes(content)
    return load_motion(path)


@pytest.mark.parametrize(
    ("name", "side", "part"),
    [
        ("lShldr", "left", Part.SHOULDER), ("rThighBend", "right", Part.THIGH), ("lhip", "left", Part.HIP),
        ("LeftUpLeg", "left", Part.THIGH), ("LUArm", "left", Part.UPPER_ARM), ("RFArm", "right", Part.FOREARM),
        ("upper_arm.L.001", "left", Part.UPPER_ARM), ("CC_Base_R_ToeBase", "right", Part.TOE),
        ("HandTipLeft", "left", None), ("LeftHandThumb1", "left", None), ("HeadTop_End", "", None),
        ("Armature", "", None), ("eyeball_l", "left", None), ("lowerback", "", Part.SPINE),
        ("rRadius", "right", Part.FOREARM),
        ("Larry", "", None), ("ellbow", "", None),
    ],
)  # fmt: skip
def test_names_are_split(name, side, part):
    """Broken where a side's letter is cut out of other words, or fingers and handles are taken for limbs."""
    found, words = split_name(name)
    assert (found, name_part(words)) == (side, part)


def bent(degrees):
    """Return the plain motion with the pelvis turned about the side's axis by an angle in each pose."""
    model = make_reference()
    for role, node in model.items():
        model[role] = type(node)(node.parent, node.offset, still(), node.move)
    node = model["pelvis"]
    turns = Rotation.from_euler("x", np.reshape(degrees, (-1, 1)), degrees=True).as_matrix()
    model["pelvis"] = type(node)(node.parent, node.offset, turns, node.move)
    return model


@pytest.mark.parametrize("axes", [np.eye(3), TO_Z_UP])
@pytest.mark.parametrize("degrees", [np.linspace(85, 0, FRAMES), np.full(FRAMES, 60.0), np.linspace(0, 360, FRAMES)])
def test_up_is_judged_over_rest_pose_and_motion(axes, degrees, tmp_path):
    """Broken where a bent first pose, a person bent all the time, or one who rolls, tips the world over."""
    recording = load(write_bvh(turn_axes(bent(degrees), axes), names_of("plain")), tmp_path)
    up = "+z" if axes is TO_Z_UP else "+y"
    assert sum(note.startswith(f"Up is {up} of the file") for note in recording.notes) == 1
    wanted = Rotation.from_euler("x", np.reshape(degrees, (-1, 1)), degrees=True).as_matrix()
    np.testing.assert_allclose(recording.turns[:, 0], wanted, atol=1e-5)


def test_who_is_turned_by_own_channels_stands_and_who_lies_lies(tmp_path):
    """Broken where a rest pose that the hips' own channels turn up lies, or a sleeper is set upright."""
    lying = bent(np.full(FRAMES, -90.0))  # on the back, the trunk along -z
    node = lying["pelvis"]
    on_floor = np.tile([0.0, 12.0, 300.0], (FRAMES, 1))
    lying["pelvis"] = type(node)(node.parent, node.offset, node.turns, on_floor)
    asleep = load(write_bvh(lying, names_of("plain")), tmp_path)
    assert any("Up is +y of the file, by the rest pose; the person is not upright" in note for note in asleep.notes)
    np.testing.assert_allclose(asleep.turns[:, 0], lying["pelvis"].turns, atol=1e-5)
    turned = turn_axes(bent(np.zeros(FRAMES)), TO_Z_UP)
    node = turned["pelvis"]
    stands = np.stack([np.zeros(FRAMES), np.full(FRAMES, 92.0), np.linspace(0, 90, FRAMES)], axis=1)
    turned["pelvis"] = type(node)(node.parent, node.offset, TO_Z_UP.T @ node.turns, stands)
    upright = load(write_bvh(turned, names_of("plain")), tmp_path)
    assert any("Up is +y of the file, along which the person is held" in note for note in upright.notes)
    np.testing.assert_allclose(upright.turns[:, 0] @ [0, 1, 0], np.tile([0.0, 1.0, 0.0], (FRAMES, 1)), atol=1e-5)
    assert np.ptp(upright.root[:, 1]) < 1e-6


def test_what_stays_stiff_is_told_apart_from_fingers(tmp_path):
    """Broken where a limb that is not understood is one more name in a list, or fingers raise a doubt."""
    model, names = make_reference(), names_of("plain")
    model["finger"] = type(model["head"])("left wrist", np.array([9.0, 0, 0]), model["head"].turns)
    model["tail"] = type(model["head"])("pelvis", np.array([0.0, 0, -20]), model["head"].turns)
    recording = load(write_bvh(model, names | {"finger": "LeftHandIndex1", "tail": "Tail"}), tmp_path)
    assert recording.doubts() == ()
    assert any("turn and were not used: Tail." in note for note in recording.notes)
    assert any("fingers" in note and "LeftHandIndex1" in note for note in recording.notes)
    for role in ("right shoulder", "right elbow", "right wrist", "right collar"):
        del model[role]
    recording = load(write_bvh(model, names), tmp_path)
    assert recording.missing() == ("right_shoulder", "right_elbow", "right_wrist")
    assert "right_shoulder, right_elbow, right_wrist" in recording.doubts()[0]


@pytest.mark.parametrize(
    ("old", "new", "fits"),
    [
        (b"Frames: 9", b"Frames: 400", True),
        (b"HIERARCHY", b"# written by hand\nHIERARCHY", True),
        (b"MOTION", b"motion", True),
        (b"CHANNELS 6 ", b"CHANNELS 6\n ", True),
        (b"\n0.000000 92", b"\n1 0.000000 92", False),
        (b"Frame Time:", b"Frame Rate:", False),
    ],
)
def test_what_is_stated_wrongly_is_read_or_refused(old, new, fits, tmp_path):
    """Broken where a file that holds whole rows is refused, or rows that have no place in the channels are shifted."""
    content = write_bvh(make_reference(), names_of("plain"))
    assert old in content
    if fits:
        assert len(load(content.replace(old, new, 1), tmp_path).turns) == FRAMES
        return
    with pytest.raises(MotionBad):
        load(content.replace(old, new, 1), tmp_path)


def test_a_row_that_breaks_off_is_left_out(tmp_path):
    """Broken where a recording that was killed while it was written is refused, or its last row is made up."""
    content = write_bvh(make_reference(), names_of("plain"))
    recording = load(content[: content.rindex(b" ", 0, -200)] + b"\n", tmp_path)
    assert len(recording.turns) == FRAMES - 1
    assert any("breaks off" in note for note in recording.notes)


def test_other_encodings_and_commas_that_separate(tmp_path):
    """Broken where UTF-16 is no text, or a comma between numbers becomes a point."""
    content = write_bvh(make_reference(), names_of("plain")).decode()
    whole = load(content.encode(), tmp_path)
    np.testing.assert_allclose(load(content.encode("utf-16"), tmp_path).turns, whole.turns)
    head, _, tail = content.partition("Frame Time")
    first, *rows = tail.splitlines()
    spaced = "\n".join([first, *(row.replace(" ", ", ") for row in rows)])
    np.testing.assert_allclose(load(f"{head}Frame Time{spaced}\n".encode(), tmp_path).turns, whole.turns)


def test_two_legs_on_nothing_are_no_person(tmp_path):
    """Broken where a chain of joints without a place that both legs branch from is taken for a person."""
    model = make_reference()
    model["right hip"] = type(model["head"])("left hip", np.array([-9.0, -4, 0]), still())
    with pytest.raises(MotionForeign):
        load(write_bvh(model, names_of("plain")), tmp_path)


def smpl(tmp_path, **arrays):
    """Return the recording of an archive of arrays."""
    path = tmp_path / "m.npz"
    np.savez(path, **arrays)
    return load_motion(path)


def test_smpl_x_in_pieces_is_read(tmp_path):
    """Broken where a file of `root_orient` and `pose_body` is refused, or its joints are shifted."""
    poses = np.random.default_rng(1).normal(0.0, 0.2, (4, 66))
    way = np.random.default_rng(2).normal(0.0, 0.01, (4, 3))
    whole = smpl(tmp_path, poses=np.concatenate([poses, np.zeros((4, 90))], axis=1), trans=way)
    for root, body, trans in (("root_orient", "pose_body", "trans"), ("global_orient", "body_pose", "transl")):
        found = smpl(tmp_path, **{root: poses[:, :3], body: poses[:, 3:].reshape(4, 21, 3), trans: way})
        np.testing.assert_array_equal(found.turns, whole.turns)
        np.testing.assert_array_equal(found.root, whole.root)
    for wrong in ({"root_orient": poses[:, :3]}, {"root_orient": poses[:2, :3], "pose_body": poses[:, 3:]}):
        with pytest.raises(MotionBad):
            smpl(tmp_path, **wrong)


@pytest.mark.parametrize("is_z_up", [True, False])
def test_smpl_that_begins_bent_over_stands(is_z_up, tmp_path):
    """Broken where the first pose alone tells up: a mocap with z up that begins bent over then lies throughout."""
    poses = np.zeros((20, 72))
    poses[:, 0] = np.concatenate([np.full(3, np.deg2rad(80.0)), np.linspace(np.deg2rad(80), 0, 6), np.zeros(11)])
    if is_z_up:
        upright = Rotation.from_matrix(TO_Z_UP)
        poses[:, :3] = (upright * Rotation.from_rotvec(poses[:, :3])).as_rotvec()
    recording = smpl(tmp_path, poses=poses, trans=np.zeros((20, 3)))
    assert any(f"Up is +{'z' if is_z_up else 'y'}" in note for note in recording.notes)
    body = builtin_body("builtin:female,height=1.70")
    last = retarget(recording, body).turns[-1, JOINTS.index("pelvis")]
    np.testing.assert_allclose(last @ [0, 1, 0], [0, 1, 0], atol=1e-6)
