"""Bring cloth to its quasi-static equilibrium by quasi-Newton descent (numerics 1)."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..body import DistanceGrid
from ..errors import BadInput
from ..hooks import SILENT, Hooks
from .bending_friction import BendingFriction
from .dynamics import lag_friction, move_pins
from .energy import Energy, SteadyRotation
from .fabric import Fabric
from .newton import factor_blend, relative_residual
from .pins import Pins
from .quasi_newton import descend
from .settings import GRAVITY, SimulateSettings
from .solver import Solver, make_solver
from .topology import Topology

MESSAGES = {
    "converged": "at rest: all forces are balanced.",
    "still": "at rest to the eye, forces not fully balanced: set still to 0 for more.",
    "stuck": "no step lowers the energy: settle for longer first, or soften contact.",
    "iterations": "not at rest: raise max_iterations, settle for longer first, or hold a contour that slides.",
    "time": "not at rest: raise max_cpu_seconds or take fewer vertices.",
    "left": "not at rest: the search was left off by the caller.",
}
"""Advice for each way in which the search for an equilibrium ends."""

_SETTLED = 1e-5
"""Motion in a leg under which friction's normal forces stay as they are [m]: their change moves nothing that counts."""

_CHASE = 6
"""Legs without a tenth less motion than the least before, after which friction's normal forces stay as they are. Where
cloth is caught in a crease of the body they and the cloth chase each other round for ever, by half a millimetre to two;
drapes that come to rest by themselves slow down by a tenth every few legs. Twelve took trousers 3 to 9 legs longer
each time they were draped, and the fit's misfit was the same to 0.04 mm.
"""


class NodesBad(BadInput):
    """The cloth's nodes are not finite numbers, one row for each node of the mesh."""

    code = "simulate.nodes_bad"


@dataclass(frozen=True)
class Drape:
    """Hold cloth at rest, or as near to it as was reached.

    Attributes:
        nodes: Positions [m], shape [node_count, 3].
        residual: Largest force on a node, relative to the mean weight of a node.
        iterations: Matrices factored; each serves `SimulateSettings.steps_per_factor` steps.
        converged: True where the residual is within the tolerance or nothing moves any more.
        energy: Energy at the end [J].
        outcome: Key of `MESSAGES`.
        message: What that means and what to do.
        anchors: Where friction holds each node [m], shape [node_count, 3].
        rotation: The rotation in which it rests, or None for cloth at rest under its weight alone.
    """

    nodes: np.ndarray
    residual: float
    iterations: int
    converged: bool
    energy: float
    outcome: str
    message: str
    anchors: np.ndarray
    rotation: SteadyRotation | None = None


def equilibrium(
    topology: Topology,
    fabric: Fabric,
    nodes: np.ndarray,
    *,
    grid: DistanceGrid | None = None,
    pins: Pins | None = None,
    gravity: tuple[float, float, float] = GRAVITY,
    settings: SimulateSettings = SimulateSettings(),  # noqa: B008 - frozen
    hooks: Hooks = SILENT,
    anchors: np.ndarray | None = None,
    solver: Solver | None = None,
    rotation: SteadyRotation | None = None,
    leave: Callable[[int, np.ndarray], bool] | None = None,
    bending_friction: BendingFriction | None = None,
) -> Drape:
    """Find positions at which no force is left on any node, from nodes [m], shape [node_count, 3].

    Descent on E in legs: factor the PSD Hessian, then a few quasi-Newton steps from it (`descend`). Friction's normal
    forces are taken anew before each leg, so that at rest they are those of where the cloth rests; only where that
    makes the cloth creep on by less than `_SETTLED` a leg, or where the two chase each other for `_CHASE` legs, are
    they left as they are. With `bending_friction` folds stay where they are until more than the yarns' friction
    bends them. `leave` is asked after each leg, with how many there were and the nodes, whether to leave off.

    **Deviation** from numerics 1 (Newton with the exact Hessian): see `docs/adr`, "Descend by quasi-Newton steps".

    Raises:
        NodesBad: where the nodes do not fit the mesh or are not finite.
    """
    nodes = np.array(nodes, dtype=np.float64)
    if nodes.shape != (topology.node_count, 3) or not np.isfinite(nodes).all():
        raise NodesBad()
    anchors = nodes.copy() if anchors is None else anchors
    solver = solver or make_solver(topology)
    energy = Energy(
        topology, fabric, grid, pins, gravity, settings, rotation=rotation, bending_friction=bending_friction
    )
    started, calm, outcome, done, lagging = time.process_time(), 0, "iterations", 0, True
    least, since = np.inf, 0
    for done in range(settings.max_iterations + 1):
        hooks.check()
        held = move_pins(nodes, pins, settings.max_step)
        arrived, nodes = bool((held == nodes).all()), held
        if lagging:
            energy = replace(energy, friction=lag_friction(energy, nodes, anchors))
        start, gradient, blocks = energy.hessian(nodes, False)
        if relative_residual(energy, gradient) <= settings.tolerance and arrived:
            outcome = "converged"
            break
        if done == settings.max_iterations:
            break
        if factor_blend(energy, solver, nodes, blocks, 0.0) < 0:
            outcome = "stuck"
            break
        leg = descend(
            energy, solver, nodes, start, gradient, steps=settings.steps_per_factor, residual=settings.tolerance
        )
        nodes = leg.nodes
        least, since = (leg.motion, 0) if leg.motion < 0.9 * least else (least, since + 1)
        lagging = lagging and leg.motion > _SETTLED and since < _CHASE
        calm = calm + 1 if leg.motion < settings.still and arrived else 0
        if leg.steps == 0 and arrived:
            outcome = "stuck"
            break
        if calm >= 3:
            outcome = "still"
            break
        if leave is not None and leave(done + 1, nodes):
            outcome = "left"
            break
        if settings.max_cpu_seconds is not None and time.process_time() - started > settings.max_cpu_seconds:
            outcome = "time"
            break
    end, gradient = energy.gradient(nodes)
    slid = anchors if energy.friction is None else energy.friction.slide(nodes)
    residual, converged = relative_residual(energy, gradient), outcome in ("converged", "still")
    return Drape(nodes, residual, done, converged, end, outcome, MESSAGES[outcome], slid, rotation)
