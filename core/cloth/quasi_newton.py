"""Several descent steps from one factorisation: limited-memory BFGS that starts from the factored PSD Hessian."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from .energy import Energy
from .loads import largest_length
from .settings import SolveSettings
from .solver import Solver

ARMIJO_DECREASE_SHARE = 1e-4
"""Share of the predicted decrease that a step must reach; the usual value (Nocedal and Wright 2006, 3.1)."""

_MAX_LINE_SEARCH_TRIALS = 12
"""Largest number of step lengths tried. Each is at most half of the one before, and a 4000th of a step moves nothing
that can be seen."""

_MAX_LBFGS_RESTARTS = 4
"""Largest number of times that a run is continued where something came near that it did not watch. The last one looks
ahead along its steps."""

_MIN_CURVATURE_COSINE = 1e-12
"""Smallest cosine between a step and the change of the gradient. Under it the pair holds nothing but round-off."""


@dataclass(frozen=True)
class LbfgsRun:
    """Describe where a few steps with one factored matrix have led.

    Attributes:
        nodes: Positions after them [m], shape [node_count, 3].
        residual: Largest force there, relative to the mean weight of a node.
        motion: Largest displacement of a node over all of them [m].
        steps: Steps that lowered the energy.
        cut: Whether cloth that would have touched cut a step short.
        energy: What was minimised; it knows the pairs of cloth near its end.
    """

    nodes: np.ndarray
    residual: float
    motion: float
    steps: int
    cut: bool
    energy: Energy


def descend(
    energy: Energy,
    solver: Solver,
    nodes: np.ndarray,
    start: float,
    gradient: np.ndarray,
    *,
    steps: int,
    residual: float,
    max_step: float = SolveSettings.max_step,
) -> LbfgsRun:
    """Take up to `steps` descent steps with the matrix that `solver` has factored; stop at the residual.

    d = -B g, B the inverse of the factored matrix as the BFGS formula corrects it by all pairs (s, y) of the leg, s the
    steps and y the gradient's changes (Nocedal and Wright 2006, algorithm 7.4). A factored PSD Hessian bends the cloth
    along straight lines; folds move along curved ones, and the pairs tell how, for a tenth of a factorisation each.

    Cloth that touches itself is watched where the leg begins. Where the leg ends it is looked over: what came near on
    the way cuts it there, and it goes on from there with that in sight.

    Args:
        energy: What is minimised.
        solver: Holds the factors of a positive definite matrix.
        nodes: Where to start [m], shape [node_count, 3].
        start: Energy there [J].
        gradient: Gradient there [N], shape [node_count, 3].
        steps: Most steps.
        residual: Largest force, relative to the mean weight of a node, at which to stop.
        max_step: Largest displacement of a node in a step [m].
    """
    path = [_Iterate(nodes, start, gradient)]
    touches, cut = energy.scene.self_contact is not None, False
    for turn in range(_MAX_LBFGS_RESTARTS + 1):
        checked = len(path) - 1
        energy = energy.hold(path[-1].nodes)
        while len(path) <= steps and energy.scene.relative_residual(path[-1].gradient) > residual:
            place, energy, free = _step(energy, solver, path, max_step, turn == _MAX_LBFGS_RESTARTS)
            cut = cut or free < 1.0
            if place is None:
                break
            path.append(place)
        if not touches:
            break
        energy, good = energy.look_back(np.stack([place.nodes for place in path[checked:]]))
        if checked + good == len(path) - 1:
            break
        del path[checked + good + 1 :]
    return _end_run(energy, path, cut)


def step_with_frozen_pairs(
    energy: Energy, solver: Solver, nodes: np.ndarray, start: float, gradient: np.ndarray, max_step: float
) -> LbfgsRun:
    """Take one descent step as `descend` does that is not looked over: who holds the pairs looks back on it.

    Args:
        energy: What is minimised; it holds the pairs of cloth that it knows.
        solver: Holds the factors of a positive definite matrix.
        nodes: Where to start [m], shape [node_count, 3].
        start: Energy there [J].
        gradient: Gradient there [N], shape [node_count, 3].
        max_step: Largest displacement of a node [m].
    """
    path = [_Iterate(nodes, start, gradient)]
    place, energy, free = _step(energy, solver, path, max_step, False)
    return _end_run(energy, path if place is None else [*path, place], free < 1.0)


def _end_run(energy: Energy, path: list[_Iterate], cut: bool) -> LbfgsRun:
    """Return the leg of a path."""
    end = path[-1]
    motion = float(largest_length(end.nodes - path[0].nodes))
    return LbfgsRun(end.nodes, energy.scene.relative_residual(end.gradient), motion, len(path) - 1, cut, energy)


class _CorrectionPair(NamedTuple):
    """A step of a leg [m], the gradient's change [N], both of shape [3 node_count], and their product."""

    step: np.ndarray
    change: np.ndarray
    curvature: float


