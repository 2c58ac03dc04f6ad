"""Make small models of MHR's and SOMA's formats: the template with its arms down, with these rigs' joints."""

from __future__ import annotations

from functools import cache

import numpy as np
from garmentq.core.body.body import JOINTS
from garmentq.core.body.builtin import named_pose, pose_template
from garmentq.core.body.template import load_template
from scipy.sparse import csc_matrix
from scipy.spatial.transform import Rotation

FINGERS = ("Thumb", "Index", "Middle", "Ring", "Pinky")


def _soma_rig() -> dict[str, tuple[str, str]]:
    """Return SOMA's joints, each with its parent and the joint of ours that it counts for."""
    rig = {
        "Root": ("", "pelvis"),
        "Hips": ("Root", "pelvis"),
        "Spine1": ("Hips", "spine1"),
        "Spine2": ("Spine1", "spine2"),
        "Chest": ("Spine2", "spine3"),
        "Neck1": ("Chest", "neck"),
        "Neck2": ("Neck1", "neck"),
        "Head": ("Neck2", "head"),
        "HeadEnd": ("Head", "head"),
        "Jaw": ("Head", "head"),
        "LeftEye": ("Head", "head"),
        "RightEye": ("Head", "head"),
    }
    for side, ours in (("Left", "left"), ("Right", "right")):
        rig |= {
            f"{side}Shoulder": ("Chest", f"{ours}_collar"),
            f"{side}Arm": (f"{side}Shoulder", f"{ours}_shoulder"),
            f"{side}ForeArm": (f"{side}Arm", f"{ours}_elbow"),
            f"{side}Hand": (f"{side}ForeArm", f"{ours}_wrist"),
            f"{side}ForeArmTwist1": (f"{side}ForeArm", f"{ours}_elbow"),
            f"{side}ArmTwist1": (f"{side}Arm", f"{ours}_shoulder"),
            f"{side}Leg": ("Hips", f"{ours}_hip"),
            f"{side}Shin": (f"{side}Leg", f"{ours}_knee"),
            f"{side}Foot": (f"{side}Shin", f"{ours}_ankle"),
            f"{side}ToeBase": (f"{side}Foot", f"{ours}_foot"),
            f"{side}ToeEnd": (f"{side}ToeBase", f"{ours}_foot"),
            f"{side}LegTwist1": (f"{side}Leg", f"{ours}_hip"),
        }
        for finger in FINGERS:
            first = f"{side}Hand{finger}1"
            rig |= {first: (f"{side}Hand", f"{ours}_hand"), f"{side}Hand{finger}2": (first, f"{ours}_hand")}
    return rig


def _mhr_rig() -> dict[str, tuple[str, str]]:
    """Return MHR's joints, each with its parent and the joint of ours that it counts for."""
    rig = {
        "body_world": ("", "pelvis"),
        "root": ("body_world", "pelvis"),
        "c_spine0": ("root", "pelvis"),
        "c_spine1": ("c_spine0", "spine1"),
        "c_spine2": ("c_spine1", "spine2"),
        "c_spine3": ("c_spine2", "spine3"),
        "c_neck": ("c_spine3", "neck"),
        "c_head": ("c_neck", "head"),
        "c_jaw": ("c_head", "head"),
        "l_eye": ("c_head", "head"),
        "r_eye": ("c_head", "head"),
    }
    for side, ours in (("l", "left"), ("r", "right")):
        rig |= {
            f"{side}_upleg": ("root", f"{ours}_hip"),
            f"{side}_upleg_twist1": (f"{side}_upleg", f"{ours}_hip"),
            f"{side}_lowleg": (f"{side}_upleg", f"{ours}_knee"),
            f"{side}_foot": (f"{side}_lowleg", f"{ours}_ankle"),
            f"{side}_talocrural": (f"{side}_foot", f"{ours}_ankle"),
            f"{side}_subtalar": (f"{side}_talocrural", f"{ours}_ankle"),
            f"{side}_ball": (f"{side}_subtalar", f"{ours}_foot"),
            f"{side}_clavicle": ("c_spine3", f"{ours}_collar"),
            f"{side}_uparm": (f"{side}_clavicle", f"{ours}_shoulder"),
            f"{side}_uparm_twist1": (f"{side}_uparm", f"{ours}_shoulder"),
            f"{side}_lowarm": (f"{side}_uparm", f"{ours}_elbow"),
            f"{side}_wrist": (f"{side}_lowarm", f"{ours}_wrist"),
        }
        for finger in FINGERS:
            first = f"{side}_{finger.lower()}1"
            rig |= {first: (f"{side}_wrist", f"{ours}_hand"), f"{side}_{finger.lower()}2": (first, f"{ours}_hand")}
    return rig


