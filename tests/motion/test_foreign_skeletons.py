"""One motion as other programs write it - names, spelling, roots, units, axes, twist bones - is one motion."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from garmentq.core.body.body import JOINTS
from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.motion.moving_body import MovingBody
from garmentq.core.body.motion.read import load_motion
from garmentq.core.body.motion.retarget import retarget

from .foreign import (
    FRAMES,
    LIMBS,
    TO_Z_UP,
    TRUNK,
    Node,
    Spelling,
    drop,
    insert,
    make_reference,
    pose,
    split_twist,
    still,
    tilt,
    turn_axes,
    wrap,
    write_bvh,
)

SCHEMES = {
    "plain": ("Hips Spine Spine1 Neck Head", "{}", "Left Right", "{s}{}",
              "Shoulder Arm ForeArm Hand UpLeg Leg Foot ToeBase"),
    "mixamo": ("Hips Spine Spine2 Neck Head", "mixamorig:{}", "Left Right", "mixamorig:{s}{}",
               "Shoulder Arm ForeArm Hand UpLeg Leg Foot ToeBase"),
    "mixamo7": ("Hips Spine Spine2 Neck Head", "mixamorig7_{}", "Left Right", "mixamorig7_{s}{}",
                "Shoulder Arm ForeArm Hand UpLeg Leg Foot ToeBase"),
    "poser": ("hip abdomen chest neck head", "{}", "l r", "{s}{}", "Collar Shldr ForeArm Hand Thigh Shin Foot Toe"),
    "genesis": ("hip abdomenLower chestUpper neckLower head", "{}", "l r", "{s}{}",
                "Collar ShldrBend ForearmBend Hand ThighBend Shin Foot Toe"),
    "genesis9": ("hip spine1 spine4 neck1 head", "{}", "l r", "{s}_{}",
                 "shoulder upperarm forearm hand thigh shin foot toes"),
    "deepmotion": ("hips spine spine1 neck head", "{}_JNT", "l r", "{s}_{}_JNT",
                   "shoulder arm forearm hand upleg leg foot toebase"),
    "vrm": ("Hips Spine Chest Neck Head", "J_Bip_C_{}", "L R", "J_Bip_{s}_{}",
            "Shoulder UpperArm LowerArm Hand UpperLeg LowerLeg Foot ToeBase"),
    "vrm humanoid": ("hips spine chest neck head", "{}", "left right", "{s}{}",
                     "Shoulder UpperArm LowerArm Hand UpperLeg LowerLeg Foot Toes"),
    "iclone": ("Hip Waist Spine01 NeckTwist01 Head", "CC_Base_{}", "L R", "CC_Base_{s}_{}",
               "Clavicle Upperarm Forearm Hand Thigh Calf Foot ToeBase"),
    "unreal": ("pelvis spine_01 spine_02 neck_01 head", "{}", "l r", "{}_{s}",
               "clavicle upperarm lowerarm hand thigh calf foot ball"),
    "biped": ("Pelvis Spine Spine1 Neck Head", "Bip01 {}", "L R", "Bip01 {s} {}",
              "Clavicle UpperArm Forearm Hand Thigh Calf Foot Toe0"),
    "biped one": (" Spine Spine1 Neck Head", "Bip001_{}", "L R", "Bip001_{s}_{}",
                  "Clavicle UpperArm Forearm Hand Thigh Calf Foot Toe0"),
    "rigify": ("spine spine.001 spine.003 spine.004 spine.006", "{}", "L R", "{}.{s}",
               "shoulder upper_arm forearm hand thigh shin foot toe"),
    "rigify deforming": ("spine spine.001 spine.003 spine.004 spine.006", "DEF-{}", "L R", "DEF-{}.{s}",
                         "shoulder upper_arm forearm hand thigh shin foot toe"),
    "rigify of a file": ("spine spine.001 spine.003 spine.004 spine.006", "ORG-{}.001", "L R", "ORG-{}.{s}.001",
                         "shoulder upper_arm forearm hand thigh shin foot toe"),
    "makehuman": ("root spine05 spine01 neck01 head", "{}", "L R", "{}.{s}",
                  "clavicle upperarm01 lowerarm01 wrist upperleg01 lowerleg01 foot toe1-1"),
    "kinect": ("SpineBase SpineMid SpineShoulder Neck Head", "{}", "Left Right", "{}{s}",
               "Clavicle Shoulder Elbow Wrist Hip Knee Ankle Foot"),
    "optitrack": ("Hips Ab Chest Neck Head", "{}", "L R", "{s}{}", "Shoulder UArm FArm Hand Thigh Shin Foot Toe"),
    "asf": ("root lowerback thorax lowerneck head", "{}", "l r", "{s}{}",
            "clavicle humerus radius wrist femur tibia foot toes"),
    "lower case": ("hip abdomen chest neck head", "{}", "l r", "{s}{}",
                   "collar shoulder elbow hand hip knee foot toe"),
    "upper case": ("HIPS SPINE SPINE1 NECK HEAD", "{}", "LEFT RIGHT", "{s}{}",
                   "SHOULDER ARM FOREARM HAND UPLEG LEG FOOT TOEBASE"),
    "xsens": ("Hips Chest Chest4 Neck Head", "{}", "Left Right", "{s}{}",
              "Collar Shoulder Elbow Wrist Hip Knee Ankle Toe"),
    "rokoko": ("Hips Spine Spine4 Neck Head", "{}", "Left Right", "{s}{}",
               "Shoulder Arm ForeArm Hand Thigh Shin Foot Toe"),
    "perception neuron": ("Hips Spine Spine1 Neck Head", "Robot_{}", "Left Right", "Robot_{s}{}",
                          "Shoulder Arm ForeArm Hand UpLeg Leg Foot ToeBase"),
    "human ik": ("Hips Spine Spine1 Neck Head", "Character1_{}", "Left Right", "Character1_{s}{}",
                 "Shoulder Arm ForeArm Hand UpLeg Leg Foot ToeBase"),
    "smpl": ("Pelvis Spine1 Spine2 Neck Head", "m_avg_{}", "L R", "m_avg_{s}_{}",
             "Collar Shoulder Elbow Wrist Hip Knee Ankle Foot"),
    "second life": ("Pelvis Torso Chest Neck Head", "m{}", "Left Right", "m{}{s}",
                    "Collar Shoulder Elbow Wrist Hip Knee Ankle Foot"),
    "maya": ("root_jnt spine_01_jnt spine_02_jnt neck_jnt head_jnt", "{}", "lf rt", "{s}_{}_jnt",
             "clav_clavicle arm_upper arm_lower wrist leg_upper leg_lower ankle ball"),
    "paths": ("Hips Spine Chest Neck Head", "rig|hero:{}", "left right", "rig|hero:{}_{s}",
              "shoulder up_arm low_arm hand up_leg low_leg foot toe"),
    "limbs alone": ("a b c d e", "{}", "L R", "{s}_{}", "q arm f hand thigh k foot t"),
    "letters": ("a b c d e", "{}", "f g", "{s}{}", "a b c d e f g h"),
}  # fmt: skip
"""Names of the trunk, how they are set, the sides, how names of a side are set, and these, in the order of `LIMBS`."""

SPELLINGS = {
    "plain": Spelling(),
    "blank and tab": Spelling(blank="\t "),
    "tabs": Spelling(blank="\t", order="XYZ"),
    "lower case": Spelling(lower=True, order="YXZ"),
    "commas": Spelling(comma=True),
    "windows": Spelling(line="\r\n", first="\ufeff"),
    "without ends": Spelling(ends=False, order="ZYX"),
    "a row more": Spelling(frames=-1),
    "a row fewer": Spelling(frames=1),
    "six channels": Spelling(places="replaced", order="XYZ"),
    "added": Spelling(places="added"),
}

ROOTS = ("none", "still", "carrying", "turning", "nested", "tilted", "tilted and placed", "hips inside pelvis", "added")

UNITS = {"cm": 1.0, "m": 0.01, "inch": 1 / 2.54, "mm": 10.0}

EXTRAS = ("none", "twists", "twists of forearms", "long spine", "two necks", "hip joints", "fingers", "legs apart",
          "handles")  # fmt: skip

LACKING = {"no toes": "toe", "no collars": "collar", "one spine": "chest", "no neck": "neck"}
"""Joints that some skeletons lack; in the plain motion that they are compared with these do not turn."""


def names_of(scheme):
    """Return the names of a scheme by role."""
    trunk, middle, sides, sided, parts = SCHEMES[scheme]
    found = {role: middle.format(name) for role, name in zip(TRUNK, trunk.split(" "), strict=True)}
    for side, letter in zip(("left", "right"), sides.split(), strict=True):
        for role, part in zip(LIMBS, parts.split(), strict=True):
            found[f"{side} {role}"] = sided.format(part, s=letter)
    return found


def add_extras(model, names, extra):
    """Return a model with what other skeletons have beyond the plain one, or without what they lack."""
    names = dict(names)
    for side in ("left", "right"):
        name = {role: names[f"{side} {role}"] for role in LIMBS}
        at = {role: f"{side} {role}" for role in LIMBS}
        if extra == "twists":
            for role, end in (("hip", "knee"), ("shoulder", "elbow")):
                model = split_twist(model, at[role], at[end], f"{at[role]} twist")
                names[f"{at[role]} twist"] = f"{name[role]}Twist"
        elif extra == "twists of forearms":
            model = split_twist(model, at["elbow"], at["wrist"], f"{at['elbow']} twist")
            names[f"{at['elbow']} twist"] = f"{name['elbow']}_twist_01"
        elif extra == "hip joints":
            model = insert(model, "pelvis", at["hip"], f"{side} socket", still())
            names[f"{side} socket"] = f"{'LR'[side == 'right']}HipJoint"
        elif extra == "fingers":
            for finger in ("Index", "Thumb"):
                model = insert(model, at["wrist"], "", "", still()) | {
                    f"{side} {finger}": Node(at["wrist"], np.array([9.0, 0, 0]), model["head"].turns)
                }
                names[f"{side} {finger}"] = f"{side.title()}Hand{finger}1"
    if extra == "legs apart":  # the spine hangs on the hips, the legs on a pelvis of their own
        own = {f"{side} hip": replace(model[f"{side} hip"], parent="lower") for side in ("left", "right")}
        (top, node), *others = model.items()
        model = {top: node, "lower": Node(top, np.zeros(3), still()), **dict(others), **own}
        names["lower"] = "lower pelvis"
    elif extra == "handles":
        names |= {"handles": "ik_foot_root", "left handle": "ik_foot_l", "right handle": "ik_foot_r"}
        model["handles"] = Node("pelvis", np.array([0.0, -92, 0]), model["head"].turns)
        for side, x in (("left", 10.0), ("right", -10.0)):
            model[f"{side} handle"] = Node("handles", np.array([x, 10.0, 0]), model["head"].turns)
    elif extra == "long spine":
        model = insert(model, "pelvis", "spine", "lower", still())
        model = insert(model, "spine", "chest", "middle", still())
        model = insert(model, "chest", "neck", "upper", still())
        names |= {"lower": "LowerBack", "middle": "Spine1a", "upper": "chest2"}
    elif extra == "two necks":
        model = insert(model, "neck", "head", "neck 2", still())
        names |= {"neck 2": "Neck1"}
    return model, names


def add_root(model, names, root):
    """Return a model under what other programs put above the hips."""
    zero, time = np.zeros((FRAMES, 3)), np.linspace(0.0, 1.0, FRAMES)
    yaw = np.array([[[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]] for a in time])
    if root == "still":
        return wrap(model, "reference", still(), zero), names
    if root == "carrying":
        return wrap(model, "root", still(), model["pelvis"].move), names
    if root == "turning":
        return wrap(model, "Armature", yaw, np.stack([30 * time, 0 * time, 50 * time], axis=1)), names
    if root == "nested":
        return wrap(wrap(model, "Reference", yaw, 20 + zero), "World", still(), 7 + zero), names
    if root == "tilted":
        return tilt(model, "Armature"), names
    if root == "tilted and placed":
        return wrap(tilt(model, "Armature"), "Scene", still(), 11 + zero), names
    if root == "hips inside pelvis":
        names = names | {"root pelvis": "pelvis"}
        return wrap(model, "root pelvis", model["pelvis"].turns, model["pelvis"].move), names
    return model, names


@cache
def _body():
    return builtin_body("builtin:female,height=1.70,pose=A")


def read(content, tmp_path):
    """Return recording and the joints' places [n, 24, 3] and turns [n, 24, 3, 3] on our body, from a file."""
    path = tmp_path / "m.bvh"
    path.write_bytes(content)
    recording, mover = load_motion(path), MovingBody(_body())
    track = retarget(recording, mover.body)
    poses = [mover.transforms(track.at(n / track.rate)) for n in range(FRAMES)]
    turns = np.stack([each[:, :3, :3] for each in poses])
    places = np.einsum("njab,jb->nja", turns, mover.body.rest_joints) + np.stack([each[:, :3, 3] for each in poses])
    return recording, places, turns


