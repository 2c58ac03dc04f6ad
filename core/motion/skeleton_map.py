"""Understand a foreign skeleton: which of its joints are ours, where its front is, how long its legs are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..body import JOINTS
from ..mesh import unit
from .errors import MotionForeign
from .joint_names import find_joints
from .recording import Recording
from .retarget import CHILD

UPRIGHT = 0.7
"""Least cosine between trunk and legs of a pose in which a person stands: 45 degrees."""

SNAP = 0.94
"""Cosine to one of the file's axes above which a skeleton's up and side are that axis: 20 degrees, which a rest pose
may lean."""

UNITS = {"metres": 1.0, "decimetres": 10.0, "inches": 100.0 / 2.54, "centimetres": 100.0, "millimetres": 1000.0}
"""Units of files, and how many of each make a metre."""

LEGS = (0.62, 1.1)
"""Length from hip to ankle of grown persons of 1.4 to 2.2 m [m]; the units that are in use lie further apart."""

LISTED = 8
"""Unknown joints that are named; the others are counted."""


@dataclass(frozen=True)
class Posed:
    """Describe a foreign skeleton in motion, in the file's unit and axes.

    Attributes:
        names: Of its joints.
        parents: Index of each joint's parent, -1 for the root.
        offsets: From the parent in the rest pose, shape [joint_count, 3].
        turns: Rotation of each joint in the world, shape [n, joint_count, 3, 3].
        root: Place of the root, shape [n, 3].
    """

    names: tuple[str, ...]
    parents: tuple[int, ...]
    offsets: np.ndarray
    turns: np.ndarray
    root: np.ndarray

    def places(self, turns: np.ndarray) -> np.ndarray:
        """Return the joints of one pose (rotations in the world, [joint_count, 3, 3]), the root at 0."""
        found = np.zeros_like(self.offsets)
        for joint, parent in enumerate(self.parents):
            if parent >= 0:
                found[joint] = found[parent] + turns[parent] @ self.offsets[joint]
        return found


def map_skeleton(posed: Posed, rate: float) -> Recording:
    """Return the recording of a foreign skeleton.

    The rest pose is that of the offsets; where nobody stands so (joints with turned axes), the first pose. Up goes from
    the feet to the chest and the left side from the right hip to the left one.

    Raises:
        MotionForeign: where hips and knees are not found, or no pose stands upright.
    """
    found = find_joints(posed.names, posed.parents)
    missing = [name for name in ("left_hip", "right_hip", "left_knee", "right_knee") if name not in found]
    if missing:
        raise MotionForeign(f"no {', '.join(missing)} among '{', '.join(posed.names[:12])}'. {MotionForeign().message}")
    plain = np.tile(np.eye(3), (len(posed.names), 1, 1))
    for rest in (plain, posed.turns[0]):
        places = {name: posed.places(rest)[index] for name, index in found.items()}
        if _stands(places):
            break
    else:
        raise MotionForeign(f"neither the rest pose nor the first pose stands upright. {MotionForeign().message}")
    axes = _axes(places)
    known = np.array([name in found for name in JOINTS])
    turns = np.tile(np.eye(3), (len(posed.root), 24, 1, 1))
    for joint, name in enumerate(JOINTS):
        if name in found:
            turns[:, joint] = axes @ posed.turns[:, found[name]] @ rest[found[name]].T @ axes.T
    legs = [
        np.linalg.norm(places[f"{side}_{end}"] - places[f"{side}_{start}"])
        for side in ("left", "right")
        for start, end in (("hip", "knee"), ("knee", "ankle"))
        if f"{side}_{end}" in places
    ]
    leg = float(np.mean(legs)) * 2.0
    if not leg > 0:
        raise MotionForeign(f"the legs have no length. {MotionForeign().message}")
    unused = [name for index, name in enumerate(posed.names) if index not in found.values()]
    notes = (*_tell_names(found, posed.names), _tell_unit(leg), *_tell_unused(unused))
    return Recording(rate, turns, known, _bones(places, axes), posed.root @ axes.T / leg, notes=notes)


def _stands(places: dict[str, np.ndarray]) -> bool:
    """Check whether the legs hang below the trunk."""
    trunk, leg = _trunk(places), _up_of_legs(places)
    return bool(trunk @ leg > UPRIGHT and np.linalg.norm(_side(places)) > 0)


def _trunk(places: dict[str, np.ndarray]) -> np.ndarray:
    hips = 0.5 * (places["left_hip"] + places["right_hip"])
    top = [places[name] for name in ("left_shoulder", "right_shoulder") if name in places] or [
        places[name] for name in ("head", "neck", "spine3") if name in places
    ]
    return unit(np.mean(top, axis=0) - hips) if top else _up_of_legs(places)


def _up_of_legs(places: dict[str, np.ndarray]) -> np.ndarray:
    ways = [places[f"{side}_hip"] - places[f"{side}_knee"] for side in ("left", "right")]
    return unit(np.sum([unit(way) for way in ways], axis=0))


def _side(places: dict[str, np.ndarray]) -> np.ndarray:
    way = places["left_hip"] - places["right_hip"]
    if "left_shoulder" in places and "right_shoulder" in places:
        way = way + places["left_shoulder"] - places["right_shoulder"]
    return np.asarray(way)


def _axes(places: dict[str, np.ndarray]) -> np.ndarray:
    """Return the rotation [3, 3] from the file's axes to ours: left along x, up along y."""
    up = _snapped(unit(_trunk(places) + _up_of_legs(places)))
    side = _side(places)
    side = _snapped(unit(side - (side @ up) * up))
    side = unit(side - (side @ up) * up)
    return np.stack([side, up, np.cross(side, up)])


def _snapped(direction: np.ndarray) -> np.ndarray:
    axis = int(np.abs(direction).argmax())
    if abs(direction[axis]) < SNAP:
        return direction
    return np.asarray(np.eye(3)[axis] * np.sign(direction[axis]))


def _bones(places: dict[str, np.ndarray], axes: np.ndarray) -> np.ndarray:
    """Return the directions of the limbs' bones in our axes, shape [24, 3]."""
    bones = np.zeros((24, 3))
    for joint, name in enumerate(JOINTS):
        side, _, part = name.partition("_")
        end = f"{side}_{CHILD[part]}" if part in CHILD else ""
        if name in places and end in places:
            bones[joint] = axes @ unit(places[end] - places[name])
    return bones


def _tell_names(found: dict[str, int], names: tuple[str, ...]) -> tuple[str, ...]:
    """Describe which joints were taken for ours, where any is called otherwise."""
    foreign = [f"{name} is {names[index]}" for name, index in found.items() if names[index].lower() != name]
    return (f"Joints by other names: {', '.join(foreign)}.",) if foreign else ()


def _tell_unit(leg: float) -> str:
    """Describe what the file's unit seems to be from a leg's length in it, by which the motion is scaled either way."""
    likely = [unit for unit, many in UNITS.items() if LEGS[0] <= leg / many <= LEGS[1]]
    taken = f"{likely[0]} by that" if likely else "a unit that is not known"
    return (
        f"A leg of the motion's skeleton is {leg:.3g} long, {taken}; the way of the pelvis is scaled to the wearer's."
    )


def _tell_unused(unused: list[str]) -> tuple[str, ...]:
    if not unused:
        return ()
    more = f" and {len(unused) - LISTED} more" if len(unused) > LISTED else ""
    return (f"Joints of the motion that were not used: {', '.join(unused[:LISTED])}{more}.",)
