"""Total energy of a cloth: membrane, bending, weight, contact, friction, springs and inertia."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .bending import bending
from .bending_friction import FoldFriction
from .block_pattern import Derivatives
from .collision.barrier import barrier, find_coincident_nodes
from .collision.cloth_friction import ClothFriction, cloth_friction, lag_cloth_friction
from .collision.near_pairs import NearPairs, find_near_pairs
from .collision.path_check import verify_pairs_on_path
from .collision.untangle import contract_crossings
from .contact import NO_BLOCKS, Forces, NodeElements, add_contact
from .friction import Friction, friction
from .loads import largest_length, loads
from .membrane import membrane, predict_stress
from .scene import HORIZONTAL_AXIS_MASK, Scene

NO_STRESS = np.zeros((0, 3))
"""Argument of `membrane` for the stress of the positions [N/m]."""


NO_INERTIA_TARGET = np.zeros((0, 3))
"""Target positions of inertia where there is none [m], shape [0, 3]."""

NO_SLOTS = np.zeros((0, 10), dtype=np.int64)
"""Indices of the slots of pairs of a kernel call of order 0 or 1."""


@dataclass(frozen=True)
class Inertia:
    """Describe inertia: E = weight / 2 sum_v m_v |x_v - target_v|^2, `target` positions [m], shape [node_count, 3], and
    `weight` 1 / dt^2 [1/s2]."""

    target: np.ndarray
    weight: float

    @property
    def as_taken(self) -> tuple[np.ndarray, float]:
        """Return both as the kernel takes them."""
        return np.ascontiguousarray(self.target, dtype=np.float64), float(self.weight)


@dataclass(frozen=True)
class Energy:
    """Compute the energy [J] of a scene, its gradient [N] and its Hessian [N/m].

    Attributes:
        scene: The cloth and what acts on it.
        friction: Lagged friction, or None.
        inertia: For an implicit time step, or None.
        rubbing: Lagged friction of cloth on cloth, or None.
        push: A constant force on each node [N], shape [node_count, 3], or None.
        near: The pairs found by the last search, which only saves another one.
    """

    scene: Scene
    friction: Friction | None = None
    inertia: Inertia | None = None
    rubbing: ClothFriction | None = None
    push: np.ndarray | None = None
    near: NearPairs | None = None

    def watch(self, nodes: np.ndarray, end: np.ndarray | None = None) -> Energy:
        """Return the same energy with the pairs that may touch at nodes [m] and on the path to `end` [m]."""
        cloth, near = self.scene.self_contact, self.near
        if cloth is None or (near is not None and near.frozen):
            return self
        if near is not None and near.covers(nodes) and (end is None or near.covers(end)):
            return self
        if end is not None and largest_length(end - nodes) <= cloth.margin:
            end = None
        if near is not None and end is None:
            return replace(self, near=verify_pairs_on_path(cloth, nodes[None], near)[0])
        return replace(self, near=find_near_pairs(cloth, nodes, end))

    def free_share(self, nodes: np.ndarray, step: np.ndarray, least: float = 0.0) -> tuple[Energy, float]:
        """Return the largest share, 0 to 1, of a step [m] from nodes [m] without collision, both [node_count, 3]. Also
        returns the energy with the pairs along the step. No pair comes nearer than `least` times its reach."""
        if self.scene.self_contact is None:
            return self, 1.0
        watching = self.watch(nodes, nodes + step)
        assert watching.near is not None
        return watching, watching.near.free_share(nodes, step, least)

    def freeze(self, nodes: np.ndarray) -> Energy:
        """Return the same energy with the pairs near nodes [m], shape [node_count, 3], and no others anywhere. It is
        valid as long as no other pair comes within reach, which `verify_pairs_on_path` checks."""
        watching = self.watch(nodes)
        return self if watching.near is None else replace(watching, near=replace(watching.near, frozen=True))

    def verify_pairs(self, path: np.ndarray) -> tuple[Energy, int]:
        """Return the last place of a path [m], [place_count, node_count, 3], up to which no other than the known pairs
        came near: its number, 0 to place_count - 1, and the energy with the pairs near it and those that came near
        after it."""
        if self.scene.self_contact is None or self.near is None:
            return self, len(path) - 1
        near, good = verify_pairs_on_path(self.scene.self_contact, path, self.near)
        return replace(self, near=near), good

    def contract_crossings(self, nodes: np.ndarray) -> Energy:
        """Return the same energy with contact off where faces cross at nodes [m], and forces that pull them apart."""
        scene, push = contract_crossings(self.scene, nodes)
        return replace(self, scene=scene, push=push, near=self.near if scene is self.scene else None)

    def suspend_coincident(self, nodes: np.ndarray) -> Energy:
        """Return the same energy with contact also off around coincident pairs at nodes [m]."""
        watching = self.watch(nodes)
        cloth, near = watching.scene.self_contact, watching.near
        if cloth is None or near is None:
            return self
        is_coincident = find_coincident_nodes(nodes, near.pairs)
        if not len(is_coincident):
            return watching
        waiting = cloth.wait(np.flatnonzero(cloth.crossed | np.isin(cloth.faces, is_coincident).any(axis=1)))
        return replace(watching, scene=replace(watching.scene, self_contact=waiting), near=None)

    def lag_friction(self, nodes: np.ndarray, before: ClothFriction | None = None) -> Energy:
        """Return the same energy with the friction of cloth on cloth at nodes [m], [node_count, 3]. Pairs that are also
        in `before`, the friction until then, keep their displacement."""
        watching = self.watch(nodes)
        if self.scene.self_contact is None or watching.near is None:
            return self
        return replace(watching, rubbing=lag_cloth_friction(self.scene.self_contact, watching.near, nodes, before))

    def value(self, nodes: np.ndarray) -> float:
        """Return the energy [J] at nodes [m], shape [node_count, 3]."""
        return self._evaluate(nodes, 0, False)[0]

    def gradient(self, nodes: np.ndarray) -> tuple[float, np.ndarray]:
        """Compute energy and gradient [N], shape [node_count, 3]; fixed nodes' rows are zero."""
        energy, gradient, _ = self._evaluate(nodes, 1, False)
        gradient[self.scene.fixed] = 0.0
        return energy, gradient

    def hessian(
        self, nodes: np.ndarray, exact: bool = True, stress: np.ndarray | None = None
    ) -> tuple[float, np.ndarray, np.ndarray]:
        """Compute energy, gradient and the 3x3 Hessian blocks (upper half, for `Topology.assemble`). `exact` False
        gives a positive semi-definite approximation, for states far from equilibrium. Pairs in contact that the matrix
        has no place for add diagonal blocks; `couple` extends the matrix. `stress` [N/m], shape [face_count, 3],
        replaces the membrane's stress in the geometric part; see `predict_stress`."""
        energy, gradient, blocks = self._evaluate(nodes, 2, exact, NO_STRESS if stress is None else stress)
        gradient[self.scene.fixed] = 0.0
        return energy, gradient, blocks

    def predict_stress(self, nodes: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Compute the membrane's stress [N/m], shape [face_count, 3], after a step [m] from nodes [m], linear in the
        step. It is free of the stretch that any straight step along a fold adds."""
        topology, found = self.scene.topology, []
        for layer in self.scene.garments:
            faces, shape, _, _ = layer.membrane_of(topology)
            found.append(predict_stress(nodes, step, faces, shape, layer.stiffness))
        return np.concatenate(found)

    def _evaluate(
        self, nodes: np.ndarray, order: int, exact: bool, stress: np.ndarray = NO_STRESS
    ) -> tuple[float, np.ndarray, np.ndarray]:
        scene = self.scene
        topology = scene.topology
        nodes = np.ascontiguousarray(nodes, dtype=np.float64)
        blocks = np.zeros((len(topology.pattern.rows), 3, 3)) if order == 2 else NO_BLOCKS
        found = Derivatives(np.zeros_like(nodes), blocks)
        energy, folds = 0.0, FoldFriction.of(topology, scene.bending_friction)
        for layer in scene.garments:
            layer_stress = stress[layer.faces] if len(stress) else stress
            faces, hinges = layer.membrane_of(topology), layer.bending_of(topology)
            energy += membrane(nodes, faces, layer.stiffness, layer_stress, order, exact, found)
            energy += bending(nodes, hinges, layer.fabric.k, folds.among(layer.hinges), order, exact, found)
        diagonal = topology.pattern.diagonal
        if scene.body is not None:
            elements, forces = NodeElements(topology.rest.node_areas, diagonal), Forces.none(len(nodes))
            energy += add_contact(nodes, scene, elements, (order, exact), found, forces)
        if self.friction is not None:
            energy += friction(nodes, self.friction, order, diagonal, found)
        if scene.self_contact is not None:
            energy += self._add_self_contact(nodes, order, exact, found)
        energy += self._add_loads(nodes, order, exact, *found)
        return float(energy), *found

    def _add_self_contact(self, nodes: np.ndarray, order: int, exact: bool, found: Derivatives) -> float:
        """Add the contact of cloth with cloth; pairs that the matrix has no place for add diagonal blocks."""
        cloth, near = self.scene.self_contact, self.watch(nodes).near
        assert cloth is not None and near is not None
        if self.rubbing is None and not len(near.keys):
            return 0.0
        pattern, pairs = self.scene.topology.pattern, near.pairs
        slots = NO_SLOTS
        if order == 2:
            pairs = near.within(nodes, 0.0)
            slots = pattern.find_slots(pairs.nodes)
        energy = 0.0
        if len(pairs.kinds):
            places, stiffness = (slots, pattern.diagonal), float(cloth.settings.stiffness)
            energy += barrier(nodes, pairs, stiffness, places, order, exact, found)
        if self.rubbing is not None:
            slots = pattern.find_slots(self.rubbing.keys[:, 1:]) if order == 2 else NO_SLOTS
            energy += cloth_friction(nodes, self.rubbing.elements, (slots, pattern.diagonal), order, found)
        return energy

    def _add_loads(self, nodes: np.ndarray, order: int, exact: bool, gradient: np.ndarray, blocks: np.ndarray) -> float:
        """Add weight, rotation, inertia and springs: linear or quadratic. The PSD form drops the rotation's Hessian."""
        scene, tied = self.scene, (NO_INERTIA_TARGET, 0.0) if self.inertia is None else self.inertia.as_taken
        masses, diagonal = scene.masses, scene.topology.pattern.diagonal
        found = Derivatives(gradient, blocks)
        energy = float(loads(nodes, masses, np.asarray(scene.gravity, dtype=float), tied, order, diagonal, found))
        if self.push is not None:
            energy -= float((self.push * nodes).sum())
            gradient -= self.push
        if scene.rotation is not None:
            outward = HORIZONTAL_AXIS_MASK * (nodes - np.asarray(scene.rotation.centre))
            energy -= 0.5 * scene.rotation.rate**2 * float(masses @ (outward**2).sum(1))
            gradient -= scene.rotation.rate**2 * masses[:, None] * outward
            if order == 2 and exact:
                blocks[diagonal] -= scene.rotation.rate**2 * masses[:, None, None] * np.diag(HORIZONTAL_AXIS_MASK)
        if scene.pins is not None and scene.pins.stiffness is not None:
            pinned, weights = scene.pins.nodes, scene.pins.stiffness * np.array(scene.pins.directions)
            offset = nodes[pinned] - scene.pins.points
            energy += 0.5 * float((weights * offset**2).sum())
            np.add.at(gradient, pinned, weights * offset)
            if order == 2:
                np.add.at(blocks, diagonal[pinned], np.diag(weights))
        return energy
