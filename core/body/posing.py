"""Put a body into another pose."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .body import Body
from .builtin import POSES, BodySpecBad, named_pose, parse_spec
from .skinning import skin
from .spec import BuiltinWearer
from .template import articulate, rotations_of, transforms_of


def pose_body(body: Body, pose: str) -> Body:
    """Return a body's fitted model in a pose of `POSES` by linear blend skinning: the T-pose's feet, facing +z.

    Raises:
        BodySpecBad: where there is no such pose.
    """
    check_wearer(None, pose)
    angles = named_pose(pose)
    world, posed = articulate(rotations_of(angles), body.rest_joints, np.zeros(3))
    transforms = transforms_of(world, posed, body.rest_joints)
    return replace(
        body,
        vertices=skin(body.rest_vertices, body.rest_weights, transforms),
        faces=body.rest_faces,
        joints=posed,
        weights=body.rest_weights,
        transforms=transforms,
        heading=np.eye(3),
        parameters={**body.parameters, "pose": angles, "translation": np.zeros(3)},
    )


def check_wearer(built_in: BuiltinWearer | None, pose: str | None) -> None:
    """Check a built-in body's description, if given, and a pose.

    Raises:
        BodySpecBad: where one is not valid.
    """
    if built_in is not None:
        parse_spec(built_in.spec)
    if pose is not None and pose not in POSES:
        raise BodySpecBad(f"pose '{pose[:40]}' is not one of {', '.join(POSES)}.")
