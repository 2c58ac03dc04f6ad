"""Solve for the equilibrium of cloth to the accuracy that a derivative needs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..geometry.linear import Solver
from ..run.errors import GarmentqError
from .energy import Energy
from .factorisation import factor_regularised
from .quasi_newton import ARMIJO_DECREASE_SHARE, descend
from .settings import SolveSettings


@dataclass(frozen=True)
class RestSettings:
    """Describe the search for rest.

    Attributes:
        tolerance: Largest force left on a node [mean weight of a node]; 0 for all that round-off allows.
        max_factors: Largest number of matrices factored.
        round_off: Residual [node weights] below which a Newton step that no longer helps is limited by round-off.
        scatter: Ratio of residuals that are both round-off: they scatter by about 2 between two evaluations.
        least_decrease: Ratio of the predicted decrease to the energy below which round-off hides whether a step helps.
        energy_rise: Largest rise of the energy in one step [predicted decreases], by stretch that the next step
            removes. It was at most 5 where that removed it, 6 to 500 where the search diverged; 3 and 30 cost the same.
        retry: Residual [node weights] below which the exact Hessian is tried again; 0.3 and 5 cost the same.
        calm: Residual [node weights] below which one factor serves several steps and runs may stop, since the cloth no
            longer buckles; 0.02 and 0.2 cost the same.
        steps_per_factor: Largest number of steps from one PSD factor: at 3000 nodes 8 took 6 % longer, 24 took 14 %.
        chord_steps: Largest number of steps with an old exact factor; three of them cost half a factor.
        chord_share: Largest share of the residual that each of them may leave.
    """

    tolerance: float
    max_factors: int
    round_off: float = 1e-6
    scatter: float = 3.0
    least_decrease: float = 1e-9
    energy_rise: float = 10.0
    retry: float = 1.0
    calm: float = 0.05
    steps_per_factor: int = 16
    chord_steps: int = 4
    chord_share: float = 0.3


class NotAtRest(GarmentqError):
    """The cloth does not come to rest closely enough for a derivative; settle it for longer first."""

    code = "simulate.not_at_rest"


@dataclass(frozen=True)
class _Point:
    """Describe positions [m], their energy [J], its gradient [N] and the largest force relative to a node's weight."""

    nodes: np.ndarray
    value: float
    gradient: np.ndarray
    residual: float

    @classmethod
    def at(cls, energy: Energy, nodes: np.ndarray) -> _Point:
        """Compute the point of some positions."""
        value, gradient = energy.gradient(nodes)
        return cls(nodes, value, gradient, energy.scene.relative_residual(gradient))


def find_rest(energy: Energy, nodes: np.ndarray, solver: Solver, settings: RestSettings) -> np.ndarray:
    """Return positions [m], shape [node_count, 3], at which no force is left, from nodes near them. Newton with the
    exact Hessian as long as it converges (`_take_newton_steps`). Where it does not, because the cloth buckles, runs of
    quasi-Newton steps from the PSD form (`descend`) until it is near; then Newton again.

    Args:
        energy: What is minimised.
        nodes: Start [m], shape [node_count, 3].
        solver: Factors the Hessians; its factors at the end are not meant for use.
        settings: The tolerance, and what leads to it.

    Raises:
        NotAtRest: where the force left stays above the tolerance.
    """
    point, done = _Point.at(energy, nodes), 0
    while True:
        point, arrived, factors = _take_newton_steps(energy, point, solver, settings, settings.max_factors - done)
        done += factors
        if arrived:
            return point.nodes
        # at a saddle, where the residual is small and Newton does not help, a run must not stop at once
        stop, is_close = (settings.calm if point.residual > settings.calm else 0.0), False
        while not is_close:
            start, gradient, blocks = energy.hessian(point.nodes, False)
            if done >= settings.max_factors or factor_regularised(energy, solver, point.nodes, blocks, 0.0) < 0:
                raise _make_rest_error(point)
            leg = descend(energy, solver, point.nodes, start, gradient, steps=settings.steps_per_factor, residual=stop)
            if leg.steps == 0:
                raise _make_rest_error(point)
            energy = leg.energy
            point, is_close, done = _Point.at(energy, leg.nodes), leg.residual <= settings.retry, done + 1


def _take_newton_steps(
    energy: Energy, point: _Point, solver: Solver, settings: RestSettings, max_factors: int
) -> tuple[_Point, bool, int]:
    """Take Newton steps with the exact Hessian; return the best point, whether it is at rest, and the number of
    factors. A straight step along a fold stretches the cloth by the square of its length: the energy rises and the next
    step removes the stretch. So one step may raise the energy, and the next Hessian takes the predicted stress instead
    of that of the stretch, which would stiffen it (Magisano, Leonetti and Garcea 2017, "mixed integration points").
    Where the Hessian is indefinite, or two steps together have not lowered the energy, the best point is returned."""
    topology, fixed = energy.scene.topology, energy.scene.fixed
    best, stress, tolerance = point, None, settings.tolerance
    for factors in range(max_factors + 1):
        if point.residual <= tolerance:
            return point, True, factors
        if factors == max_factors:
            break
        blocks = energy.hessian(point.nodes, stress=stress)[2]
        if not (solver.factor(topology.assemble(blocks, fixed)) and solver.is_positive_definite()):
            return best, False, factors + 1
        step = -np.asarray(solver.solve(point.gradient.ravel())).reshape(-1, 3)
        step *= min(1.0, SolveSettings.max_step / max(float(np.sqrt((step**2).sum(1).max())), 1e-300))
        energy, free = energy.free_share(point.nodes, step)
        step *= free
        slope = float((point.gradient * step).sum())
        there = _Point.at(energy, point.nodes + step)
        if -slope < settings.least_decrease * abs(best.value):
            is_lower, bearable = there.residual < point.residual, False
            if not is_lower and point.residual <= max(tolerance, settings.round_off):
                # round-off in the stiff directions hides the residual of the soft ones, which the step has removed
                point = there if there.residual <= settings.scatter * point.residual else point
                return point, True, factors + 1
        else:
            is_lower = there.value <= best.value + ARMIJO_DECREASE_SHARE * slope
            bearable = point is best and there.value <= best.value - settings.energy_rise * slope
        if not (is_lower or bearable):
            return best, False, factors + 1
        is_settled = is_lower and there.residual < settings.calm
        stress = None if is_settled else energy.predict_stress(point.nodes, step)
        point = _take_chord_steps(energy, there, solver, settings) if is_settled else there
        best = point if is_lower else best
    raise _make_rest_error(best)


def _take_chord_steps(energy: Energy, point: _Point, solver: Solver, settings: RestSettings) -> _Point:
    """Take further steps with the present factor as long as each removes most of the residual."""
    for _ in range(settings.chord_steps):
        if point.residual <= settings.tolerance:
            break
        step = -np.asarray(solver.solve(point.gradient.ravel())).reshape(-1, 3)
        energy, free = energy.free_share(point.nodes, step)
        there = _Point.at(energy, point.nodes + free * step)
        if not there.residual < point.residual:
            break
        slow, point = there.residual > settings.chord_share * point.residual, there
        if slow:
            break
    return point


def _make_rest_error(point: _Point) -> NotAtRest:
    """Return the error with the force that is left."""
    return NotAtRest(f"the cloth does not come to rest: a force of {point.residual:.1e} of a node's weight is left.")
