"""Draw wearers: a shape of the built-in body, and poses in which the body does not run into itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from ..core.body.body import JOINTS, Body
from ..core.body.builtin import arm_pose, named_pose, pose_template
from ..core.body.fit import POSE_PRIOR_STDS
from ..core.body.person_search import load_poses
from ..core.body.template import Template
from ..core.geometry.geometry import vertex_normals

JITTER = 0.3
"""Standard deviation of the joints' turns about a named pose as a share of everyday poses' spread: a person who was
asked to take a pose is within a third of what people do."""

TRIES = 12
"""Poses drawn before the arms are left where they are in the A-pose."""

OVERLAP = 0.012
"""Depth [m] of a limb's vertex below another part's skin from which the body runs into itself; armpits of the skinned
model reach 1 cm without touching to the eye."""

POSES = (
    ("A", 0.32), ("T", 0.10), ("arms-down", 0.2), ("stride", 0.1), ("up", 0.06), ("goalpost", 0.06), ("hips", 0.07),
    ("forward", 0.07), ("seated", 0.02),
)  # fmt: skip
"""Start poses and how often each is drawn: what scanning protocols ask for, most often the A-pose."""

MOVING = 0.4
"""Share of scans in a pose out of a motion: captures of people who do something."""

UPRIGHT = 0.85
"""Share of those in which the trunk leans by less than 45 degrees: lying, rolling and falling are rarer."""

LARGE = 0.15
"""Share of persons whose shape is drawn with `LARGE_SPREAD`."""
LARGE_SPREAD = 1.7
"""Times that their shapes spread as much as the built-in ones do: heavy, tall, slight ones."""

CHILD = 0.06
"""Share of persons who are children."""
CHILD_SIZE = (0.6, 0.85)
"""Height of children as a share of an adult's: from four years on."""


def draw_wearer(template: Template, rng: np.random.Generator) -> tuple[str, Template, np.ndarray]:
    """Draw gender (or `child`), the template that the wearer is a shape of, and shape coefficients, shape [k]."""
    gender = str(rng.choice(["female", "male"]))
    spread = LARGE_SPREAD**2 if rng.random() < LARGE else 1.0
    shape = rng.multivariate_normal(template.means[gender], spread * template.covariances[gender], method="eigh")
    if rng.random() < CHILD:
        return "child", shrink(template, float(rng.uniform(*CHILD_SIZE))), shape
    return gender, template, shape


def shrink(template: Template, size: float) -> Template:
    """Return a template of a given share of the height whose head is smaller by the root of that share alone."""
    head = JOINTS.index("head")
    heads = template.joint_directions[:, head]
    grown = (size**-0.5 - 1.0) * template.weights[:, head : head + 1]

    def carry(vertices: np.ndarray, joint: np.ndarray) -> np.ndarray:
        return np.asarray(size * (vertices + grown * (vertices - joint)))

    return replace(
        template,
        vertices=carry(template.vertices, template.joints[head]),
        directions=np.array([carry(*pair) for pair in zip(template.directions, heads, strict=True)]),
        joints=size * template.joints,
        joint_directions=size * template.joint_directions,
    )


def draw_motion_pose(rng: np.random.Generator) -> tuple[str, np.ndarray]:
    """Draw a pose out of a motion, half of them mirrored: its name and axis-angles, shape [24, 3]."""
    angles, clips = load_poses()
    upright = Rotation.from_rotvec(angles[:, 0]).apply([0.0, 1.0, 0.0])[:, 1] > np.cos(np.pi / 4)
    chosen = int(rng.choice(np.flatnonzero(upright == (rng.random() < UPRIGHT))))
    return str(clips[chosen]), mirror_pose(angles[chosen]) if rng.random() < 0.5 else angles[chosen]


def mirror_pose(angles: np.ndarray) -> np.ndarray:
    """Return the pose with left and right exchanged, shape [24, 3]."""
    twin = [
        JOINTS.index(name.replace("left", "right") if "left" in name else name.replace("right", "left"))
        for name in JOINTS
    ]
    return np.asarray(angles[twin] * [1.0, -1.0, -1.0])