def degrees_between(first, second):
    """Return the angles between rotations [..., 3, 3] in degrees."""
    trace = np.einsum("...ab,...ab->...", first, second)
    return np.degrees(np.arccos(np.clip((trace - 1.0) / 2.0, -1.0, 1.0)))


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """Return places and turns of the plain file."""
    _, places, turns = read(write_bvh(make_reference(), names_of("plain")), tmp_path_factory.mktemp("plain"))
    return places, turns


def check_same(content, plain, tmp_path):
    """Check that a file gives the plain motion within 0.5 degrees and 1 mm, and return its recording."""
    recording, places, turns = read(content, tmp_path)
    assert degrees_between(turns, plain[1]).max() < 0.5
    assert np.linalg.norm(places - plain[0], axis=2).max() < 1e-3
    assert not recording.missing()
    return recording


def test_the_plain_motion_is_that_of_the_file(plain):
    """Broken where any joint of the plain file is mapped to another one of ours, or a turn gets lost."""
    model = make_reference()
    wanted, spun = pose(model)
    places, turns = plain
    heading = turns[0, 0] @ spun["pelvis"][0].T
    assert heading[1, 1] == pytest.approx(1.0, abs=1e-9)  # about the vertical alone
    at = {name: n for n, name in enumerate(JOINTS)}
    for side in ("left", "right"):
        for start, end in (("hip", "knee"), ("knee", "ankle"), ("shoulder", "elbow"), ("elbow", "wrist")):
            found = places[:, at[f"{side}_{end}"]] - places[:, at[f"{side}_{start}"]]
            way = (wanted[f"{side} {end}"] - wanted[f"{side} {start}"]) @ heading.T
            cosine = (found * way).sum(axis=1) / np.linalg.norm(found, axis=1) / np.linalg.norm(way, axis=1)
            assert np.degrees(np.arccos(np.clip(cosine, -1, 1))).max() < 0.01, (side, start)
    for name, role in zip(("pelvis", "spine1", "spine3", "neck", "head"), TRUNK, strict=True):
        assert degrees_between(turns[:, at[name]], heading @ spun[role]).max() < 0.01, name
    legs = [np.linalg.norm(places[0, at[f"left_{a}"]] - places[0, at[f"left_{b}"]]) for a, b in
            (("hip", "knee"), ("knee", "ankle"))]  # fmt: skip
    way = (wanted["pelvis"] - wanted["pelvis"][0]) @ heading.T * sum(legs) / 83.0
    np.testing.assert_allclose(places[:, 0] - places[0, 0], way, atol=2e-3)  # both legs of our body are 1 mm off


