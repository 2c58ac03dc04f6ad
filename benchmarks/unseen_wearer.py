"""Draw wearers in the built-in body's topology, on the skin of a body of `anny` where that is there, and pose them."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from importlib.util import find_spec
from typing import Any

import numpy as np
from garmentq.core.body.body import Body
from garmentq.core.body.builtin import builtin_body, named_pose
from garmentq.core.body.measured import MeasureRange
from garmentq.core.body.registration import register_body
from garmentq.core.body.skinning import skin
from garmentq.core.body.template import articulate, rotations_of, transforms_of
from garmentq.core.geometry.surface import TriangleSurface

OFF_MODEL = 0.02
"""How far the skin of a drawn body may lie from the built-in model that was fitted to it [m]: 2.2 mm on average, 10 at
hands; beyond, the nearest point is one of another limb."""

HEIGHTS = {"female": (1.65, 0.065), "male": (1.77, 0.07)}
"""Mean and standard deviation of adults' heights [m], where `anny` is absent."""

MASS_INDICES = (18.5, 32.0)
"""Between which weight over height squared is drawn there [kg/m2]."""

STEPS = 8
"""Poses on the way into one: of a turn of 70 degrees a skin that goes straight between them misses 0.5 % of an arm."""


def name_source() -> str:
    """Return where wearers are from."""
    return "anny" if find_spec("anny") else "builtin"


def draw_wearer(seed: int) -> Body:
    """Return a drawn adult in T-pose, in the built-in body's topology, feet at y = 0."""
    return _draw_anny(seed) if name_source() == "anny" else _draw_builtin(seed)


@cache
def _load_anny() -> Any:
    import anny
    import torch

    return anny.Anny(skinning_method="lbs", local_changes="all").to(torch.float64)


def _draw_anny(seed: int) -> Body:
    from foreign_body import draw_body

    vertices, faces, _ = draw_body(_load_anny(), seed)
    body = register_body(vertices, faces, name="drawn")
    fitted = skin(body.rest_vertices, body.rest_weights, body.transforms)
    near = TriangleSurface(vertices, faces).closest(fitted).foot
    off = np.linalg.norm(near - fitted, axis=1)
    own = np.where((off < OFF_MODEL)[:, None], near, fitted)
    floor = np.array([0.0, own[:, 1].min(), 0.0])
    own, joints = own - floor, body.joints - floor
    return replace(
        body, vertices=own, faces=body.rest_faces, joints=joints, weights=body.rest_weights, rest_vertices=own,
        rest_joints=joints, transforms=np.tile(np.eye(4), (24, 1, 1)), heading=np.eye(3),
        parameters={**body.parameters, "pose": np.zeros((24, 3)), "translation": np.zeros(3)}, source="mesh:drawn",
    )  # fmt: skip


def _draw_builtin(seed: int) -> Body:
    rng = np.random.default_rng([seed, 3])
    while True:
        gender = str(rng.choice(["female", "male"]))
        height = rng.normal(*HEIGHTS[gender])
        weight = rng.uniform(*MASS_INDICES) * height**2
        try:
            return builtin_body(f"builtin:{gender},height={height:.3f},weight={weight:.1f}")
        except MeasureRange:
            continue


def pose_wearer(rest: Body, pose: str, share: float = 1.0) -> Body:
    """Return a wearer in a named pose, or on the way into it, the pelvis where it is in the T-pose.

    Args:
        rest: The wearer in T-pose.
        pose: One of the built-in body's.
        share: Of each joint's turn.
    """
    angles = share * named_pose(pose)
    world, joints = articulate(rotations_of(angles), rest.rest_joints, np.zeros(3))
    transforms = transforms_of(world, joints, rest.rest_joints)
    return replace(
        rest, vertices=skin(rest.rest_vertices, rest.rest_weights, transforms), joints=joints, transforms=transforms,
        parameters={**rest.parameters, "pose": angles},
    )  # fmt: skip


def pose_by_steps(rest: Body, pose: str) -> tuple[Body, ...]:
    """Return a wearer from the T-pose to another one; of the T-pose itself once."""
    if not np.abs(named_pose(pose)).any():
        return (rest,)
    return tuple(pose_wearer(rest, pose, share) for share in np.linspace(0.0, 1.0, STEPS + 1))
