"""The whole energy of a cloth: membrane, bending, weight, contact, friction, springs and inertia."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..body import DistanceGrid
from .bending import bending
from .bending_friction import BendingFriction, friction_state
from .contact import contact
from .fabric import Fabric
from .friction import Friction, friction
from .membrane import foresee_stress, membrane
from .pins import Pins
from .settings import GRAVITY, SimulateSettings
from .topology import Topology

_NO_BLOCKS = np.zeros((0, 3, 3))

NO_STRESS = np.zeros((0, 3))
"""Tells `membrane` to take the stress from the positions."""

_LEVEL = np.array([1.0, 0.0, 1.0])
"""Part of a vector that lies level: y is up."""


@dataclass(frozen=True)
class Inertia:
    """Tie nodes to where they would fly: E = weight / 2 sum_v m_v |x_v - target_v|^2.

    Attributes:
        target: Positions [m], shape [node_count, 3].
        weight: 1 / dt^2 [1/s2].
    """

    target: np.ndarray
    weight: float


@dataclass(frozen=True)
class SteadyRotation:
    """Let the cloth turn with its wearer about a vertical axis: in that frame each mass is drawn outwards by omega^2 r.

    Attributes:
        rate: Angular velocity omega [rad/s].
        centre: A point of the axis [m], shape [3].
    """

    rate: float
    centre: tuple[float, float, float]


@dataclass(frozen=True)
class Energy:
    """Give the energy [J] of a cloth in its surroundings, its gradient [N] and its Hessian [N/m].

    Attributes:
        topology: The mesh.
        fabric: What it is made of.
        grid: Signed distance to the body, or None.
        pins: Pinned nodes, or None.
        gravity: Acceleration [m/s2], shape [3].
        settings: Contact parameters.
        friction: Lagged friction, or None.
        inertia: For an implicit time step, or None.
        rotation: For cloth in steady rotation, or None.
        bending_friction: Internal friction of bending, or None.
    """

    topology: Topology
    fabric: Fabric
    grid: DistanceGrid | None = None
    pins: Pins | None = None
    gravity: tuple[float, float, float] = GRAVITY
    settings: SimulateSettings = field(default_factory=SimulateSettings)
    friction: Friction | None = None
    inertia: Inertia | None = None
    rotation: SteadyRotation | None = None
    bending_friction: BendingFriction | None = None

    @property
    def masses(self) -> np.ndarray:
        """Give the lumped mass of each node [kg], shape [node_count]."""
        return self.fabric.density * self.topology.node_areas

    @property
    def _stiffness(self) -> np.ndarray:
        """Give the membrane's four numbers as its kernels take them [N/m]."""
        return np.array([self.fabric.H00, self.fabric.H01, self.fabric.H11, self.fabric.H22])

    @property
    def fixed(self) -> np.ndarray:
        """Tell which nodes are fixed, shape [node_count]."""
        fixed = np.zeros(self.topology.node_count, dtype=bool)
        if self.pins is not None and self.pins.stiffness is None:
            fixed[self.pins.nodes] = True
        return fixed

    def value(self, nodes: np.ndarray) -> float:
        """Give the energy [J] at nodes [m], shape [node_count, 3]."""
        return self._evaluate(nodes, 0, False)[0]

    def gradient(self, nodes: np.ndarray) -> tuple[float, np.ndarray]:
        """Give energy and gradient [N], shape [node_count, 3]; fixed nodes' rows are zero."""
        energy, gradient, _ = self._evaluate(nodes, 1, False)
        gradient[self.fixed] = 0.0
        return energy, gradient

    def hessian(
        self, nodes: np.ndarray, exact: bool = True, stress: np.ndarray | None = None
    ) -> tuple[float, np.ndarray, np.ndarray]:
        """Give energy, gradient and the 3x3 Hessian blocks (upper half, for `Topology.assemble`).

        `exact` False gives a positive semi-definite approximation: for states far from equilibrium. `stress` [N/m],
        shape [face_count, 3], is taken for the membrane's in its geometric part: `foresee_stress` says why.
        """
        energy, gradient, blocks = self._evaluate(nodes, 2, exact, NO_STRESS if stress is None else stress)
        gradient[self.fixed] = 0.0
        return energy, gradient, blocks

    def foresee_stress(self, nodes: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Give the membrane's stress [N/m], shape [face_count, 3], that a step [m] from nodes [m] is to lead to.

        It is linear in the step and so free of the stretch that any straight step along a fold brings.
        """
        return np.asarray(
            foresee_stress(nodes, step, self.topology.faces, self.topology.shape_gradients, self._stiffness)
        )

    def accelerate(self, nodes: np.ndarray) -> np.ndarray:
        """Give weight and centrifugal force of a unit of mass at nodes [m], both of shape [node_count, 3] [m/s2].

        a = g + omega^2 r,  r the vector from the vertical axis. At rest it is g. Coriolis forces vanish at rest in the
        frame that turns.
        """
        found = np.tile(np.asarray(self.gravity, dtype=np.float64), (len(nodes), 1))
        if self.rotation is not None:
            found += self.rotation.rate**2 * _LEVEL * (nodes - np.asarray(self.rotation.centre))
        return found

    def touch(self, nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Give the contact force [N], shape [node_count], and its unit direction, shape [node_count, 3]."""
        count = self.topology.node_count
        force, normal, waste = np.zeros(count), np.zeros((count, 3)), np.zeros((count, 3))
        if self.grid is not None:
            self._contact(nodes, 1, False, waste, _NO_BLOCKS, force, normal)
        return force, normal

    def _contact(self, nodes, order, exact, gradient, blocks, force, normal) -> float:  # type: ignore[no-untyped-def]
        grid, settings, topology = self.grid, self.settings, self.topology
        assert grid is not None
        return float(
            contact(
                nodes,
                grid.coefficients,
                grid.origin,
                grid.spacing,
                grid.offset,
                topology.node_areas,
                settings.contact_stiffness,
                settings.thickness,
                order,
                exact,
                topology.diagonal,
                gradient,
                blocks,
                force,
                normal,
            )
        )

    def _evaluate(
        self, nodes: np.ndarray, order: int, exact: bool, stress: np.ndarray = NO_STRESS
    ) -> tuple[float, np.ndarray, np.ndarray]:
        topology, fabric = self.topology, self.fabric
        nodes = np.ascontiguousarray(nodes, dtype=np.float64)
        gradient = np.zeros_like(nodes)
        blocks = np.zeros((len(topology.block_rows), 3, 3)) if order == 2 else _NO_BLOCKS
        energy = membrane(
            nodes,
            topology.faces,
            topology.shape_gradients,
            topology.areas,
            self._stiffness,
            stress,
            order,
            exact,
            topology.face_slots,
            gradient,
            blocks,
        )
        energy += bending(
            nodes,
            topology.hinges,
            topology.hinge_scale,
            topology.hinge_rest,
            fabric.k,
            *friction_state(topology, self.bending_friction),
            order,
            exact,
            topology.hinge_slots,
            gradient,
            blocks,
        )
        if self.grid is not None:
            waste = np.zeros_like(nodes)
            energy += self._contact(nodes, order, exact, gradient, blocks, np.zeros(len(nodes)), waste)
        if self.friction is not None:
            f = self.friction
            energy += friction(
                nodes, f.anchors, f.normals, f.limits, f.slip, order, topology.diagonal, gradient, blocks
            )
        energy += self._add_loads(nodes, order, exact, gradient, blocks)
        return float(energy), gradient, blocks

    def _add_loads(self, nodes: np.ndarray, order: int, exact: bool, gradient: np.ndarray, blocks: np.ndarray) -> float:
        """Add weight, rotation, inertia and springs: linear or quadratic. The PSD form drops the rotation's."""
        masses, gravity = self.masses, np.asarray(self.gravity, dtype=np.float64)
        energy = -float(masses @ (nodes @ gravity))
        gradient -= masses[:, None] * self.accelerate(nodes)
        diagonal = self.topology.diagonal
        if self.rotation is not None:
            outward = _LEVEL * (nodes - np.asarray(self.rotation.centre))
            energy -= 0.5 * self.rotation.rate**2 * float(masses @ (outward**2).sum(1))
            if order == 2 and exact:
                blocks[diagonal] -= self.rotation.rate**2 * masses[:, None, None] * np.diag(_LEVEL)
        if self.inertia is not None:
            stiffness = (self.inertia.weight * masses)[:, None]
            away = nodes - self.inertia.target
            energy += 0.5 * float((stiffness * away**2).sum())
            gradient += stiffness * away
            if order == 2:
                blocks[diagonal] += stiffness[:, :, None] * np.eye(3)
        if self.pins is not None and self.pins.stiffness is not None:
            held, weights = self.pins.nodes, self.pins.stiffness * np.array(self.pins.directions)
            away = nodes[held] - self.pins.points
            energy += 0.5 * float((weights * away**2).sum())
            np.add.at(gradient, held, weights * away)
            if order == 2:
                np.add.at(blocks, diagonal[held], np.diag(weights))
        return energy
