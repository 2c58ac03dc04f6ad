"""Let cloth move: damped implicit Euler steps, for large motions and bodies that move."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .energy import Energy, Inertia
from .factorisation import factor_regularised
from .friction import lag_friction
from .pins import move_pins
from .quasi_newton import descend
from .scene import Scene
from .settings import SolveSettings
from .solver import Solver, make_solver


@dataclass(frozen=True)
class State:
    """Describe cloth in motion.

    Attributes:
        nodes: Positions [m], shape [node_count, 3].
        velocities: Velocities [m/s], shape [node_count, 3].
        anchors: Where friction holds each node [m], shape [node_count, 3].
    """

    nodes: np.ndarray
    velocities: np.ndarray
    anchors: np.ndarray


def settle(
    scene: Scene,
    nodes: np.ndarray,
    velocities: np.ndarray | None = None,
    *,
    steps: int = 20,
    dt: float = 0.05,
    anchors: np.ndarray | None = None,
    solver: Solver | None = None,
    settings: SolveSettings = SolveSettings(),  # noqa: B008 - frozen
) -> State:
    """Take `steps` implicit Euler steps of `dt` [s] from nodes [m], shape [node_count, 3].

    x+ = argmin E(x) + |x - x0 - damping dt v0|_M^2 / (2 dt^2),  v+ = (x+ - x0) / dt (thesis eq. 3.2, solved to
    `newton_per_step` iterations with the PSD Hessian). Pass the state's velocities and anchors on to continue; the body
    may differ from call to call (one that moves or is inflated).
    """
    nodes = np.array(nodes, dtype=np.float64)
    velocities = np.zeros_like(nodes) if velocities is None else np.asarray(velocities, dtype=np.float64)
    anchors = nodes.copy() if anchors is None else anchors
    solver = solver or make_solver(scene.topology.pattern)
    for _ in range(steps):
        start = nodes
        friction = lag_friction(scene, nodes, anchors)
        inertia = Inertia(nodes + settings.damping * dt * velocities, 1.0 / dt**2)
        pinned = move_pins(nodes, scene.pins, settings.max_step)
        nodes = _step(Energy(scene, friction, inertia), solver, pinned, settings)
        velocities = (nodes - start) / dt
        anchors = nodes if friction is None else friction.slide(nodes)
    return State(nodes, velocities, anchors)


def _step(energy: Energy, solver: Solver, nodes: np.ndarray, settings: SolveSettings) -> np.ndarray:
    """Take the Newton iterations of one time step from nodes [m], shape [node_count, 3], with the PSD Hessian."""
    for _ in range(settings.newton_per_step):
        start, gradient, blocks = energy.hessian(nodes, False)
        if factor_regularised(energy, solver, nodes, blocks, 0.0) < 0:
            break
        leg = descend(energy, solver, nodes, start, gradient, steps=1, residual=0.0, max_step=settings.max_step)
        nodes = leg.nodes
        if leg.motion < settings.still:
            break
    return nodes
