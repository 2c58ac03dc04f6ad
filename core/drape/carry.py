"""Carry cloth from the T-pose into a pose: the body moves in frames, and the cloth follows it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from ..body import PARENTS, Body, skin, unskin, weights_at
from .follow import FollowSettings, Lookup, Threads, follow


@dataclass(frozen=True)
class CarrySettings:
    """Set how the body takes its pose.

    Attributes:
        frames: Frames from the T-pose; in 20 no joint turns by more than 5 degrees a frame, and the cloth under an arm
            is pushed by less than an edge.
        steps: Position-based steps a frame, without weight.
        follow: The position-based steps.
    """

    frames: int = 20
    steps: int = 3
    follow: FollowSettings = field(default_factory=FollowSettings)


def transforms_between(body: Body, share: float) -> np.ndarray:
    """Give the transforms [24, 4, 4] of a body that has taken a share of its pose, its pelvis as in the pose.

    Every joint's rotation relative to its parent is taken by that share of its angle. The pelvis turns and moves at
    once: it carries the whole person, and cloth on it does not feel it.
    """
    world = body.transforms[:, :3, :3]
    joints = body.rest_joints
    turned = np.zeros_like(world)
    posed = np.zeros_like(joints)
    for j, parent in enumerate(PARENTS):
        if parent < 0:
            turned[j] = world[j]
            posed[j] = world[j] @ joints[j] + body.transforms[j, :3, 3]
            continue
        local = Rotation.from_matrix(world[parent].T @ world[j]).as_rotvec()
        turned[j] = turned[parent] @ Rotation.from_rotvec(share * local).as_matrix()
        posed[j] = posed[parent] + turned[parent] @ (joints[j] - joints[parent])
    transforms = np.tile(np.eye(4), (len(joints), 1, 1))
    transforms[:, :3, :3] = turned
    transforms[:, :3, 3] = posed - np.einsum("jab,jb->ja", turned, joints)
    return transforms


def carry(
    threads: Threads,
    nodes: np.ndarray,
    body: Body,
    *,
    settings: CarrySettings = CarrySettings(),
    held: np.ndarray | None = None,
) -> np.ndarray:
    """Carry cloth on the T-pose into the pose of a body and give the nodes [m], shape [node_count, 3].

    In each frame the cloth moves with the skin around it, and its edges and the contact with the moved body are then
    restored. Skinning alone, in one go, pushes a loose shirt's sides through each other where the arm comes down.

    Args:
        threads: The constraints.
        nodes: Positions around the rest pose [m], shape [node_count, 3].
        body: The wearer; its fitted model is what moves.
        settings: Frames and steps.
        held: Nodes that only the skin moves, or None.
    """
    weights = weights_at(body, nodes, rest=True)
    before = transforms_between(body, 0.0)
    nodes = skin(nodes, weights, before)
    for frame in range(settings.frames):
        after = transforms_between(body, (frame + 1) / settings.frames)
        nodes = skin(unskin(nodes, weights, before), weights, after)
        surface = skin(body.rest_vertices, body.rest_weights, after)
        lookup = nearest_lookup(surface, body.rest_faces)
        nodes, _ = follow(threads, nodes, lookup, settings.steps, settings=settings.follow, held=held)
        before = after
    return nodes


def nearest_lookup(vertices: np.ndarray, faces: np.ndarray) -> Lookup:
    """Give the distance to the tangent plane at the nearest vertex of a body [m]: quick to build for a moving one.

    Near a surface with edges of 2 cm and curvature of a limb it errs by about 1 mm, which the drape on the body's own
    distance, at the end, takes out.
    """
    corners = vertices[faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(normals, faces[:, k], cross)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    tree = cKDTree(vertices)

    def lookup(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        _, nearest = tree.query(points)
        normal = normals[nearest]
        return ((points - vertices[nearest]) * normal).sum(1), normal

    return lookup
