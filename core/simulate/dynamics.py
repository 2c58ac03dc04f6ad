"""Let cloth move: damped implicit Euler steps, for large motions and bodies that move."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..body import DistanceGrid
from .energy import Energy, Inertia
from .fabric import Fabric
from .friction import Friction
from .newton import newton_step
from .pins import Pins
from .settings import GRAVITY, SimulateSettings
from .solver import Solver, make_solver
from .topology import Topology


@dataclass(frozen=True)
class State:
    """Hold cloth in motion.

    Attributes:
        nodes: Positions [m], shape [node_count, 3].
        velocities: Velocities [m/s], shape [node_count, 3].
        anchors: Where friction holds each node [m], shape [node_count, 3].
    """

    nodes: np.ndarray
    velocities: np.ndarray
    anchors: np.ndarray


def settle(
    topology: Topology,
    fabric: Fabric,
    nodes: np.ndarray,
    velocities: np.ndarray | None = None,
    *,
    grid: DistanceGrid | None = None,
    pins: Pins | None = None,
    gravity: bool | tuple[float, float, float] = True,
    steps: int = 20,
    dt: float = 0.05,
    settings: SimulateSettings = SimulateSettings(),  # noqa: B008 - frozen
    anchors: np.ndarray | None = None,
    solver: Solver | None = None,
) -> State:
    """Take `steps` implicit Euler steps of `dt` [s] from nodes [m], shape [node_count, 3].

    x+ = argmin E(x) + |x - x0 - damping dt v0|_M^2 / (2 dt^2),  v+ = (x+ - x0) / dt (thesis eq. 3.2, solved to
    `newton_per_step` iterations with the PSD Hessian). Pass the state's velocities and anchors on to continue; the grid
    may differ from call to call (a body that moves or is inflated). `gravity`: True, False or a vector [m/s2].
    """
    pull = GRAVITY if gravity is True else (0.0, 0.0, 0.0) if gravity is False else gravity
    nodes = np.array(nodes, dtype=np.float64)
    velocities = np.zeros_like(nodes) if velocities is None else np.asarray(velocities, dtype=np.float64)
    anchors = nodes.copy() if anchors is None else anchors
    solver = solver or make_solver(topology)
    base = Energy(topology, fabric, grid, pins, pull, settings)
    for _ in range(steps):
        start = nodes
        friction = lag_friction(base, nodes, anchors)
        inertia = Inertia(nodes + settings.damping * dt * velocities, 1.0 / dt**2)
        energy = replace(base, friction=friction, inertia=inertia)
        nodes = move_pins(nodes, pins, settings.max_step)
        for _ in range(settings.newton_per_step):
            step = newton_step(energy, solver, nodes)
            nodes = step.nodes
            if step.motion < settings.still:
                break
        velocities = (nodes - start) / dt
        anchors = nodes if friction is None else friction.slide(nodes)
    return State(nodes, velocities, anchors)


def lag_friction(energy: Energy, nodes: np.ndarray, anchors: np.ndarray) -> Friction | None:
    """Give the friction that follows from the contact forces at `nodes`, or None where there is none."""
    if energy.grid is None or not energy.settings.friction or energy.fabric.friction <= 0:
        return None
    force, normals = energy.touch(nodes)
    return Friction(anchors, normals, energy.fabric.friction * force, energy.settings.slip)


def move_pins(nodes: np.ndarray, pins: Pins | None, max_step: float) -> np.ndarray:
    """Move fixed nodes towards where they are held, at most `max_step` [m]."""
    if pins is None or pins.stiffness is not None:
        return nodes
    nodes = nodes.copy()
    way = np.asarray(pins.points) - nodes[pins.nodes]
    length = np.linalg.norm(way, axis=1, keepdims=True)
    nodes[pins.nodes] += way * np.minimum(1.0, max_step / np.maximum(length, 1e-300))
    return nodes
