"""The built-in body from a short description such as `builtin:female,height=1.70,weight=62,pose=A`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..errors import BadInput
from .body import JOINTS, Body
from .skinning import skin
from .spec import BUILTIN, is_builtin
from .template import Template, articulate, load_template, rotations_of, transforms_of

DENSITY = 985.0
"""Mean density of a living body with air in its lungs [kg/m3]; turns the mesh's volume into the weight asked for.
Assumed: bodies lie between about 0.94 (lungs full) and 1.06 (lungs empty, lean) times water's."""

HEIGHTS = (1.40, 2.10)
"""Heights [m] that the shape directions were drawn for; beyond them bodies look wrong."""
USUAL_HEIGHTS = {"female": 1.65, "male": 1.77}
"""Height [m] where none is asked for: about the mean of young adults in Europe."""
MASS_INDICES = (16.0, 40.0)
"""Range of weight over height squared [kg/m2] for the same reason."""

ARM_DROPS = {"T": 0.0, "A": math.radians(45), "arms-down": math.radians(70)}
"""Angle [rad] by which each arm hangs below the horizontal; 70 degrees is as low as hands clear broad hips."""


POSES = ("T", "A", "arms-down", "stride", "seated")
"""Every pose that the built-in body can be asked for by name."""


class BodyMissing(BadInput):
    """No body was given: give --body body.ply or builtin:female,height=1.70, or tell cloth from skin by --labels."""

    code = "body.missing"


class BodySpecBad(BadInput):
    """The built-in body is builtin:female|male[,height=1.70][,weight=62][,pose=T|A|arms-down|stride|seated]."""

    code = "body.spec_bad"


def builtin_body(spec: str) -> Body:
    """Make the built-in body that a description asks for.

    The shape is the most probable one of that gender with the height (and weight) given. The feet stand at y = 0 below
    the pelvis at x = z = 0, facing +z.

    Args:
        spec: `builtin:female` or `builtin:male`, then any of `height` [m], `weight` [kg], `pose` (one of `POSES`).

    Raises:
        BodyMissing: where the description is empty.
        BodySpecBad: where it cannot be read or asks for a body outside the model's range.
    """
    gender, height, weight, pose = parse_spec(spec)
    template = load_template()
    shape = shape_for(template, gender, height, weight)
    return pose_template(template, shape, named_pose(pose), f"{BUILTIN}{gender}")


def pose_template(
    template: Template, shape: np.ndarray, angles: np.ndarray, source: str, down: np.ndarray | None = None
) -> Body:
    """Return the built-in body of a shape in a pose.

    Args:
        template: The model.
        shape: Its shape coefficients, shape [shape_count].
        angles: Axis-angle vectors of the joints [rad], shape [24, 3].
        source: Where the body is from.
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
    """Tell what can be asked of the built-in bodies: `spec`, `poses`, and `ranges` of height [m] and weight [kg].

    A range is (lowest, highest, usual); the weights are those at the usual height.
    """
    template = load_template()
    bodies = []
    for gender, height in USUAL_HEIGHTS.items():
        vertices, _ = template.shaped(shape_for(template, gender, height, None))
        usual = DENSITY * _volume(vertices, template.faces)[0]
        low, high = (round(index * height**2) for index in MASS_INDICES)
        ranges = ((*HEIGHTS, height), (low, high, round(usual)))
        bodies.append({"spec": f"{BUILTIN}{gender}", "ranges": ranges, "poses": POSES})
    return tuple(bodies)


def parse_spec(spec: str) -> tuple[str, float, float | None, str]:
    """Read gender, height [m], weight [kg] and pose out of a description.

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
        elif key in ("height", "weight") and key not in numbers:
            numbers[key] = _number(spec, key, value)
        else:
            raise BodySpecBad(f"'{word}' in '{spec}' is not understood. {BodySpecBad().message}")
    height, weight = numbers.get("height", USUAL_HEIGHTS[words[0]]), numbers.get("weight")
    if not HEIGHTS[0] <= height <= HEIGHTS[1]:
        raise BodySpecBad(f"height={height:g} is outside {HEIGHTS[0]:.2f} to {HEIGHTS[1]:.2f} m (height is in metres).")
    low, high = (index * height**2 for index in MASS_INDICES)
    if weight is not None and not low <= weight <= high:
        raise BodySpecBad(f"weight={weight:g} is outside {low:.0f} to {high:.0f} kg for a height of {height:.2f} m.")
    return words[0], height, weight, pose


def shape_for(template: Template, gender: str, height: float, weight: float | None) -> np.ndarray:
    """Give the most probable shape coefficients [k] of a gender with a height [m] and a weight [kg].

    With z ~ N(mean, C) and the constraints c(z) = (height, volume), minimise (z - mean)' C^-1 (z - mean) subject to
    c(z) = target: each Newton step on the linearised constraints is z = mean + C A' (A C A')^-1 (t - c(z) + A (z -
    mean)), with A the derivative of c. The volume is cubic and the height piecewise linear in z, so a few steps do.
    """
    mean, covariance = template.means[gender], template.covariances[gender]
    shape = mean.copy()
    for _ in range(8):
        vertices, _ = template.shaped(shape)
        top, bottom = vertices[:, 1].argmax(), vertices[:, 1].argmin()
        values = [vertices[top, 1] - vertices[bottom, 1]]
        slopes = [template.directions[:, top, 1] - template.directions[:, bottom, 1]]
        targets = [height]
        if weight is not None:
            volume, slope = _volume(vertices, template.faces)
            values.append(volume)
            slopes.append(np.tensordot(template.directions, slope, axes=2))
            targets.append(weight / DENSITY)
        a = np.array(slopes)
        gap = np.array(targets) - np.array(values) + a @ (shape - mean)
        shape = mean + covariance @ a.T @ np.linalg.solve(a @ covariance @ a.T, gap)
    return shape


def named_pose(name: str) -> np.ndarray:
    """Give axis-angles [24, 3] of one of `POSES`; negative about x swings a hanging limb forwards.

    `stride`: the left leg 20 degrees ahead and the right 15 behind with its knee bent, as in a walk's double support;
    arms at 60 degrees swing against the legs. `seated`: thighs level but for 5 degrees and shins upright, as on a
    chair, the arms at 60 degrees and 20 forwards. The pelvis stays where it is.
    """
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
        # The collar lies level in every pose, so its turn about x swings the arm that hangs from it.
        angles[JOINTS.index(f"{side}_collar"), 0] = math.radians(degrees)
    return angles


def arm_pose(drop: float) -> np.ndarray:
    """Give axis-angles [24, 3] of a body whose arms hang `drop` [rad] below the horizontal.

    The collar takes an eighth of the way, as a shoulder girdle does for small angles.
    """
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


def _volume(vertices: np.ndarray, faces: np.ndarray) -> tuple[float, np.ndarray]:
    """Give the enclosed volume [m3] and its derivative by the vertices [n, 3]."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    slope = np.zeros_like(vertices)
    for k, opposite in enumerate((np.cross(b, c), np.cross(c, a), np.cross(a, b))):
        np.add.at(slope, faces[:, k], opposite / 6)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6), slope
