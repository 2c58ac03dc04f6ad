"""Draw wearers: a shape of the built-in body, and poses in which the body does not run into itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from ..core.body.body import JOINTS, Body
from ..core.body.builtin import arm_pose, named_pose, pose_template
from ..core.body.fit import POSE_PRIOR_STDS
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
    ("A", 0.34), ("T", 0.10), ("arms-down", 0.2), ("stride", 0.1), ("up", 0.06), ("goalpost", 0.06), ("hips", 0.07),
    ("forward", 0.07),
)  # fmt: skip
"""Start poses and how often each is drawn: what scanning protocols ask for, most often the A-pose."""


def draw_shape(template: Template, rng: np.random.Generator) -> tuple[str, np.ndarray]:
    """Draw gender and shape coefficients, shape [k], from the built-in means and covariances."""
    gender = str(rng.choice(["female", "male"]))
    return gender, rng.multivariate_normal(template.means[gender], template.covariances[gender], method="eigh")


def draw_pose(template: Template, shape: np.ndarray, rng: np.random.Generator) -> tuple[str, Body]:
    """Draw a pose and return its name and the body in it; drawn anew where the body runs into itself."""
    names, shares = zip(*POSES, strict=True)
    for _ in range(TRIES):
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
    if name in ("T", "A", "arms-down", "stride"):
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