class _Iterate(NamedTuple):
    """A place of a leg: nodes [m], energy [J] and gradient [N] there, and what the step to it tells, if anything."""

    nodes: np.ndarray
    energy: float
    gradient: np.ndarray
    pair: _CorrectionPair | None = None

    def reached_from(self, before: _Iterate) -> _Iterate:
        """Return the place with what the step from another one tells: but for round-off how the gradient changes."""
        step, change = (self.nodes - before.nodes).ravel(), (self.gradient - before.gradient).ravel()
        curvature = float(step @ change)
        tells = curvature > _MIN_CURVATURE_COSINE * float(np.linalg.norm(step) * np.linalg.norm(change))
        return self._replace(pair=_CorrectionPair(step, change, curvature) if tells else None)


def _step(
    energy: Energy, solver: Solver, path: list[_Iterate], max_step: float, wary: bool
) -> tuple[_Iterate | None, Energy, float]:
    """Return the place that the next step leads to, or None where none lowers the energy.

    With it come the energy that knows the pairs on the way, and the share of it, 0 to 1, that is free of touch. `wary`
    looks along the step before it is taken.
    """
    here = path[-1]
    pairs = [place.pair for place in path if place.pair is not None]
    direction = -_apply(solver, pairs, here.gradient.ravel()).reshape(-1, 3)
    slope = float((here.gradient * direction).sum())
    if not np.isfinite(direction).all() or slope >= 0:
        return None, energy, 1.0
    share = min(1.0, max_step / max(float(largest_length(direction)), 1e-300))
    if wary and energy.scene.self_contact is not None:
        energy = replace(energy, near=None).watch(here.nodes, here.nodes + share * direction).hold(here.nodes)
    energy, free = energy.free_share(here.nodes, share * direction)
    return _search_line(energy, here, direction, slope, share * free), energy, free


def _apply(solver: Solver, pairs: list[_CorrectionPair], gradient: np.ndarray) -> np.ndarray:
    """Multiply with the corrected inverse (two-loop recursion)."""
    result, weights = gradient.copy(), []
    for step, change, curvature in reversed(pairs):
        weights.append(float(step @ result) / curvature)
        result -= weights[-1] * change
    result = solver.solve(result)
    for (step, change, curvature), weight in zip(pairs, reversed(weights), strict=True):
        result += (weight - float(change @ result) / curvature) * step
    return result


def _search_line(energy: Energy, here: _Iterate, direction: np.ndarray, slope: float, share: float) -> _Iterate | None:
    """Shorten a share of the direction until the energy falls; None if nothing helps."""
    noise = 1e-13 * abs(here.energy)
    for _ in range(_MAX_LINE_SEARCH_TRIALS):
        trial = here.nodes + share * direction
        reached, gradient = energy.gradient(trial)
        if np.isfinite(reached) and reached <= here.energy + ARMIJO_DECREASE_SHARE * share * slope + noise:
            return _Iterate(trial, reached, gradient).reached_from(here)
        # the lowest point of the parabola through what is known, between a tenth and a half of the step
        parabola = -0.5 * slope * share**2 / (reached - here.energy - slope * share) if np.isfinite(reached) else 0.0
        share = min(max(parabola, 0.1 * share), 0.5 * share)
    return None
