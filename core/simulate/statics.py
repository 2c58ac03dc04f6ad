"""Bring cloth to its quasi-static equilibrium by Newton's method (numerics 1)."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np

from ..body import DistanceGrid
from ..errors import BadInput
from ..hooks import SILENT, Hooks
from .dynamics import bring_to_hold, lag_friction
from .energy import Energy
from .fabric import Fabric
from .hold import Hold
from .newton import Step, newton_step, relative_residual
from .settings import GRAVITY, SimulateSettings
from .solver import Solver, make_solver
from .topology import Topology

MESSAGES = {
    "converged": "at rest: all forces are balanced.",
    "still": "at rest to the eye, forces not fully balanced: set still to 0 for more.",
    "stuck": "no step lowers the energy: settle for longer first, or soften contact.",
    "iterations": "not at rest: raise max_iterations, settle for longer first, or hold a contour that slides.",
    "time": "not at rest: raise max_cpu_seconds or take fewer vertices.",
}
"""Advice for each way in which the search for an equilibrium ends."""


class NodesBad(BadInput):
    """The cloth's nodes are not finite numbers, one row for each node of the mesh."""

    code = "simulate.nodes_bad"


@dataclass(frozen=True)
class Drape:
    """Hold cloth at rest, or as near to it as was reached.

    Attributes:
        nodes: Positions [m], shape [node_count, 3].
        residual: Largest force on a node, relative to the mean weight of a node.
        iterations: Newton iterations.
        converged: True where the residual is within the tolerance or nothing moves any more.
        energy: Energy at the end [J].
        outcome: Key of `MESSAGES`.
        message: What that means and what to do.
        anchors: Where friction holds each node [m], shape [node_count, 3].
    """

    nodes: np.ndarray
    residual: float
    iterations: int
    converged: bool
    energy: float
    outcome: str
    message: str
    anchors: np.ndarray


def equilibrium(
    topology: Topology,
    fabric: Fabric,
    nodes: np.ndarray,
    *,
    grid: DistanceGrid | None = None,
    hold: Hold | None = None,
    gravity: tuple[float, float, float] = GRAVITY,
    settings: SimulateSettings = SimulateSettings(),  # noqa: B008 - frozen
    hooks: Hooks = SILENT,
    anchors: np.ndarray | None = None,
    solver: Solver | None = None,
) -> Drape:
    """Find positions at which no force is left on any node, from nodes [m], shape [node_count, 3].

    Newton on dE/dx = 0 with a line search on E. The PSD Hessian far away (steps over 1 cm), then as much of the exact
    one as is positive definite, which makes the last iterations quadratic. Friction's normal forces are taken from
    the current positions in every iteration until the cloth is nearly at rest, and then frozen.

    Raises:
        NodesBad: where the nodes do not fit the mesh or are not finite.
    """
    nodes = np.array(nodes, dtype=np.float64)
    if nodes.shape != (topology.node_count, 3) or not np.isfinite(nodes).all():
        raise NodesBad()
    anchors = nodes.copy() if anchors is None else anchors
    solver = solver or make_solver(topology)
    energy = Energy(topology, fabric, grid, hold, gravity, settings)
    started, share, calm = time.process_time(), 0.0, 0
    outcome, done, lagging = "iterations", 0, True
    for done in range(settings.max_iterations + 1):
        hooks.check()
        held = bring_to_hold(nodes, hold, settings.max_step)
        moved_hold, nodes = float(np.abs(held - nodes).max()), held
        if lagging:
            energy = replace(energy, friction=lag_friction(energy, nodes, anchors))
        step = newton_step(energy, solver, nodes, share)
        if step.residual <= settings.tolerance and moved_hold == 0:
            outcome = "converged"
            break
        if done == settings.max_iterations:
            break
        nodes = step.nodes
        lagging = lagging and step.motion > 1e-3
        calm = calm + 1 if step.motion < settings.still and moved_hold == 0 else 0
        if step.motion == 0 and moved_hold == 0 and step.share == 0:
            outcome = "stuck"
            break
        if calm >= 3:
            outcome = "still"
            break
        if settings.max_cpu_seconds is not None and time.process_time() - started > settings.max_cpu_seconds:
            outcome = "time"
            break
        share = _choose_share(step, share)
    end, gradient = energy.gradient(nodes)
    residual = relative_residual(energy, gradient)
    slid = anchors if energy.friction is None else energy.friction.slide(nodes)
    converged = outcome in ("converged", "still")
    return Drape(nodes, residual, done, converged, end, outcome, MESSAGES[outcome], slid)


def _choose_share(step: Step, asked: float) -> float:
    """Choose how much of the exact Hessian to try next: none beyond 1 cm of motion, then a quarter more each time."""
    if step.motion > 1e-2 or step.motion == 0:
        return 0.0
    return min(1.0, max(1.25 * step.share, 0.3)) if step.share == asked else step.share
