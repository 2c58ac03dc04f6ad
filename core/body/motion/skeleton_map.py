"""Map a foreign skeleton to ours: its joints, its axes, the length of its legs."""

from __future__ import annotations

import numpy as np

from ...geometry.geometry import unit
from ..body import JOINTS
from .errors import MotionForeign
from .joint_names import JointMapping, find_joints
from .joint_tree import JointTree
from .posed import SkeletonMotion
from .recording import Recording
from .retarget import BONE_END_JOINTS, shortest_rotation
from .unused_joints import describe_unused_joints
from .up_direction import SampledPoses, find_up

MIN_UPRIGHT_COSINE = 0.7
"""Smallest cosine between trunk and legs of a standing pose: 45 degrees."""

AXIS_SNAP_COSINE = 0.94
"""Cosine to a file's axis above which a skeleton's up and side snap to it: 20 degrees, the lean of a rest pose."""

UNITS = {"metres": 1.0, "decimetres": 10.0, "inches": 100.0 / 2.54, "centimetres": 100.0, "millimetres": 1000.0}
"""Units of files, and how many of each make a metre."""

LEG_LENGTH_RANGE = (0.62, 1.1)
"""Length from hip to ankle of adults of 1.4 to 2.2 m [m]: a range narrower than the ratio of the units in use."""

UP_SAMPLE_COUNT = 200
"""Number of poses, spread over a motion, from which the up direction is found."""


def map_skeleton(posed: SkeletonMotion, rate: float) -> Recording:
    """Return the recording of a foreign skeleton.

    The rest pose is that of the offsets, rotated like the joints above the pelvis where these do not turn; if it is not
    a standing pose (joints with rotated axes), the first standing pose replaces it. The left side is from the right hip
    to the left one; up is found from rest pose and motion (`find_up`).

    Raises:
        MotionForeign: where hips and knees are not found, or no pose stands upright.
    """
    plain = np.tile(np.eye(3), (len(posed.names), 1, 1))
    found = find_joints(JointTree(posed.names, posed.parents, posed.places(plain)), posed.fixed_joints())
    missing = [name for name in ("left_hip", "right_hip", "left_knee", "right_knee") if name not in found.at]
    if missing or "pelvis" not in found.at:
        lacking = ", ".join(missing) or "joint that both legs branch from"
        raise MotionForeign(f"no {lacking} among '{', '.join(posed.names[:12])}'. {MotionForeign().message}")
    pelvis = found.at["pelvis"]
    above = posed.turn_above(pelvis)
    poses = _spread_pose_indices(posed)
    for rest in (plain if above is None else np.tile(above, (len(posed.names), 1, 1)), *posed.turns[poses]):
        places = _places(posed, found, rest)
        if _is_upright(places):
            break
    else:
        raise MotionForeign(f"neither the rest pose nor any pose stands upright. {MotionForeign().message}")
    leg = _leg_length(places)
    if not leg > 0:
        raise MotionForeign(f"the legs have no length. {MotionForeign().message}")
    axes, path = _axes(places), posed.position(pelvis)
    up = find_up(axes[1], _sample(posed, found, path / leg))
    world = axes @ shortest_rotation(up.direction, axes[1])
    known = np.array([name in found.at for name in JOINTS])
    turns = np.tile(np.eye(3), (len(path), 24, 1, 1))
    for joint, name in enumerate(JOINTS):
        if name in found.at:
            carried = found.carried[name]
            turns[:, joint] = world @ posed.turns[:, carried] @ rest[carried].T @ axes.T
    notes = (
        *_describe_names(found, posed),
        *found.notes,
        up.note,
        _describe_unit(leg),
        *describe_unused_joints(posed, found),
    )
    return Recording(rate, turns, known, _bones(places, axes), path @ world.T / leg, notes=notes)


def _sample(posed: SkeletonMotion, found: JointMapping, pelvis: np.ndarray) -> SampledPoses:
    """Sample the person's posture over the motion; `pelvis` is the pelvis' place in leg lengths, [n, 3]."""
    uprights, joints = [], []
    for pose in _spread_pose_indices(posed):
        places = _places(posed, found, posed.turns[pose])
        uprights.append(unit(_trunk(places) + _up_of_legs(places)))
        joints.append((np.array(list(places.values())) - places["pelvis"]) / _leg_length(places) + pelvis[pose])
    return SampledPoses(np.array(uprights), np.array(joints))


def _spread_pose_indices(posed: SkeletonMotion) -> np.ndarray:
    """Return the indices of poses spread over a motion, beginning with the first."""
    return np.unique(np.linspace(0, len(posed.turns) - 1, UP_SAMPLE_COUNT).astype(np.int64))


