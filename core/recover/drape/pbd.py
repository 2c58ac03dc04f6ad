"""Move cloth with a body by position-based dynamics: fast, stable, accurate enough to start Newton's method."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...body.signed_distance import SignedDistance
from ...garment.creases import CREASE_ANGLE, crease_edges, mark_edges
from ...garment.garment import Garment
from ...geometry.connectivity import HalfEdges
from ...geometry.geometry import lump, signed_areas
from ...run.kernels import kernel
from .layer_contact import LayerContact
from .layers import HalfSpaces

MOVE_REVERSAL_COSINE = -0.5
"""Cosine between two successive moves of a node below which the second reverses the first."""

MOVE_SHARE_GROWTH = 1.2
"""Factor by which the accepted share of a node's move grows while moves do not reverse: halved, it is 1 after four."""


@dataclass(frozen=True)
class DistanceConstraints:
    """Describe the distance constraints of a sewn garment.

    Attributes:
        ends: Node pairs, edges of the mesh first, then the pairs across hinges, shape [pair_count, 2].
        lengths: Flat rest lengths [m]; on a seam the mean of its two sides, shape [pair_count].
        stiffness: Share of an error that one sweep removes, 1 for edges, less across hinges, shape [pair_count]. A
            pair across a crease has the negative share: it is only drawn together, other hinges are only held apart.
        inverse_mass: 1 / mass up to a common factor, shape [node_count].
        faces: The mesh, shape [face_count, 3].
        edges: Its edges, each once, shape [edge_count, 2].
    """

    ends: np.ndarray
    lengths: np.ndarray
    stiffness: np.ndarray
    inverse_mass: np.ndarray
    faces: np.ndarray
    edges: np.ndarray

    @property
    def mean_edge(self) -> float:
        """Return the mean length of the edges [m]."""
        return float(np.mean(self.lengths[: len(self.edges)]))

    @property
    def is_creased(self) -> bool:
        """Return whether the garment has creases."""
        return bool((self.stiffness < 0.0).any())


@dataclass(frozen=True)
class PbdSettings:
    """Describe the position-based steps.

    Attributes:
        dt: Step [s]; 1/60 s moves free-falling cloth by 3 mm at first, less than the contact thickness.
        sweeps: Number of Gauss-Seidel sweeps a step; 20 keep a T-shirt's edges within about 2 % under its weight.
        damping: Share of the velocity lost in a step; 0.1 settles cloth in about 60 steps.
        thickness: Distance kept from the body [m]; the simulator's contact begins at 4 mm, so Newton starts without it.
        friction: Coulomb coefficient against the body [1].
        bending: Share of a hinge's error that a sweep removes; 0.1 keeps folds wider than three edges, but no skirt
            spread.
        travel: Longest move of a node in a step [m]; half an edge, so that nothing passes through the body.
        damp: In the second half of the steps, bring nodes to rest that two surfaces (an armpit's, a lap's) push back
            and forth, each the nearest in turn; in the first half they may find a way out of a crease.
    """

    dt: float = 1.0 / 60.0
    sweeps: int = 20
    damping: float = 0.1
    thickness: float = 4e-3
    friction: float = 0.4
    bending: float = 0.1
    travel: float = 8e-3
    damp: bool = False


def build_distance_constraints(garment: Garment, bending: float = 0.1) -> DistanceConstraints:
    """Return the distance constraints of a garment: mesh edges, and the opposite corners of every hinge.

    Lengths are those of the flat panels, never of the placed mesh. A pair that two panels share (a seam) takes the mean
    of its two lengths; opposite corners across a seam take the sum of the heights, as if it were pressed flat. Across a
    crease their length is that of the crease at rest.
    """
    faces, rest = garment.faces, garment.rest
    edges = HalfEdges.of(faces, len(garment.nodes))
    sides = np.linalg.norm(rest - np.roll(rest, -1, axis=1), axis=2).reshape(-1)
    lengths = np.bincount(edges.edge, weights=sides) / edges.face_counts
    is_creased = mark_edges(_pair_edges(edges), crease_edges(garment))
    cross, cross_lengths = _hinge_pairs(edges, rest, np.where(is_creased, CREASE_ANGLE, 0.0))
    mass = lump(np.abs(signed_areas(rest)), faces, len(garment.nodes))
    return DistanceConstraints(
        ends=np.concatenate([edges.edges, cross]).astype(np.int64),
        lengths=np.concatenate([lengths, cross_lengths]),
        stiffness=np.concatenate([np.ones(len(edges.edges)), np.where(is_creased, -bending, bending)]),
        inverse_mass=mass.mean() / np.maximum(mass, 1e-3 * mass.mean()),
        faces=faces,
        edges=edges.edges,
    )


