"""Carry cloth from the T-pose into a pose: the body moves in frames, and the cloth follows it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from scipy import sparse
from scipy.spatial.transform import Rotation

from ...body.advection import advect_outside
from ...body.body import JOINT_PARENTS, Body
from ...body.exposed import ExposedSurface
from ...body.projection import project_outside
from ...body.signed_distance import SignedDistance
from ...body.skinning import skin, unskin, weights_at
from ...body.solid import Solid
from ...body.untangling import untangle_outside
from ...cloth.settings import STANDARD_GRAVITY
from ...geometry.connectivity import adjacency_matrix
from ...geometry.geometry import vertex_normals
from ...geometry.intersections import self_intersections, undo_crossings
from ...geometry.linear import factor_symmetric
from .layer_contact import LayerContact
from .pbd import DistanceConstraints, PbdSettings, PbdState, simulate_pbd
from .shell import Shell, ShellDistance


@dataclass(frozen=True)
class PosingSettings:
    """Describe how the body takes its pose.

    Attributes:
        turn: Largest turn of a joint in a frame [rad]; 2.25 degrees move a wrist by 2 cm and a knee by 1.5.
        steps: Number of position-based steps a frame, without weight.
        spread: Width over which the displacement by the skin is smoothed [m]: wider than the crease of a joint, where
            skin moves against skin, and narrower than a limb's girth.
        settle: Number of position-based steps under gravity at the end.
        settlings: Largest number of such runs until the cloth is settled. One was enough in 47 of the suite's 48 cases
            of a template in a pose; a jumpsuit needed two on one processor, one on another.
        follow: The position-based steps.
    """

    turn: float = math.radians(2.25)
    steps: int = 3
    spread: float = 0.06
    settle: int = 60
    settlings: int = 4
    follow: PbdSettings = field(default_factory=PbdSettings)


def transforms_between(body: Body, share: float) -> np.ndarray:
    """Return the transforms [24, 4, 4] of a body that has taken a share of its pose, its pelvis as in the pose.

    Every joint turns by that share of its angle relative to its parent. The pelvis turns and moves at once: it carries
    the whole person, and cloth is not affected by that.
    """
    world = body.transforms[:, :3, :3]
    joints = body.rest_joints
    turned = np.zeros_like(world)
    posed = np.zeros_like(joints)
    for j, parent in enumerate(JOINT_PARENTS):
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


EXPOSED_SKIN_INTERVAL = 4
"""Number of frames that share one search for exposed skin, in the last of them: the search takes most of the time of a
frame, and creases close by millimetres a frame."""


@dataclass(frozen=True)
class PosePath:
    """Describe the path of a body from its T-pose into its pose, shared by all garments.

    Attributes:
        body: The wearer.
        transforms: From the rest pose to each frame, the first one the T-pose, shape [frame_count + 1, 24, 4, 4].
        shells: The exposed surface of the fitted model in each frame but the first.
        shell: The exposed surface of the wearer's own mesh.
        skin: The exact exposed skin of that mesh.
    """

    body: Body
    transforms: np.ndarray
    shells: tuple[Shell, ...]
    shell: Shell
    skin: ExposedSurface

    @classmethod
    def of(cls, body: Body, exposed: ExposedSurface, turn: float = PosingSettings.turn) -> PosePath:
        """Pose the fitted model of a body in frames in which no joint turns by more than an angle [rad]."""
        frames = max(1, math.ceil(_largest_joint_angle(body) / turn))
        transforms = np.stack([transforms_between(body, frame / frames) for frame in range(frames + 1)])
        surfaces = [skin(body.rest_vertices, body.rest_weights, moved) for moved in transforms[1:]]
        shells = []
        for start in range(0, frames, EXPOSED_SKIN_INTERVAL):
            group = surfaces[start : start + EXPOSED_SKIN_INTERVAL]
            normals = vertex_normals(group[-1], body.rest_faces)
            bare = Solid(group[-1], body.rest_faces).exposed(group[-1], normals)
            shells += [Shell.of(surface, body.rest_faces, bare) for surface in group]
        return cls(body, transforms, tuple(shells), Shell.of(body.vertices, body.faces), exposed)


CREEPING_LAYERS = LayerContact(partial_steps=True)
"""Layers that would cross move as far as they have room: a bundle that the body presses must not jam."""

MAX_FRAME_CLEARANCE_ITERATIONS = 5
"""Largest number of iterations of 2 mm that move cloth out of the body: creases close by less in a frame."""

MAX_BODY_CLEARANCE_ITERATIONS = 4
"""Largest number of rounds of five 4 mm steps that move cloth out of the exact body: out of a crease 8 cm deep."""


def _largest_joint_angle(body: Body) -> float:
    """Return the largest angle of a joint relative to its parent [rad]."""
    world = body.transforms[:, :3, :3]
    return max(
        float(Rotation.from_matrix(world[parent].T @ world[j]).magnitude())
        for j, parent in enumerate(JOINT_PARENTS)
        if parent >= 0
    )


def pose_cloth(
    threads: DistanceConstraints,
    nodes: np.ndarray,
    path: PosePath,
    body: SignedDistance,
    *,
    settings: PosingSettings = PosingSettings(),
    pins: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Carry cloth into a body's pose and settle it on the wearer's own mesh; return nodes [m] and velocities [m/s].

    Layers of cloth stay apart throughout: what does not cross in the T-pose does not cross in the pose.

    Args:
        threads: The constraints.
        nodes: Positions around the rest pose [m], shape [node_count, 3].
        path: The body's frames.
        body: Signed distance to the wearer's own mesh in its pose.
        settings: Frames and steps.
        pins: Nodes that only the skin moves, or None.
    """
    nodes = move_with_skin(threads, nodes, path, settings=settings, pins=pins)
    out = np.zeros_like(nodes)
    if pins is not None:
        out[pins] = push_outside(nodes[pins], path.shell, settings.follow.thickness) - nodes[pins]
    state, around = PbdState.at_rest(nodes, out), ShellDistance(path.shell, body)
    damped, weight = replace(settings.follow, damp=True), -STANDARD_GRAVITY[1]
    for _ in range(settings.settlings):
        state = simulate_pbd(
            threads, state, around, settings.settle, settings=damped, gravity=weight, pins=pins, layers=CREEPING_LAYERS
        )
        if state.is_settled:
            break
    return resolve_body_penetration(threads, state.nodes, path, settings=settings, pins=pins), state.velocities


