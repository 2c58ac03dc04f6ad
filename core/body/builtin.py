"""The built-in body from a short description such as `builtin:female,height=1.70,weight=62,pose=A`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..run.errors import BadInput
from .body import JOINTS, Body
from .girths import GIRTHS
from .measured import BODY_DENSITY, TargetMeasures, most_probable_shape, volume_of
from .skinning import skin
from .spec import BUILTIN, BuiltinWearer, is_builtin
from .template import Template, articulate, load_template, rotations_of, transforms_of

__all__ = ["BodyMissing", "BodySpecBad", "builtin_body"]

BUILTIN_HEIGHT_RANGE = (1.40, 2.10)
"""Heights [m] of the bodies from which the shape directions were made; outside this range bodies look wrong."""
USUAL_HEIGHTS = {"female": 1.65, "male": 1.77}
"""Default height [m]: about the mean of young adults in Europe."""
MASS_INDICES = (16.0, 40.0)
"""Range of weight over height squared [kg/m2], for the same reason."""

ARM_DROPS = {"T": 0.0, "A": math.radians(45), "arms-down": math.radians(70)}
"""Angle [rad] of each arm below the horizontal; at more than 70 degrees the hands would touch broad hips."""


POSES = ("T", "A", "arms-down", "stride", "seated")
"""Names of the poses of the built-in body."""


class BodyMissing(BadInput):
    """No body was given: give --body body.ply or builtin:female,height=1.70, or mark cloth and skin by --labels."""

    code = "body.missing"


class BodySpecBad(BadInput):
    """Write builtin:female|male[,height=1.70][,weight=62][,waist=0.72][,pose=A]; see docs/concepts/wearer.md."""

    code = "body.spec_bad"


def builtin_body(spec: str | BuiltinWearer) -> Body:
    """Make the built-in body of a description.

    The shape is the most probable one of that gender with the height, weight and girths given. The feet stand at y = 0
    below the pelvis at x = z = 0, facing +z.

    Args:
        spec: `builtin:female` or `builtin:male`; any of `height` [m], `weight` [kg], `GIRTHS` [m], `pose` of `POSES`.

    Raises:
        BodyMissing: where the description is empty.
        BodySpecBad: where it cannot be read or describes a body outside the model's range.
        MeasureRange: where a girth is outside its range.
    """
    parsed = parse_spec(str(spec))
    template = load_template()
    shape = most_probable_shape(template, parsed.measures)
    return pose_template(template, shape, named_pose(parsed.pose), f"{BUILTIN}{parsed.measures.gender}")


def pose_template(
    template: Template, shape: np.ndarray, angles: np.ndarray, source: str, down: np.ndarray | None = None
) -> Body:
    """Return the built-in body of a shape in a pose.

    Args:
        template: The model.
        shape: Its shape coefficients, shape [shape_count].
        angles: Axis-angle vectors of the joints [rad], shape [24, 3].
        source: The body's `source`.
        down: Translation [m], shape [3]; None: the feet of the rest pose stand at y = 0.
    """
    rest, joints = template.shaped(shape)
    floor = np.array([0.0, rest[:, 1].min(), 0.0])
    rest, joints = rest - floor, joints - floor
    world, posed = articulate(rotations_of(angles), joints, np.zeros(3))
    transforms = transforms_of(world, posed, joints)
    down = np.zeros(3) if down is None else down
    transforms[:, :3, 3] += down
    return Body(
        vertices=skin(rest, template.weights, transforms),
        faces=template.faces,
        joints=posed + down,
        weights=template.weights,
        transforms=transforms,
        rest_vertices=rest,
        rest_faces=template.faces,
        rest_joints=joints,
        rest_weights=template.weights,
        heading=np.eye(3),
        parameters={"shape": shape, "pose": angles, "translation": down},
        source=source,
    )


def describe_bodies() -> tuple[dict[str, Any], ...]:
    """Return what the built-in bodies offer: `spec`, `poses`, and `ranges` of height [m] and weight [kg]. A range is
    (lowest, highest, usual); the weights are those at the usual height."""
    template = load_template()
    bodies = []
    for gender, height in USUAL_HEIGHTS.items():
        vertices, _ = template.shaped(most_probable_shape(template, TargetMeasures(gender, height)))
        usual = BODY_DENSITY * volume_of(vertices, template.faces)[0]
        low, high = (round(index * height**2) for index in MASS_INDICES)
        ranges = ((*BUILTIN_HEIGHT_RANGE, height), (low, high, round(usual)))
        bodies.append({"spec": f"{BUILTIN}{gender}", "ranges": ranges, "poses": POSES})
    return tuple(bodies)


@dataclass(frozen=True)
class BodySpec:
    """Describe the body that a description specifies: gender and measures, and one of `POSES`."""

    measures: TargetMeasures
    pose: str = "T"


def parse_spec(spec: str) -> BodySpec:
    """Parse the description of a built-in body.

    Raises:
        BodyMissing: where it is empty.
        BodySpecBad: where it cannot be read.
    """
    if not spec.strip():
        raise BodyMissing()
    words = [word.strip() for word in spec.strip().removeprefix(BUILTIN).split(",")]
    if not is_builtin(spec.strip()) or words[0] not in ("female", "male"):
        raise BodySpecBad(f"'{spec}' is not a built-in body. {BodySpecBad().message}")
    numbers: dict[str, float] = {}
    pose = "T"
    for word in words[1:]:
        key, _, value = word.partition("=")
        if key == "pose" and value in POSES:
            pose = value
        elif key in ("height", "weight", *GIRTHS) and key not in numbers:
            numbers[key] = _number(spec, key, value)
        else:
            raise BodySpecBad(f"'{word}' in '{spec}' is not understood. {BodySpecBad().message}")
    height, weight = numbers.pop("height", USUAL_HEIGHTS[words[0]]), numbers.pop("weight", None)
    if not BUILTIN_HEIGHT_RANGE[0] <= height <= BUILTIN_HEIGHT_RANGE[1]:
        raise BodySpecBad(
            f"height={height:g} is outside {BUILTIN_HEIGHT_RANGE[0]:.2f} to {BUILTIN_HEIGHT_RANGE[1]:.2f} m "
            "(height is in metres)."
        )
    low, high = (index * height**2 for index in MASS_INDICES)
    if weight is not None and not low <= weight <= high:
        raise BodySpecBad(f"weight={weight:g} is outside {low:.0f} to {high:.0f} kg for a height of {height:.2f} m.")
    girths = {name: numbers[name] for name in GIRTHS if name in numbers}
    return BodySpec(TargetMeasures(words[0], height, weight, girths), pose)


def named_pose(name: str) -> np.ndarray:
    """Return axis-angles [24, 3] of one of `POSES`; a negative angle about x swings a hanging limb forwards. `stride`:
    left leg 20 degrees ahead, right leg 15 behind, knee bent; arms at 60 degrees, swung against the legs. `seated`:
    thighs 5 degrees from level, shins upright, arms at 60 degrees and 20 forwards. The pelvis is fixed."""
    if name in ARM_DROPS:
        return arm_pose(ARM_DROPS[name])
    angles = arm_pose(math.radians(60))
    if name == "stride":
        turns = {"left_hip": -20, "left_knee": 5, "right_hip": 15, "right_knee": 20}
        swing = {"left": 15, "right": -15}
    else:
        turns = {f"{side}_{joint}": turn for side in ("left", "right") for joint, turn in (("hip", -85), ("knee", 85))}
        swing = {"left": -20, "right": -20}
    for joint, degrees in turns.items():
        angles[JOINTS.index(joint), 0] = math.radians(degrees)
    for side, degrees in swing.items():
        # The collar is level in every pose, so a turn of it about x swings the arm.
        angles[JOINTS.index(f"{side}_collar"), 0] = math.radians(degrees)
    return angles


def arm_pose(drop: float) -> np.ndarray:
    """Return axis-angles [24, 3] of a body whose arms hang `drop` [rad] below the horizontal. The collar turns by an
    eighth of the angle, as a shoulder girdle does for small angles."""
    angles = np.zeros((24, 3))
    for side, sign in (("left", -1.0), ("right", 1.0)):
        angles[JOINTS.index(f"{side}_collar"), 2] = sign * drop / 8
        angles[JOINTS.index(f"{side}_shoulder"), 2] = sign * drop * 7 / 8
    return angles


def _number(spec: str, key: str, value: str) -> float:
    try:
        number = float(value)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise BodySpecBad(f"{key}='{value}' in '{spec}' is not a number. {BodySpecBad().message}")
    return number