def _pair_edges(edges: HalfEdges) -> np.ndarray:
    """Return the edge of every pair of faces as two nodes, shape [pair_count, 2]."""
    found: np.ndarray = edges.edges[edges.edge[edges.pairs[:, 0]]]
    return found


def _hinge_pairs(edges: HalfEdges, rest: np.ndarray, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the opposite corners of every interior edge and their distance [m] when the hinge is turned by an angle
    [rad]."""
    face, side = edges.pairs // 3, edges.pairs % 3
    a = np.take_along_axis(rest[face], side[..., None, None].repeat(2, 3), axis=2)[:, :, 0]
    b = np.take_along_axis(rest[face], ((side + 1) % 3)[..., None, None].repeat(2, 3), axis=2)[:, :, 0]
    c = np.take_along_axis(rest[face], ((side + 2) % 3)[..., None, None].repeat(2, 3), axis=2)[:, :, 0]
    axis = b - a
    span = np.linalg.norm(axis, axis=2, keepdims=True)
    axis = axis / np.maximum(span, 1e-12)
    along = ((c - a) * axis).sum(2)
    height = np.abs((c - a)[..., 0] * axis[..., 1] - (c - a)[..., 1] * axis[..., 0])
    # The two faces run along their common edge in opposite directions.
    offset = along[:, 0] - (span[:, 1, 0] - along[:, 1])
    flat = np.hypot(offset, height.sum(1))
    turned = np.sqrt(np.maximum(flat**2 - 2.0 * height.prod(1) * (1.0 - np.cos(angles)), 0.0))
    return edges.opposite[edges.pairs], np.where(angles > 0.0, turned, flat)


class ConstraintArrays(NamedTuple):
    """Describe distance constraints in the form of `_sweep`; see `DistanceConstraints`."""

    ends: np.ndarray
    lengths: np.ndarray
    stiffness: np.ndarray


class BodyPlanes(NamedTuple):
    """Describe planes of the body near some points.

    Attributes:
        points: Indices of the points, shape [count].
        normals: Unit length, shape [count, 3].
        offsets: Least value of normal . point [m], shape [count].
    """

    points: np.ndarray
    normals: np.ndarray
    offsets: np.ndarray

    def within(self, nodes: np.ndarray, push: float) -> BodyPlanes:
        """Return the planes moved back so that none pushes its point further than `push` [m] from nodes [m]."""
        return self._replace(offsets=np.minimum(self.offsets, (self.normals * nodes[self.points]).sum(1) + push))


@dataclass(frozen=True)
class PbdState:
    """Describe cloth between two position-based steps.

    Attributes:
        nodes: Positions [m], shape [node_count, 3].
        velocities: Velocities [m/s], shape [node_count, 3].
        carried: Displacement [m] by the body in the next step, shape [node_count, 3], or None.
    """

    nodes: np.ndarray
    velocities: np.ndarray
    carried: np.ndarray | None = None

    @classmethod
    def at_rest(cls, nodes: np.ndarray, carried: np.ndarray | None = None) -> PbdState:
        """Return the state of nodes [m], shape [node_count, 3], with zero velocity."""
        return cls(nodes, np.zeros(np.shape(nodes)), carried)

    @property
    def is_settled(self) -> bool:
        """Return whether 50 % of the nodes are slower than 1 cm/s and 90 % than 3 cm/s; falling cloth has 1 m/s."""
        speed = np.linalg.norm(self.velocities, axis=1)
        return bool(np.median(speed) < 0.01 and np.quantile(speed, 0.9) < 0.03)


@kernel()
def _sweep(
    nodes: np.ndarray, bonds: ConstraintArrays, weight: np.ndarray, planes: BodyPlanes, spaces: HalfSpaces, sweeps: int
) -> np.ndarray:
    """Project in place onto lengths, by alternating Gauss-Seidel, half-spaces and planes; return planes' pushes [m]."""
    ends, lengths, stiffness = bonds
    touched, normal, offset = planes
    count = len(ends)
    press = np.zeros(len(touched))
    for sweep in range(sweeps):
        for step in range(count):
            e = step if sweep % 2 == 0 else count - 1 - step
            i, j = ends[e, 0], ends[e, 1]
            total = weight[i] + weight[j]
            if total == 0.0:
                continue
            dx = nodes[j, 0] - nodes[i, 0]
            dy = nodes[j, 1] - nodes[i, 1]
            dz = nodes[j, 2] - nodes[i, 2]
            length = np.sqrt(dx * dx + dy * dy + dz * dz)
            if length < 1e-12:
                continue
            error = length - lengths[e]
            if stiffness[e] < 1.0 and (error > 0.0) == (stiffness[e] > 0.0):
                continue  # a hinge resists folding only: flat is its greatest length; a crease resists opening only
            scale = abs(stiffness[e]) * error / (length * total)
            nodes[i, 0] += weight[i] * scale * dx
            nodes[i, 1] += weight[i] * scale * dy
            nodes[i, 2] += weight[i] * scale * dz
            nodes[j, 0] -= weight[j] * scale * dx
            nodes[j, 1] -= weight[j] * scale * dy
            nodes[j, 2] -= weight[j] * scale * dz
        _project_half_spaces(nodes, weight, spaces)
        for c in range(len(touched)):
            i = touched[c]
            if weight[i] == 0.0:
                continue
            depth = offset[c] - normal[c, 0] * nodes[i, 0] - normal[c, 1] * nodes[i, 1] - normal[c, 2] * nodes[i, 2]
            if depth > 0.0:
                press[c] += depth
                nodes[i, 0] += depth * normal[c, 0]
                nodes[i, 1] += depth * normal[c, 1]
                nodes[i, 2] += depth * normal[c, 2]
        _project_half_spaces(nodes, weight, spaces)
    return press


@kernel()
def _project_half_spaces(nodes: np.ndarray, weight: np.ndarray, spaces: HalfSpaces) -> None:
    """Project, in place, each constraint's nodes into its half-space, the lighter ones further."""
    corners, shares, sides, least = spaces
    for c in range(len(corners)):
        value, total = -least[c], 0.0
        for k in range(4):
            i = corners[c, k]
            for d in range(3):
                value += shares[c, k] * sides[c, d] * nodes[i, d]
            total += shares[c, k] * shares[c, k] * weight[i]
        if value >= 0.0 or total < 1e-12:
            continue
        for k in range(4):
            i = corners[c, k]
            move = -value * shares[c, k] * weight[i] / total
            for d in range(3):
                nodes[i, d] += move * sides[c, d]


def simulate_pbd(
    threads: DistanceConstraints,
    state: PbdState,
    body: SignedDistance | None,
    steps: int,
    *,
    settings: PbdSettings = PbdSettings(),
    gravity: float = 0.0,
    pins: np.ndarray | None = None,
    layers: LayerContact | None = None,
) -> PbdState:
    """Move cloth for some steps and return its positions and velocities.

    Each step predicts by the velocity, then projects onto edge lengths and outside the body (Mueller et al. 2007,
    position based dynamics), with Coulomb friction on the change in position where the body is touched.

    Args:
        threads: The constraints.
        state: The initial state.
        body: Signed distance to the body, or None for no body. Where a point is near two surfaces (between arm and
            trunk), it may return a second row of distances and gradients after the first.
        steps: Number of steps.
        settings: Step length, sweeps, friction.
        gravity: Acceleration downwards along -y [m/s2].
        pins: Nodes that do not move, shape [held_count], or None.
        layers: How layers of cloth are kept apart, and the centres of faces out of the body, or None for neither.
    """
    x, v = np.array(state.nodes, dtype=np.float64), np.array(state.velocities, dtype=np.float64)
    weight = threads.inverse_mass.copy()
    if pins is not None:
        weight[pins] = 0.0
        v[pins] = 0.0
    bonds = ConstraintArrays(threads.ends, threads.lengths, threads.stiffness)
    apart = None if layers is None else layers.begin(x, threads.faces, threads.edges)
    eased, last = np.ones(len(x)), np.zeros_like(x)
    for step in range(steps):
        before = x.copy()
        v[:, 1] -= settings.dt * gravity * (weight > 0)
        start = before if state.carried is None or step else before + state.carried
        x = start + _limit_length(settings.dt * v, settings.travel)
        planes, spaces = _find_planes(body, x, settings), HalfSpaces.none()
        if apart is not None:
            planes = planes.within(x, apart.settings.push)
            spaces = apart.planes(before)
            if apart.settings.face_centres:
                spaces = spaces.joined(_face_planes(body, x, threads.faces, settings))
        press = _sweep(x, bonds, weight, planes, spaces, settings.sweeps)
        if len(planes.points):
            _apply_friction(x, start, planes, settings.friction * press)
        change = _limit_length(x - start, 3 * settings.travel)
        if settings.damp and 2 * step >= steps:
            eased = _damp_reversals(eased, change, last)
        x, last = start + change * eased[:, None], change
        if apart is not None:
            apart.finish(x, before)
        v = (x - start) / settings.dt * (1.0 - settings.damping)
        if apart is not None:
            v[planes.points[press > 0.25 * settings.thickness]] = 0.0
    return PbdState(x, v)


def _limit_length(change: np.ndarray, longest: float) -> np.ndarray:
    """Limit the length of each row [m] of a change."""
    length = np.linalg.norm(change, axis=1, keepdims=True)
    found: np.ndarray = change * np.minimum(1.0, longest / np.maximum(length, 1e-12))
    return found


def _damp_reversals(eased: np.ndarray, change: np.ndarray, last: np.ndarray) -> np.ndarray:
    """Return the share of its move that each node takes: halved where the move reverses, increased elsewhere."""
    size = np.linalg.norm(change, axis=1) * np.linalg.norm(last, axis=1)
    back = (change * last).sum(1) < MOVE_REVERSAL_COSINE * size
    return np.where(back, 0.5 * eased, np.minimum(1.0, MOVE_SHARE_GROWTH * eased))


def _find_planes(body: SignedDistance | None, points: np.ndarray, settings: PbdSettings) -> BodyPlanes:
    """Return the planes of the body near points [m], shape [n, 3]."""
    if body is None or not len(points):
        return BodyPlanes(np.zeros(0, dtype=np.int64), np.zeros((0, 3)), np.zeros(0))
    distance, gradient = body.measure(points)
    row = np.nonzero((distance < settings.thickness + settings.travel) & (np.abs(distance) < 0.5))[0]
    contact = row % len(points)
    slope = np.linalg.norm(gradient[row], axis=1, keepdims=True)
    normal = gradient[row] / np.maximum(slope, 1e-9)
    gap = distance[row] / np.maximum(slope[:, 0], 0.3)
    return BodyPlanes(contact, normal, (normal * points[contact]).sum(1) - gap + settings.thickness)


def _face_planes(
    body: SignedDistance | None, points: np.ndarray, faces: np.ndarray, settings: PbdSettings
) -> HalfSpaces:
    """Return constraints that keep the centres of faces out of the body, by a quarter of the thickness."""
    face, normal, offset = _find_planes(body, points[faces].mean(1), settings)
    corners = np.concatenate([faces[face], faces[face, :1]], axis=1)
    weights = np.tile([1 / 3, 1 / 3, 1 / 3, 0.0], (len(face), 1))
    return HalfSpaces(corners, weights, normal, offset - 0.75 * settings.thickness)


def _apply_friction(x: np.ndarray, before: np.ndarray, planes: BodyPlanes, grip: np.ndarray) -> None:
    """Reduce, in place, each touching node's sliding by at most `grip` [m], friction times the push on it."""
    contact, normal = planes.points, planes.normals
    slide = x[contact] - before[contact]
    slide = slide - (slide * normal).sum(1, keepdims=True) * normal
    length = np.linalg.norm(slide, axis=1, keepdims=True)
    x[contact] -= slide * np.minimum(1.0, grip[:, None] / np.maximum(length, 1e-12))