def resolve_body_penetration(
    threads: DistanceConstraints,
    nodes: np.ndarray,
    path: PosePath,
    *,
    settings: PosingSettings = PosingSettings(),
    pins: np.ndarray | None = None,
) -> np.ndarray:
    """Move cloth out of the wearer's exact mesh, its layers together, and return the nodes [m], shape [node_count, 3].

    The distance grid errs by millimetres where body parts meet. `advect_outside` moves cloth out together with the
    layers around it; `project_outside` does the rest where it creates no crossings, after a few steps without weight if
    necessary. Cloth that still crosses once outside, such as a fold in the crease of a lap whose nodes leave towards
    thigh and belly, is untangled there (`untangle_outside`); a node without a way out stays.
    """
    faces, body = threads.faces, ShellDistance(path.shell, path.skin)
    nodes = advect_outside(nodes, faces, path.skin, threads.mean_edge)
    for _ in range(MAX_BODY_CLEARANCE_ITERATIONS):
        pushed = project_outside(nodes, path.skin, faces)
        if np.array_equal(pushed, nodes) or len(self_intersections(pushed, faces)) <= len(
            self_intersections(nodes, faces)
        ):
            return pushed
        start = PbdState.at_rest(nodes)
        nodes = simulate_pbd(threads, start, body, 5, settings=settings.follow, pins=pins, layers=CREEPING_LAYERS).nodes
    pushed = untangle_outside(project_outside(nodes, path.skin, faces), path.skin, faces)
    undo_crossings(pushed, nodes, faces, self_intersections(nodes, faces))
    return pushed


def move_with_skin(
    threads: DistanceConstraints,
    nodes: np.ndarray,
    path: PosePath,
    *,
    settings: PosingSettings = PosingSettings(),
    pins: np.ndarray | None = None,
) -> np.ndarray:
    """Carry cloth on the T-pose into the pose of a body and return the nodes [m], shape [node_count, 3].

    In each frame the skin around the cloth displaces it; then its edge lengths and the contact with the moved body are
    restored, and near layers repel each other. Skinning at once would push a loose shirt's sides through each other.

    Args:
        threads: The constraints.
        nodes: Positions around the rest pose [m], shape [node_count, 3].
        path: The frames of the wearer's fitted model.
        settings: Steps of a frame.
        pins: Nodes that only the skin moves, or None.
    """
    weights = weights_at(path.body, nodes, rest=True)
    spread = _smoothing_operator(threads, settings.spread)
    nodes = skin(nodes, weights, path.transforms[0])
    for before, after, shell in zip(path.transforms, path.transforms[1:], path.shells, strict=False):
        ride = skin(unskin(nodes, weights, before), weights, after) - nodes
        even = spread(ride)
        if pins is not None:
            even[pins] = push_outside(nodes[pins] + ride[pins], shell, settings.follow.thickness) - nodes[pins]
        start, chosen = PbdState.at_rest(nodes, even), settings.follow
        nodes = simulate_pbd(
            threads, start, shell, settings.steps, settings=chosen, pins=pins, layers=CREEPING_LAYERS
        ).nodes
        nodes = advect_outside(nodes, threads.faces, shell, threads.mean_edge, MAX_FRAME_CLEARANCE_ITERATIONS)
    return nodes


MAX_PUSH_OUT_ITERATIONS = 3
"""Largest number of pushes that move pinned nodes out of the body: in a hollow a push may end in the other surface."""


def push_outside(points: np.ndarray, body: SignedDistance, thickness: float) -> np.ndarray:
    """Move points [m], shape [n, 3], out of a body that may cross itself, to a distance from it [m]."""
    points = np.array(points)
    for _ in range(MAX_PUSH_OUT_ITERATIONS):
        distance, normal = body.measure(points)
        short = np.maximum(thickness - distance, 0.0)[:, None] * normal
        points += short.reshape(-1, len(points), 3).sum(axis=0)
        if not short.any():
            break
    return points


def _smoothing_operator(threads: DistanceConstraints, width: float) -> Callable[[np.ndarray], np.ndarray]:
    """Return the operator that smooths a field on the nodes over a width [m]: (1 - width^2 Laplacian)^-1.

    On a hexagonal lattice of edge h the Laplacian is 2 / (3 h^2) times the sum of differences to the neighbours.
    """
    pairs = threads.ends[threads.stiffness == 1.0]
    share = 2.0 * width**2 / (3.0 * float(np.mean(threads.lengths[threads.stiffness == 1.0] ** 2)))
    count = len(threads.inverse_mass)
    matrix = sparse.identity(count) + sparse.csgraph.laplacian(share * adjacency_matrix(pairs, count))
    return factor_symmetric(matrix).solve
