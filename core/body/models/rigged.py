"""Make a body of a person's mesh that has another skeleton: its joints and weights by ours, and a T-pose."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ...geometry.geometry import unit
from ..body import JOINT_PARENTS, JOINTS, Body
from ..model_arrays import PERSON_HEIGHT_RANGE, BodyModelBad
from ..motion.joint_names import find_joints
from ..motion.joint_tree import JointTree
from ..motion.retarget import shortest_rotation
from ..skinning import skin, unskin
from ..template import rotations_of

MIN_BONE_LENGTH = 1e-3
"""Least length of a bone that has a direction [m]."""

ARM_BONES = (("shoulder", "elbow"), ("elbow", "wrist"), ("wrist", "hand"))
"""The bones of an arm that are level in the T-pose, from the trunk outwards."""


@dataclass(frozen=True)
class RiggedMesh:
    """Describe a standing person's mesh with a foreign skeleton, y up, facing +z.

    Attributes:
        vertices: Positions [m], shape [n, 3].
        faces: Outward faces, shape [f, 3].
        tree: The foreign joints: names, parents, and places in the mesh [m].
        weights: Skinning weights, rows sum to 1, shape [n, joint_count].
    """

    vertices: np.ndarray
    faces: np.ndarray
    tree: JointTree
    weights: np.ndarray


@dataclass(frozen=True)
class StandingMesh:
    """Describe a standing person's mesh with our joints.

    Attributes:
        vertices: Positions [m], shape [n, 3].
        faces: Outward faces, shape [f, 3].
        joints: Joints [m], order of `JOINTS`, shape [24, 3].
        weights: Skinning weights, rows sum to 1, shape [n, 24].
    """

    vertices: np.ndarray
    faces: np.ndarray
    joints: np.ndarray
    weights: np.ndarray


@dataclass(frozen=True)
class PosedMesh:
    """Describe where a model puts its standing mesh.

    Attributes:
        vertices: Positions [m], shape [n, 3].
        transforms: From the standing mesh to the pose, per joint of `JOINTS`, homogeneous, shape [24, 4, 4].
        parameters: The model's own, by name; they are kept with the body.
    """

    vertices: np.ndarray
    transforms: np.ndarray = field(default_factory=lambda: np.tile(np.eye(4), (24, 1, 1)))
    parameters: Mapping[str, np.ndarray] = field(default_factory=dict)


def reduce_rig(rig: RiggedMesh) -> tuple[StandingMesh, np.ndarray]:
    """Reduce a foreign skeleton to `JOINTS`.

    Joints are found by name, else by place (`find_joints`); a joint between two of ours, and a finger or a face's,
    counts for the nearest one above it. Our hand's joint is the mean of the joints below the wrist.

    Returns:
        The mesh, and for each of our joints the index of the foreign one that moves it, shape [24].

    Raises:
        BodyModelBad: where a joint is not found.
    """
    tree = rig.tree
    at = find_joints(tree).at
    missing = [name for name in JOINTS if name not in at and not name.endswith("_hand")]
    if missing:
        raise BodyModelBad(f"no joint of it is {', '.join(missing)}. {BodyModelBad().message}")
    source = np.array([at[name.replace("_hand", "_wrist")] for name in JOINTS])
    joints = tree.places[source].copy()
    owner = {joint: JOINTS.index(name) for name, joint in at.items() if name in JOINTS}
    ours = np.zeros(len(tree.parents), dtype=np.int64)
    for joint, parent in enumerate(tree.parents):
        ours[joint] = owner.get(joint, ours[parent] if parent >= 0 else 0)
    for side in ("left", "right"):
        wrist, hand = JOINTS.index(f"{side}_wrist"), JOINTS.index(f"{side}_hand")
        knuckles = [joint for joint in tree.children[at[f"{side}_wrist"]] if not tree.is_end(joint)]
        if knuckles:
            joints[hand] = tree.places[knuckles].mean(axis=0)
        else:
            elbow = joints[JOINTS.index(f"{side}_elbow")]
            joints[hand] = joints[wrist] + 0.35 * (joints[wrist] - elbow)
        for joint, parent in enumerate(tree.parents):
            if parent >= 0 and (joint in knuckles or ours[parent] == hand):
                ours[joint] = hand
    weights = rig.weights @ np.eye(24)[ours]
    return StandingMesh(rig.vertices, rig.faces, joints, weights), source


def find_arm_turns(joints: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Turn the arms of a standing person until they are level, as in the T-pose.

    Args:
        joints: Joints [m], shape [24, 3]; the person faces +z.

    Returns:
        Homogeneous transforms of the joints [24, 4, 4], and the joints in the T-pose [24, 3].

    Raises:
        BodyModelBad: where two joints of an arm are at one place.
    """
    turns, places = np.tile(np.eye(4), (24, 1, 1)), joints.copy()
    for side, sign in (("left", 1.0), ("right", -1.0)):
        for upper, lower in ARM_BONES:
            first, last = JOINTS.index(f"{side}_{upper}"), JOINTS.index(f"{side}_{lower}")
            bone = places[last] - places[first]
            if np.linalg.norm(bone) < MIN_BONE_LENGTH:
                raise BodyModelBad(f"its {side} {upper} and {lower} are at one place. {BodyModelBad().message}")
            turn = np.eye(4)
            turn[:3, :3] = shortest_rotation(unit(bone), np.array([sign, 0.0, 0.0]))
            turn[:3, 3] = places[first] - turn[:3, :3] @ places[first]
            moved = {first}
            for joint, parent in enumerate(JOINT_PARENTS):
                if joint in moved or parent in moved:
                    moved.add(joint)
                    turns[joint] = turn @ turns[joint]
                    places[joint] = turn[:3, :3] @ places[joint] + turn[:3, 3]
    return turns, places