SOMA_RIG, MHR_RIG = _soma_rig(), _mhr_rig()
SOMA_NAMES, MHR_NAMES = list(SOMA_RIG), list(MHR_RIG)
MAIN = {"Hips", "root", "Neck1"}
"""Joints that are at the place of ours though another of the same comes before or after them."""


@cache
def stand() -> tuple[np.ndarray, np.ndarray]:
    """Return vertices and joints [m] of the template with its arms down."""
    template = load_template()
    body = pose_template(template, np.zeros(template.shape_count), named_pose("A"), "")
    return body.vertices, body.joints


def _places(rig: dict[str, tuple[str, str]]) -> np.ndarray:
    """Return the joints' places [m]: the first one of a group at ours, the others a little beside it."""
    rng, seen = np.random.default_rng(8), set()
    places = []
    for name, (_, ours) in rig.items():
        is_first = name in MAIN or (ours not in seen and name not in ("Root", "body_world"))
        is_first = is_first and not ours.endswith("_hand")
        seen |= {ours} if is_first else set()
        places.append(stand()[1][JOINTS.index(ours)] + (0.0 if is_first else rng.normal(0.0, 0.006, 3)))
    return np.array(places)


def _weights(rig: dict[str, tuple[str, str]]) -> np.ndarray:
    """Return the template's weights, each joint's divided among those of the rig that count for it."""
    rng, own = np.random.default_rng(9), load_template().weights
    found = np.zeros((len(own), len(rig)))
    owner = np.array([JOINTS.index(ours) for _, ours in rig.values()])
    for joint in range(24):
        group = np.flatnonzero(owner == joint)
        found[:, group] = own[:, [joint]] * rng.dirichlet(np.ones(len(group)), len(own))
    return found


def make_soma() -> dict[str, np.ndarray]:
    """Return the arrays of `SOMA_neutral.npz` that are read, of a made-up model, with two shape directions."""
    rng, names = np.random.default_rng(10), SOMA_NAMES
    vertices, weights = 100.0 * stand()[0], csc_matrix(_weights(SOMA_RIG))
    world = np.tile(np.eye(4), (len(names), 1, 1))
    world[:, :3, :3] = Rotation.random(len(names), random_state=1).as_matrix()
    world[:, :3, 3] = 100.0 * _places(SOMA_RIG)
    return {
        "bind_shape": vertices, "triangles": load_template().faces.astype(np.int32), "joint_names": np.array(names),
        "joint_parent_ids": np.array([names.index(parent) if parent else 0 for parent, _ in SOMA_RIG.values()]),
        "bind_pose_world": world, "skinning_weights_data": weights.data, "skinning_weights_indices": weights.indices,
        "skinning_weights_indptr": weights.indptr, "skinning_weights_shape": np.array(weights.shape),
        "mean": vertices, "shapedirs": rng.normal(0.0, 0.01, (2, vertices.size)), "eigenvalues": np.array([9.0, 4.0]),
    }  # fmt: skip


def make_mhr() -> dict[str, np.ndarray]:
    """Return the arrays of MHR that are read, of a made-up model, with three shape vectors."""
    rng, names = np.random.default_rng(11), MHR_NAMES
    vertices, weights = 100.0 * stand()[0], _weights(MHR_RIG)
    parents = np.array([names.index(parent) if parent else -1 for parent, _ in MHR_RIG.values()])
    turns, places = Rotation.random(len(names), random_state=2), 100.0 * _places(MHR_RIG)
    inverse, above = turns.inv(), turns[np.maximum(parents, 0)].inv()
    offsets = above.apply(places - places[np.maximum(parents, 0)])
    offsets[0], prerotations = places[0], (above * turns).as_quat()
    prerotations[0] = turns[0].as_quat()
    parameters = np.zeros((7 * len(names), 204))
    parameters[rng.choice(7 * len(names), 136), np.arange(136)] = 1.0
    parameters[6::7] = 0.0
    parameters[6 + 7 * np.arange(2, len(names)), 136 + np.arange(len(names) - 2)] = 1.0
    rows, columns = np.nonzero(weights)
    binds = np.column_stack([-inverse.apply(places), inverse.as_quat(), np.ones(len(names))])
    return {
        "base_shape": vertices, "shape_vectors": rng.normal(0.0, 0.1, (3, *vertices.shape)),
        "faces": load_template().faces, "joint_names": np.array(names), "joint_parents": parents,
        "inverse_bind_pose": binds, "vert_indices_flattened": rows, "skin_indices_flattened": columns,
        "skin_weights_flattened": weights[rows, columns], "joint_translation_offsets": offsets,
        "joint_prerotations": prerotations, "parameter_transform": parameters,
    }  # fmt: skip