def _places(posed: SkeletonMotion, found: JointMapping, turns: np.ndarray) -> dict[str, np.ndarray]:
    """Return our joints in one pose, by name; `turns` are its world rotations, [joint_count, 3, 3]."""
    places = posed.places(turns)
    return {name: places[index] for name, index in found.at.items()}


def _leg_length(places: dict[str, np.ndarray]) -> float:
    """Return the length of thigh and shin, the mean of both sides, in the file's unit."""
    legs = [
        np.linalg.norm(places[f"{side}_{end}"] - places[f"{side}_{start}"])
        for side in ("left", "right")
        for start, end in (("hip", "knee"), ("knee", "ankle"))
        if f"{side}_{end}" in places
    ]
    return float(np.mean(legs)) * 2.0


def _is_upright(places: dict[str, np.ndarray]) -> bool:
    """Check whether the legs hang below the trunk."""
    trunk, leg = _trunk(places), _up_of_legs(places)
    return bool(trunk @ leg > MIN_UPRIGHT_COSINE and np.linalg.norm(_side(places)) > 0)


def _trunk(places: dict[str, np.ndarray]) -> np.ndarray:
    hips = 0.5 * (places["left_hip"] + places["right_hip"])
    top = [places[name] for name in ("left_shoulder", "right_shoulder") if name in places] or [
        places[name] for name in ("head", "neck", "spine3") if name in places
    ]
    return unit(np.mean(top, axis=0) - hips) if top else _up_of_legs(places)


def _up_of_legs(places: dict[str, np.ndarray]) -> np.ndarray:
    ways = [places[f"{side}_hip"] - places[f"{side}_knee"] for side in ("left", "right")]
    return unit(np.sum([unit(direction) for direction in ways], axis=0))


def _side(places: dict[str, np.ndarray]) -> np.ndarray:
    across = places["left_hip"] - places["right_hip"]
    if "left_shoulder" in places and "right_shoulder" in places:
        across = across + places["left_shoulder"] - places["right_shoulder"]
    return np.asarray(across)


def _axes(places: dict[str, np.ndarray]) -> np.ndarray:
    """Return the rotation [3, 3] from the file's axes to ours: left along x, up along y."""
    up = _snap_to_axis(unit(_trunk(places) + _up_of_legs(places)))
    side = _side(places)
    side = _snap_to_axis(unit(side - (side @ up) * up))
    side = unit(side - (side @ up) * up)
    return np.stack([side, up, np.cross(side, up)])


def _snap_to_axis(direction: np.ndarray) -> np.ndarray:
    axis = int(np.abs(direction).argmax())
    if abs(direction[axis]) < AXIS_SNAP_COSINE:
        return direction
    return np.asarray(np.eye(3)[axis] * np.sign(direction[axis]))


def _bones(places: dict[str, np.ndarray], axes: np.ndarray) -> np.ndarray:
    """Return the directions of the limbs' bones in our axes, shape [24, 3]."""
    bones = np.zeros((24, 3))
    for joint, name in enumerate(JOINTS):
        side, _, part = name.partition("_")
        end = f"{side}_{BONE_END_JOINTS[part]}" if part in BONE_END_JOINTS else ""
        if name in places and end in places:
            bones[joint] = axes @ unit(places[end] - places[name])
    return bones


def _describe_names(found: JointMapping, posed: SkeletonMotion) -> tuple[str, ...]:
    """Describe which joints were matched to ours under other names, and what is above the pelvis."""
    called = {name: posed.names[index] for name, index in found.at.items()}
    foreign = [f"{name} is {other}" for name, other in called.items() if other.lower() != name]
    notes = [f"Joints by other names: {', '.join(foreign)}."] if foreign else []
    above = posed.parents[found.at["pelvis"]]
    if above >= 0:
        notes.append(f"The pelvis is {called['pelvis']}, and goes and turns with {posed.names[above]}.")
    return tuple(notes)


def _describe_unit(leg: float) -> str:
    """Describe the file's unit as it follows from a leg's length in it; the motion is scaled by the leg in any case."""
    likely = [unit for unit, many in UNITS.items() if LEG_LENGTH_RANGE[0] <= leg / many <= LEG_LENGTH_RANGE[1]]
    taken = f"{likely[0]} by that" if likely else "a unit that is not known"
    return (
        f"A leg of the motion's skeleton is {leg:.3g} long, {taken}; the way of the pelvis is scaled to the wearer's."
    )