def make_body(mesh: StandingMesh, source: str, posed: PosedMesh | None = None) -> Body:
    """Make a body of a model's mesh; nothing is fitted, and the vertices are the model's own.

    The T-pose v of a standing mesh s with weights w is that of which linear blend skinning makes it again: (sum over
    joints j of w_j B_j) v = s, with B_j the transform that takes the level arms of joint j back to the mesh's.

    Args:
        mesh: The standing mesh.
        source: The body's `source`.
        posed: Where the model puts it; None: it stands. What skinning leaves of that, pose blend shapes for instance,
            is `fit_rms`.

    Raises:
        BodyModelBad: where it has no person's height, or a place that is no number.
    """
    posed = posed or PosedMesh(mesh.vertices)
    if not all(np.isfinite(one).all() for one in (mesh.vertices, mesh.joints, posed.vertices, posed.transforms)):
        raise BodyModelBad(f"a vertex or a joint is at no finite place. {BodyModelBad().message}")
    height = float(np.ptp(mesh.vertices[:, 1]))
    if not PERSON_HEIGHT_RANGE[0] <= height <= PERSON_HEIGHT_RANGE[1]:
        low, high = PERSON_HEIGHT_RANGE
        raise BodyModelBad(f"the body is {height:.2f} m high; give one of {low:g} to {high:g} m in metres, y up.")
    turns, level = find_arm_turns(mesh.joints)
    try:
        rest = unskin(mesh.vertices, mesh.weights, np.linalg.inv(turns))
    except np.linalg.LinAlgError as error:
        raise BodyModelBad(f"its arms cannot be raised to the T-pose. {BodyModelBad().message}") from error
    floor = np.array([level[0, 0], rest[:, 1].min(), level[0, 2]])
    turns[:, :3, 3] -= floor
    rest, level = rest - floor, level - floor
    transforms = posed.transforms @ np.linalg.inv(turns)
    front = transforms[0, :3, :3] @ np.array([0.0, 0.0, 1.0])
    left = skin(rest, mesh.weights, transforms) - posed.vertices
    return Body(
        vertices=posed.vertices,
        faces=mesh.faces,
        joints=np.einsum("jab,jb->ja", transforms[:, :3, :3], level) + transforms[:, :3, 3],
        weights=mesh.weights,
        transforms=transforms,
        rest_vertices=rest,
        rest_faces=mesh.faces,
        rest_joints=level,
        rest_weights=mesh.weights,
        heading=rotations_of(np.array([0.0, -np.arctan2(front[0], front[2]), 0.0])),
        parameters=dict(posed.parameters),
        source=source,
        fit_rms=float(np.sqrt((left**2).sum(axis=1).mean())),
    )


def keep_largest_part(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the indices of the vertices of a mesh's largest connected part, and its faces: skin without eyeballs and
    teeth."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    edges = faces[:, [0, 1, 1, 2]].reshape(-1, 2)
    graph = coo_matrix((np.ones(len(edges)), edges.T), shape=(len(vertices), len(vertices)))
    part = connected_components(graph, directed=False)[1]
    kept = np.flatnonzero(part == np.bincount(part[faces[:, 0]]).argmax())
    new = np.full(len(vertices), -1)
    new[kept] = np.arange(len(kept))
    return kept, new[faces[(new[faces] >= 0).all(axis=1)]]
