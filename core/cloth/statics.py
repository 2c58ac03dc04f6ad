"""Solve for the quasi-static equilibrium of cloth by quasi-Newton descent."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from ..geometry.linear import Solver
from ..run.errors import BadInput
from ..run.hooks import SILENT_HOOKS, Hooks
from .collision.cloth_friction import ClothFriction
from .collision.collision_free_step import MIN_PAIR_REACH_SHARE
from .collision.coupling import extend_sparsity
from .collision.untangle import is_resolving
from .energy import Energy, Inertia
from .factorisation import factor_regularised
from .friction import lag_friction
from .outcome import Outcome
from .pins import move_pins
from .quasi_newton import LbfgsRun, descend
from .scene import Scene, SteadyRotation
from .settings import MAX_REST_RESIDUAL, SolveSettings

__all__ = ["Drape", "NodesBad", "equilibrium"]

StopCallback = Callable[[int, np.ndarray], bool]
"""Called after each run with the number of runs and the nodes [m]; True stops the search."""

_FRICTION_FREEZE_MOTION = 1e-5
"""Motion in a run below which friction's normal forces stay constant [m]: their change is negligible."""

_FRICTION_FREEZE_RUNS = 6
"""Number of runs without a motion a tenth below the smallest so far, after which friction's normal forces stay
constant. Where cloth is caught in a crease of the body these and the cloth keep each other in motion without end, by
0.5 to 2 mm; the motion of drapes that come to rest by themselves falls by a tenth every few runs. With twelve, trousers
took 3 to 9 runs longer in each drape, and the fit's misfit was the same to 0.04 mm."""


_UNTANGLE_PATIENCE_ITERATIONS = 6
"""Number of untangling iterations without fewer crossed faces, after which contact is off for those left. Trousers that
started with 155 and 331 crossed faces ended with 4 and 11 at 6 to 8 (0.2 s an iteration), with 16 at 4."""

_UNTANGLE_TIME_STEP = 0.05
"""Length of a time step of untangling [s], as that of `take_time_steps`. Half of it took as many iterations."""


class NodesBad(BadInput):
    """The cloth's nodes are not finite numbers, one row for each node of the mesh."""

    code = "simulate.nodes_bad"


@dataclass(frozen=True)
class Drape:
    """Describe cloth at rest, or as near to rest as the search came.

    Attributes:
        nodes: Positions [m], shape [node_count, 3].
        residual: Largest force on a node, relative to the mean weight of a node.
        iterations: Matrices factored before the last run; each serves `SolveSettings.steps_per_factor` steps.
        energy: Energy at the end [J].
        anchors: Friction's anchor of each node [m], shape [node_count, 3].
        rotation: The rotation in which it rests, or None for cloth at rest under its weight alone.
        rubbing: The friction of cloth on cloth in which it rests, or None.
        residual_rms: Root mean square of the forces on the nodes that are not fixed, in the same unit; None: not known.
    """

    nodes: np.ndarray
    residual: float
    iterations: int
    energy: float
    outcome: Outcome
    anchors: np.ndarray
    rotation: SteadyRotation | None = None
    rubbing: ClothFriction | None = None
    residual_rms: float | None = None

    @property
    def converged(self) -> bool:
        """Return whether the search ended by itself: with balanced forces, or because nothing moved any more. Stuck
        cloth does not move either, whatever forces are left on it, so this does not mean rest. The fits choose
        equilibria by it; delivered drapes are judged by `at_rest`."""
        return self.outcome.converged

    @property
    def at_rest(self) -> bool:
        """Return whether the search ended by itself and no node's force exceeds `MAX_REST_RESIDUAL` node weights."""
        return self.outcome.converged and self.residual <= MAX_REST_RESIDUAL

    @property
    def advice(self) -> str:
        """Return the outcome's advice, or that for cloth that is stuck under a force."""
        if not self.converged or self.at_rest:
            return self.outcome.advice
        return (
            f"not at rest: nothing moves any more, but {self.residual:.3g} node weights are left on a node; it is "
            "stuck: drape with more vertices, or from another start."
        )

    def measure(self, name: str) -> dict[str, float | None]:
        """Return metrics of the rest: `NAME.residual` and `.residual_rms` [node weights], `.iterations`, `.at_rest`."""
        return {
            f"{name}.residual": self.residual,
            f"{name}.residual_rms": self.residual_rms,
            f"{name}.iterations": float(self.iterations),
            f"{name}.at_rest": float(self.at_rest),
        }


@dataclass
class _Progress:
    """Track a search for an equilibrium run by run, and decide when it ends.

    Attributes:
        legs: Runs after which it continued.
        follows: Whether friction's normal forces are still updated.
        rest_count: Consecutive runs in which nothing moved.
        least: Smallest motion of a run so far [m].
        since: Runs since that fell by a tenth.
        started: CPU time at the start [s].
    """

    settings: SolveSettings
    stop: StopCallback | None
    legs: int = 0
    follows: bool = True
    rest_count: int = 0
    least: float = np.inf
    since: int = 0
    started: float = field(default_factory=time.process_time)

    def judge(self, leg: LbfgsRun, arrived: bool) -> Outcome | None:
        """Return the outcome if the search ends with this run, else None; `arrived`: all pins are at their points."""
        self.least, self.since = (leg.motion, 0) if leg.motion < 0.9 * self.least else (self.least, self.since + 1)
        self.follows = self.follows and leg.motion > _FRICTION_FREEZE_MOTION and self.since < _FRICTION_FREEZE_RUNS
        self.rest_count = self.rest_count + 1 if leg.motion < self.settings.rest_motion and arrived else 0
        if leg.steps == 0 and arrived:
            return Outcome.STUCK
        if self.rest_count >= 3:
            return Outcome.STILL
        if self.stop is not None and self.stop(self.legs + 1, leg.nodes):
            return Outcome.STOPPED
        limit = self.settings.max_cpu_seconds
        if limit is not None and time.process_time() - self.started > limit:
            return Outcome.TIME
        self.legs += 1
        return None