@pytest.mark.parametrize("scheme", SCHEMES)
def test_any_names_are_one_motion(scheme, plain, tmp_path):
    """Broken where a program's names are not understood, or are taken for another joint or side."""
    check_same(write_bvh(make_reference(), names_of(scheme)), plain, tmp_path)


@pytest.mark.parametrize("spelling", SPELLINGS)
def test_any_spelling_is_one_motion(spelling, plain, tmp_path):
    """Broken where blanks, case, decimals, ends, the number of rows or six channels change a motion or are refused."""
    how = SPELLINGS[spelling]
    recording = check_same(write_bvh(make_reference(), names_of("plain"), how), plain, tmp_path)
    assert any("frames and holds" in note for note in recording.notes) == bool(how.frames)


@pytest.mark.parametrize("root", ROOTS)
@pytest.mark.parametrize("scheme", ["plain", "unreal", "rigify", "letters"])
def test_a_root_above_the_hips_is_one_motion(root, scheme, plain, tmp_path):
    """Broken where the pelvis is taken for the first joint, or the place of a joint below it is dropped."""
    model, names = add_root(make_reference(), names_of(scheme), root)
    how = Spelling(places="added") if root == "added" else Spelling()
    check_same(write_bvh(model, names, how), plain, tmp_path)


@pytest.mark.parametrize("extra", EXTRAS)
@pytest.mark.parametrize("scheme", ["plain", "genesis", "unreal", "rigify", "iclone"])
def test_further_joints_are_one_motion(extra, scheme, plain, tmp_path):
    """Broken where twist bones, long spines, second necks, fingers or handles move other joints."""
    model, names = add_extras(make_reference(), names_of(scheme), extra)
    check_same(write_bvh(model, names), plain, tmp_path)


