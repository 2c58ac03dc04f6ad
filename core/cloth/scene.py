"""The scene of a simulation: cloth and all that acts on it, the operand of every solver and derivative."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ..body.distance import DistanceGrid
from .bending_friction import BendingFriction
from .collision.self_contact import SelfContact
from .fabric import Fabric
from .layers import Layer
from .loads import largest_length
from .pins import Pins
from .settings import STANDARD_GRAVITY, ContactSettings, SettingsBad
from .tangent_planes import TangentPlanes
from .topology import Topology

__all__ = ["Scene", "SteadyRotation"]

HORIZONTAL_AXIS_MASK = np.array([1.0, 0.0, 1.0])
"""Mask of the horizontal components of a vector: y is up."""


@dataclass(frozen=True)
class SteadyRotation:
    """Describe steady rotation of cloth and wearer about a vertical axis through `centre` [m], shape [3], with the
    angular velocity omega = `rate` [rad/s]: the frame's centrifugal acceleration is omega^2 r."""

    rate: float
    centre: tuple[float, float, float]


@dataclass(frozen=True)
class Scene:
    """Describe cloth and what acts on it: all that a drape depends on except its start. `equilibrium`, `settle`, the
    derivatives and the fits take the same scene; it excludes what changes in each of their steps (lagged friction,
    inertia).

    Attributes:
        topology: The mesh with its rest shape.
        fabric: Its fabric; of several garments the outermost's.
        body: Signed distance to the body; for a moving body the tangent planes near the cloth; or None.
        pins: Pinned nodes, or None.
        rotation: For cloth in steady rotation, or None.
        bending_friction: Internal friction of bending, or None.
        gravity: Acceleration [m/s2], shape [3].
        contact: Settings of contact with the body.
        self_contact: Contact with itself, or None: then cloth passes through itself.
        layers: The garments of the mesh, from `stack_garments`; empty for one garment.
    """

    topology: Topology
    fabric: Fabric
    body: DistanceGrid | TangentPlanes | None = None
    pins: Pins | None = None
    rotation: SteadyRotation | None = None
    bending_friction: BendingFriction | None = None
    gravity: tuple[float, float, float] = STANDARD_GRAVITY
    contact: ContactSettings = field(default_factory=ContactSettings)
    self_contact: SelfContact | None = None
    layers: tuple[Layer, ...] = ()

    @cached_property
    def masses(self) -> np.ndarray:
        """Return the lumped mass of each node [kg], shape [node_count]."""
        return self.per_node("density") * self.topology.rest.node_areas

    @property
    def garments(self) -> tuple[Layer, ...]:
        """Return each garment of the mesh with its fabric."""
        whole = slice(None)
        return self.layers or (Layer(self.fabric, whole, whole, whole),)

    @property
    def only_fabric(self) -> Fabric:
        """Return the fabric by which derivatives are taken.

        Raises:
            SettingsBad: where there are several.
        """
        if self.layers:
            raise SettingsBad("derivatives support one garment only; leave the others out.")
        return self.fabric

    def per_node(self, name: str) -> np.ndarray | float:
        """Return a named parameter of the fabric: one number, or for layers one per node, shape [node_count]."""
        if not self.layers:
            return float(getattr(self.fabric, name))
        found = np.zeros(self.topology.node_count)
        for layer in self.layers:
            found[layer.nodes] = getattr(layer.fabric, name)
        return found

    @cached_property
    def mean_weight(self) -> float:
        """Return the mean weight of a node under standard gravity [N]: the unit of residuals."""
        return float(self.masses.mean()) * -STANDARD_GRAVITY[1]

    @property
    def fixed(self) -> np.ndarray:
        """Return which nodes are fixed, shape [node_count]."""
        fixed = np.zeros(self.topology.node_count, dtype=bool)
        if self.pins is not None and self.pins.stiffness is None:
            fixed[self.pins.nodes] = True
        return fixed

    def acceleration(self, nodes: np.ndarray) -> np.ndarray:
        """Compute weight and centrifugal force per mass at nodes [m], both of shape [node_count, 3] [m/s2].

        a = g + omega^2 r,  r the vector from the vertical axis. At rest in the rotating frame there is no Coriolis
        force.
        """
        found = np.tile(np.asarray(self.gravity, dtype=np.float64), (len(nodes), 1))
        if self.rotation is not None:
            found += self.rotation.rate**2 * HORIZONTAL_AXIS_MASK * (nodes - np.asarray(self.rotation.centre))
        return found

    def relative_residual(self, gradient: np.ndarray) -> float:
        """Return the largest force [N] of a gradient, shape [node_count, 3], relative to the mean weight of a node."""
        return float(largest_length(gradient)) / self.mean_weight

    def relative_rms(self, gradient: np.ndarray) -> float:
        """Return the RMS of a gradient [N], [node_count, 3], at nodes that are free, over the mean weight of a node."""
        free = gradient[~self.fixed]
        return float(np.sqrt((free**2).sum(axis=1).mean())) / self.mean_weight if len(free) else 0.0
