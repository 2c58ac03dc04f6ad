"""Fit a recorded motion to a wearer with other bones, rest pose, size and place."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from ...geometry.geometry import unit
from ..body import JOINT_PARENTS, JOINTS, Body
from .recording import Recording
from .track import Pose, Track

BONE_END_JOINTS = {"hip": "knee", "knee": "ankle", "shoulder": "elbow", "elbow": "wrist"}
"""Joints whose bone is aligned with the recording's, and the joint at the bone's end. Only limbs differ between rest
poses (T, A, legs apart); trunk, head and feet do not."""

POSE_BLOCK_SIZE = 4096
"""Number of poses whose feet are examined together: 13 MB for a foot of 400 vertices, for motions of any length."""

PARENT_ALIGNED_JOINTS = ("wrist", "hand")
"""Joints whose rest pose differs from ours by the same rotation as their parent's."""


def retarget(recording: Recording, body: Body, begin: float = 0.0) -> Track:
    """Retarget a recording to a wearer, who is at the own place in the own heading at its time `begin` [s].

    A joint's rotation in the world is W A: W the recording's from its rest pose, A the least rotation that turns our
    bone in the T-pose into the recording's in its rest pose, so that bones point as in the recording. Joints that it
    lacks follow their parents. The pelvis moves in leg lengths. The motion is rotated about the vertical and translated
    so that it has the wearer's heading and place at `begin`. Its lowest foot of all poses stands on the wearer's floor;
    the lower foot of each pose does where the recording has no place of the pelvis.
    """
    world = _world_turns(recording, body)
    local = np.empty_like(world)
    for joint, parent in enumerate(JOINT_PARENTS):
        local[:, joint] = world[:, joint] if parent < 0 else world[:, parent].transpose(0, 2, 1) @ world[:, joint]
    start = Pose.of(body)
    feet = _lowest_foot_heights(world, body)
    if recording.root is None:
        pelvis = np.tile(start.pelvis, (len(world), 1))
        pelvis[:, 1] = _floor(body) - feet
    else:
        pelvis = leg_length(body.rest_joints) * (recording.root - recording.root[0])
        pelvis[:, 1] += _floor(body) - float((pelvis[:, 1] + feet).min())
    return _place(Track(recording.rate, local, pelvis, recording.loops), start, begin)


def _place(track: Track, start: Pose, begin: float) -> Track:
    """Rotate a motion about the vertical and translate it on the floor so that it agrees with a pose at `begin`."""
    joined = track.at(begin)
    heading = _yaw(start.turns[0]) * _yaw(joined.turns[0]).inv()
    turns = track.turns.copy()
    turns[:, 0] = heading.as_matrix() @ turns[:, 0]
    level = np.array([1.0, 0.0, 1.0])
    pelvis = heading.apply(track.pelvis - level * joined.pelvis) + level * start.pelvis
    return replace(track, turns=turns, pelvis=pelvis)


def leg_length(joints: np.ndarray) -> float:
    """Return the length of thigh and shin [m], the mean of both sides, of T-pose joints [m], shape [24, 3]."""
    sides = [
        [joints[JOINTS.index(f"{side}_{name}")] for name in ("hip", "knee", "ankle")] for side in ("left", "right")
    ]
    return float(np.mean([np.linalg.norm(np.diff(np.array(side), axis=0), axis=1).sum() for side in sides]))


def _world_turns(recording: Recording, body: Body) -> np.ndarray:
    """Return the rotation of each of our joints in the world's axes, shape [n, 24, 3, 3]."""
    world = np.empty_like(recording.turns)
    aligned = np.tile(np.eye(3), (24, 1, 1))
    for joint, parent in enumerate(JOINT_PARENTS):
        name = JOINTS[joint]
        side, _, part = name.partition("_")
        if part in BONE_END_JOINTS and recording.bones[joint].any():
            axis = unit(body.rest_joints[JOINTS.index(f"{side}_{BONE_END_JOINTS[part]}")] - body.rest_joints[joint])
            aligned[joint] = shortest_rotation(axis, recording.bones[joint])
        elif part in PARENT_ALIGNED_JOINTS:
            aligned[joint] = aligned[parent]
        if recording.known[joint]:
            world[:, joint] = recording.turns[:, joint] @ aligned[joint]
        else:
            world[:, joint] = np.eye(3) if parent < 0 else world[:, parent]
    return world


def shortest_rotation(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return the least rotation [3, 3] of one unit vector into another."""
    axis, cosine = np.cross(start, end), float(np.clip(start @ end, -1.0, 1.0))
    size = float(np.linalg.norm(axis))
    if size < 1e-12:  # opposite: half a turn about any axis across
        other = np.cross(start, np.eye(3)[np.abs(start).argmin()])
        return np.asarray(
            np.eye(3) if cosine > 0 else Rotation.from_rotvec(np.pi * other / np.linalg.norm(other)).as_matrix()
        )
    return np.asarray(Rotation.from_rotvec(np.arctan2(size, cosine) * axis / size).as_matrix())


def _yaw(turn: np.ndarray) -> Rotation:
    """Return the rotation about the vertical of a rotation [3, 3]: the heading of its +z."""
    front = turn @ np.array([0.0, 0.0, 1.0])
    return Rotation.from_rotvec([0.0, float(np.arctan2(front[0], front[2])), 0.0])


def _lowest_foot_heights(world: np.ndarray, body: Body) -> np.ndarray:
    """Return the height of the lowest point of both feet above the pelvis [m] in each pose, shape [n]."""
    joints = body.rest_joints
    posed = np.zeros((len(world), 24, 3))
    for joint, parent in enumerate(JOINT_PARENTS):
        if parent >= 0:
            posed[:, joint] = posed[:, parent] + world[:, parent] @ (joints[joint] - joints[parent])
    lowest = np.full(len(world), np.inf)
    for side in ("left", "right"):
        for name in ("ankle", "foot"):
            joint = JOINTS.index(f"{side}_{name}")
            vertices = np.flatnonzero(body.rest_weights[:, joint] > 0.5)
            if not len(vertices):
                vertices = np.array([np.linalg.norm(body.rest_vertices - joints[joint], axis=1).argmin()])
            points = body.rest_vertices[vertices] - joints[joint]
            for first in range(0, len(world), POSE_BLOCK_SIZE):
                poses = slice(first, first + POSE_BLOCK_SIZE)
                below = (points @ world[poses, joint, 1].T).min(axis=0)
                lowest[poses] = np.minimum(lowest[poses], below + posed[poses, joint, 1])
    return lowest


def _floor(body: Body) -> float:
    """Return the height of the wearer's floor [m]: the lowest vertex of the mesh."""
    return float(body.vertices[:, 1].min())