@pytest.mark.parametrize("lacking", LACKING)
@pytest.mark.parametrize("scheme", ["plain", "genesis", "unreal", "rigify", "iclone", "kinect"])
def test_a_skeleton_may_lack_joints(lacking, scheme, tmp_path):
    """Broken where a missing collar makes the upper arm one, or a short spine or neck is taken for something else."""
    model, names = make_reference(), names_of(scheme)
    gone = [role for role in model if role.endswith(LACKING[lacking])]
    for role in gone:
        model[role] = replace(model[role], turns=still())
    _, *whole = read(write_bvh(model, names), tmp_path)
    for role in gone:
        model = drop(model, role)
    check_same(write_bvh(model, names), whole, tmp_path)


@pytest.mark.parametrize("seed", range(40))
def test_variants_compose(seed, plain, tmp_path):
    """Broken where what is right alone is wrong together: names, roots, units, axes, twists and spelling."""
    random = np.random.default_rng(seed)
    named = [scheme for scheme in SCHEMES if scheme not in ("letters", "limbs alone")]
    scheme, root, extra, spelling, unit = (
        str(random.choice(list(each))) for each in (named, ROOTS[:-1], EXTRAS, SPELLINGS, UNITS)
    )
    model, names = add_extras(make_reference(), names_of(scheme), extra)
    model, names = add_root(model, names, root)
    axes = [np.eye(3), TO_Z_UP][int(random.integers(2))]
    if not root.startswith("tilted"):
        model = turn_axes(model, axes)
    content = write_bvh(turn_axes(model, np.eye(3), UNITS[unit]), names, SPELLINGS[spelling])
    recording = check_same(content, plain, tmp_path)
    up = "+z" if axes is TO_Z_UP and not root.startswith("tilted") else "+y"
    assert any(note.startswith(f"Up is {up} of the file") for note in recording.notes)