def draw_pose(template: Template, shape: np.ndarray, rng: np.random.Generator) -> tuple[str, Body]:
    """Draw a pose and return its name and the body in it; drawn anew where the body runs into itself."""
    names, shares = zip(*POSES, strict=True)
    for _ in range(TRIES):
        if rng.random() < MOVING:
            name, angles = draw_motion_pose(rng)
            body = stand(template, shape, angles)
            if not runs_into_itself(body):
                return name, body
            continue
        name = str(rng.choice(names, p=np.array(shares) / sum(shares)))
        angles = pose_angles(name)
        jitter = rng.normal(0.0, JITTER, (24, 3)) * np.where(np.isfinite(POSE_PRIOR_STDS), POSE_PRIOR_STDS, 0.0)
        heading = np.zeros((24, 3))
        heading[0] = rng.normal(0.0, [0.03, 0.0, 0.03])
        body = stand(template, shape, angles + jitter + heading)
        if not runs_into_itself(body):
            return name, body
    return "A", stand(template, shape, pose_angles("A"))


def pose_angles(name: str) -> np.ndarray:
    """Return the axis-angles [24, 3] of one of `POSES`.

    `up`: arms raised beside the head; `goalpost`: upper arms level, forearms up; `hips`: hands beside the hips, elbows
    out; `forward`: arms held out ahead. An arm lies along x in the T-pose; a turn about x twists it.
    """
    if name in ("T", "A", "arms-down", "stride", "seated"):
        return named_pose(name)
    lift, twist, bend, ahead = {
        "up": (0.95, 0.0, 0.15, 0.0),
        "goalpost": (0.0, -1.35, 1.45, 0.0),
        "hips": (-0.75, 1.2, 1.45, 0.0),
        "forward": (-0.35, 0.3, 0.5, 0.9),
    }[name]
    angles = arm_pose(0.0)
    for side, sign in (("left", 1.0), ("right", -1.0)):
        turn = Rotation.from_euler("xyz", [twist, -sign * ahead, sign * lift])
        angles[JOINTS.index(f"{side}_shoulder")] = turn.as_rotvec()
        angles[JOINTS.index(f"{side}_elbow"), 1] = -sign * bend
    return angles


def stand(template: Template, shape: np.ndarray, angles: np.ndarray) -> Body:
    """Return the built-in body of a shape in a pose, its lowest point at y = 0."""
    source = "builtin:drawn"
    lowest = pose_template(template, shape, angles, source).vertices[:, 1].min()
    return pose_template(template, shape, angles, source, -np.array([0.0, lowest, 0.0]))


def size_of(body: Body) -> float:
    """Return a wearer's height as a share of 1.7 m."""
    return float(np.ptp(body.rest_vertices[:, 1])) / 1.7


def at_rest(body: Body) -> Body:
    """Return the same wearer in the T-pose."""
    return replace(
        body,
        vertices=body.rest_vertices,
        joints=body.rest_joints,
        transforms=np.tile(np.eye(4), (24, 1, 1)),
        parameters={**body.parameters, "pose": np.zeros((24, 3)), "translation": np.zeros(3)},
    )


def runs_into_itself(body: Body) -> bool:
    """Return True where forearms, hands or shanks are inside another part of the body."""
    own = body.weights.argmax(axis=1)
    normals = vertex_normals(body.vertices, body.faces)
    for side in ("left", "right"):
        arm = _indices(f"{side}_elbow", f"{side}_wrist", f"{side}_hand")
        leg = _indices(f"{side}_knee", f"{side}_ankle", f"{side}_foot")
        for limb, near in ((arm, _indices(f"{side}_shoulder", f"{side}_collar")), (leg, _indices(f"{side}_hip"))):
            mine = np.isin(own, limb)
            others = ~np.isin(own, [*limb, *near])
            distance, index = cKDTree(body.vertices[others]).query(body.vertices[mine], distance_upper_bound=0.1)
            found = np.isfinite(distance)
            gap = body.vertices[mine][found] - body.vertices[others][index[found]]
            if (np.einsum("na,na->n", gap, normals[others][index[found]]) < -OVERLAP).any():
                return True
    return False


def _indices(*names: str) -> list[int]:
    return [JOINTS.index(name) for name in names]