def equilibrium(
    scene: Scene,
    nodes: np.ndarray,
    *,
    anchors: np.ndarray | None = None,
    solver: Solver | None = None,
    settings: SolveSettings = SolveSettings(),  # noqa: B008 - frozen
    hooks: Hooks = SILENT_HOOKS,
    stop: StopCallback | None = None,
) -> Drape:
    """Find positions at which no force is left on any node of a scene, from nodes [m], shape [node_count, 3].

    Descent on E in runs: factor the PSD Hessian, then take a few quasi-Newton steps from it (`descend`). Friction's
    normal forces are updated before each run, so that at rest they are those of the rest position, until the motion of
    a run falls below `_FRICTION_FREEZE_MOTION` or does not fall for `_FRICTION_FREEZE_RUNS` runs. With bending friction
    folds keep their angles until the moment exceeds the yarns' friction. Where the scene has self-contact, cloth that
    crosses itself at the start is untangled first.

    **Deviation** from Newton with the exact Hessian: see `docs/adr`, "Descend by quasi-Newton steps".

    Args:
        scene: The cloth and what acts on it.
        nodes: Start.
        anchors: Friction's anchor of each node [m], shape [node_count, 3]; the start where None.
        solver: Analysed for the topology; a new one where None.
        settings: Limits and steps.
        hooks: Checked for cancellation before each run.
        stop: Called after each run; True stops the search.

    Raises:
        NodesBad: where the nodes do not fit the mesh or are not finite.
    """
    nodes = np.array(nodes, dtype=np.float64)
    if nodes.shape != (scene.topology.node_count, 3) or not np.isfinite(nodes).all():
        raise NodesBad()
    anchors = nodes.copy() if anchors is None else anchors
    energy = Energy(scene)
    if scene.self_contact is not None:
        energy, solver, nodes = _untangle(energy, solver, nodes, anchors, settings)
    progress, outcome = _Progress(settings, stop), None
    while outcome is None:
        hooks.check()
        pinned = move_pins(nodes, energy.scene.pins, settings.max_step)
        arrived = bool((pinned == nodes).all())
        if not arrived:
            energy, free = energy.free_share(nodes, pinned - nodes, MIN_PAIR_REACH_SHARE)
            nodes = pinned if free == 1.0 else nodes + free * (pinned - nodes)
        cloth = energy.scene.self_contact
        if cloth is not None and cloth.crossed.any():
            energy = replace(energy.contract_crossings(nodes), push=None)
        energy, solver = extend_sparsity(energy, solver, nodes)
        if progress.follows:
            energy = energy.lag_friction(nodes, energy.rubbing)
            energy = replace(energy, friction=lag_friction(energy.scene, nodes, anchors))
        start, gradient, blocks = energy.hessian(nodes, False)
        if scene.relative_residual(gradient) <= settings.tolerance and arrived:
            outcome = Outcome.CONVERGED
        elif progress.legs == settings.max_iterations:
            outcome = Outcome.ITERATIONS
        elif factor_regularised(energy, solver, nodes, blocks, 0.0) < 0:
            outcome = Outcome.STUCK
        else:
            leg = descend(
                energy, solver, nodes, start, gradient,
                steps=settings.steps_per_factor, residual=settings.tolerance, max_step=settings.max_step,
            )  # fmt: skip
            nodes, outcome, energy = leg.nodes, progress.judge(leg, arrived), leg.energy
    end, gradient = energy.gradient(nodes)
    slid = anchors if energy.friction is None else energy.friction.slide(nodes)
    largest, rms = scene.relative_residual(gradient), scene.relative_rms(gradient)
    return Drape(nodes, largest, progress.legs, end, outcome, slid, scene.rotation, energy.rubbing, rms)


def _untangle(
    energy: Energy, solver: Solver | None, nodes: np.ndarray, anchors: np.ndarray, settings: SolveSettings
) -> tuple[Energy, Solver | None, np.ndarray]:
    """Pull crossed faces at nodes [m] apart, in short damped steps; contact is off for those that stay crossed. A
    contour of fixed nodes that cross cannot come apart: those nodes are unpinned."""
    counts: list[int] = []
    while True:
        energy = energy.contract_crossings(nodes)
        cloth = energy.scene.self_contact
        assert cloth is not None
        counts.append(int(cloth.crossed.sum()))
        if not is_resolving(counts, _UNTANGLE_PATIENCE_ITERATIONS):
            crossed = np.intersect1d(cloth.faces[cloth.crossed], np.flatnonzero(energy.scene.fixed))
            if energy.scene.pins is None or not len(crossed):
                return replace(energy, inertia=None, push=None), solver, nodes
            energy, counts = replace(energy, scene=replace(energy.scene, pins=energy.scene.pins.without(crossed))), []
        friction = lag_friction(energy.scene, nodes, anchors)
        energy, solver = extend_sparsity(
            replace(energy, friction=friction, inertia=Inertia(nodes, 1.0 / _UNTANGLE_TIME_STEP**2)), solver, nodes
        )
        start, gradient, blocks = energy.hessian(nodes, False)
        if factor_regularised(energy, solver, nodes, blocks, 0.0) >= 0:
            leg = descend(energy, solver, nodes, start, gradient, steps=4, residual=0.0, max_step=settings.max_step)
            energy, nodes = leg.energy, leg.nodes
