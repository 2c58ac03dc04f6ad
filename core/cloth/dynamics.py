"""Cloth in motion: damped implicit Euler steps, for large motions and moving bodies."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..geometry.linear import Solver
from .collision.cloth_friction import ClothFriction
from .collision.collision_free_step import MIN_PAIR_REACH_SHARE
from .collision.coupling import extend_sparsity
from .energy import Energy, Inertia
from .factorisation import factor_regularised
from .friction import lag_friction
from .pins import move_pins
from .quasi_newton import descend, step_with_frozen_pairs
from .scene import Scene
from .settings import SolveSettings


@dataclass(frozen=True)
class ClothState:
    """Describe cloth in motion.

    Attributes:
        nodes: Positions [m], shape [node_count, 3].
        velocities: Velocities [m/s], shape [node_count, 3].
        anchors: Friction's anchor of each node [m], shape [node_count, 3].
        rubbing: The friction of cloth on cloth in the last step, or None.
        folds: Anchor angles of bending friction [rad], shape [hinge_count], or None for the scene's.
    """

    nodes: np.ndarray
    velocities: np.ndarray
    anchors: np.ndarray
    rubbing: ClothFriction | None = None
    folds: np.ndarray | None = None


def take_time_steps(
    scene: Scene,
    nodes: np.ndarray,
    velocities: np.ndarray | None = None,
    *,
    steps: int = 20,
    dt: float = 0.05,
    anchors: np.ndarray | None = None,
    solver: Solver | None = None,
    settings: SolveSettings = SolveSettings(),  # noqa: B008 - frozen
) -> ClothState:
    """Compute `steps` implicit Euler steps of `dt` [s] from nodes [m], [node_count, 3]; see `continue_time_steps`."""
    nodes = np.array(nodes, dtype=np.float64)
    velocities = np.zeros_like(nodes) if velocities is None else np.asarray(velocities, dtype=np.float64)
    state = ClothState(nodes, velocities, nodes.copy() if anchors is None else anchors)
    return continue_time_steps(scene, state, steps=steps, dt=dt, solver=solver, settings=settings)


def continue_time_steps(
    scene: Scene,
    state: ClothState,
    *,
    steps: int = 20,
    dt: float = 0.05,
    solver: Solver | None = None,
    settings: SolveSettings = SolveSettings(),  # noqa: B008 - frozen
) -> ClothState:
    """Compute `steps` implicit Euler steps of `dt` [s] from a state.

    x+ = argmin E(x) + |x - x0 - damping dt v0|_M^2 / (2 dt^2),  v+ = (x+ - x0) / dt (thesis eq. 3.2, solved to
    `newton_per_step` iterations with the PSD Hessian). The body may differ from call to call (one that moves or is
    inflated). Crossed faces of the cloth have no contact while they cross, and are pulled apart.
    """
    energy = Energy(scene)
    for n in range(steps):
        nodes, pinned = state.nodes, move_pins(state.nodes, scene.pins, settings.max_step)
        friction = lag_friction(scene, nodes, state.anchors)
        inertia = Inertia(nodes + settings.damping * dt * state.velocities, 1.0 / dt**2)
        energy = replace(energy, friction=friction, inertia=inertia)
        if energy.push is not None or n == 0:
            energy = energy.contract_crossings(nodes)
        energy = energy.lag_friction(nodes, state.rubbing)
        energy, free = energy.free_share(nodes, pinned - nodes, MIN_PAIR_REACH_SHARE)
        pinned = pinned if free == 1.0 else nodes + free * (pinned - nodes)
        energy, solver, end = _step(energy, solver, pinned, settings)
        state = ClothState(end, (end - nodes) / dt, end if friction is None else friction.slide(end), energy.rubbing)
    return state


def _step(
    energy: Energy, solver: Solver | None, nodes: np.ndarray, settings: SolveSettings
) -> tuple[Energy, Solver | None, np.ndarray]:
    """Compute the Newton iterations of one time step from nodes [m], shape [node_count, 3], with the PSD Hessian. Where
    no pairs are near at the start, the step is checked once, at its end; a pair that came near on the path cuts the
    step there, and the remaining iterations are each checked."""
    left, watching = settings.newton_per_step, energy.watch(nodes)
    if watching.near is not None and not len(watching.near.pairs.kinds):
        path = [nodes]
        frozen, solver = _iterate(watching.freeze(nodes), solver, path, settings, left, False)
        energy, good = frozen.verify_pairs(np.stack(path))
        nodes, left = path[good], (left - good if good < len(path) - 1 else 0)
    path = [nodes]
    energy, solver = _iterate(energy, solver, path, settings, left, True)
    return energy, solver, path[-1]


def _iterate(
    energy: Energy, solver: Solver | None, path: list[np.ndarray], settings: SolveSettings, most: int, verify: bool
) -> tuple[Energy, Solver | None]:
    """Add at most `most` Newton iterations to a path [m], [node_count, 3] each, from its last place."""
    for _ in range(most):
        energy, solver = extend_sparsity(energy, solver, path[-1])
        start, gradient, blocks = energy.hessian(path[-1], False)
        if factor_regularised(energy, solver, path[-1], blocks, 0.0) < 0:
            break
        if verify:
            leg = descend(energy, solver, path[-1], start, gradient, steps=1, residual=0.0, max_step=settings.max_step)
        else:
            leg = step_with_frozen_pairs(energy, solver, path[-1], start, gradient, settings.max_step)
        energy = leg.energy
        path.append(leg.nodes)
        if leg.motion < settings.rest_motion:
            break
    return energy, solver
