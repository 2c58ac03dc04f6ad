"""Runs of descent steps from one factorisation: limited-memory BFGS that starts from the factored PSD Hessian."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..geometry.linear import Solver
from .energy import Energy
from .loads import largest_length
from .settings import SolveSettings

ARMIJO_DECREASE_SHARE = 1e-4
"""Share of the predicted decrease that a step must reach; the usual value (Nocedal and Wright 2006, 3.1)."""

_MAX_LINE_SEARCH_TRIALS = 12
"""Largest number of step lengths tried. Each is at most half of the one before; a 4000th of a step is negligible."""

_MAX_LBFGS_RESTARTS = 4
"""Largest number of times that a run continues after a pair came near that was not watched. The last time each step is
checked before it is taken."""

_MIN_CURVATURE_COSINE = 1e-12
"""Smallest cosine between a step and the change of the gradient. Below it the change is round-off."""


@dataclass(frozen=True)
class LbfgsRun:
    """Describe the result of a run: a few steps with one factored matrix.

    Attributes:
        nodes: Positions after them [m], shape [node_count, 3].
        residual: Largest force there, relative to the mean weight of a node.
        motion: Largest displacement of a node over all of them [m].
        steps: Number of steps that lowered the energy.
        cut: Whether a step was cut short to avoid a collision.
        energy: What was minimised, with the pairs of cloth near its end.
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

    d = -B g, B the inverse of the factored matrix, corrected by the BFGS formula with all pairs (s, y) of the run, s
    the steps and y the gradient's changes (Nocedal and Wright 2006, algorithm 7.4). Steps of the factored PSD Hessian
    are straight while folds move along curves; the pairs correct this for a tenth of a factorisation each.

    Near pairs are searched at the start of a run and the path is checked at its end: a pair that came near on the path
    cuts it there, and the run continues from there with that pair.

    Args:
        energy: What is minimised.
        solver: Has the factors of a positive definite matrix.
        nodes: Start [m], shape [node_count, 3].
        start: Energy there [J].
        gradient: Gradient there [N], shape [node_count, 3].
        steps: Largest number of steps.
        residual: Largest force, relative to the mean weight of a node, at which to stop.
        max_step: Largest displacement of a node in a step [m].
    """
    path = [_Iterate(nodes, start, gradient)]
    touches, cut = energy.scene.self_contact is not None, False
    for turn in range(_MAX_LBFGS_RESTARTS + 1):
        checked = len(path) - 1
        energy = energy.freeze(path[-1].nodes)
        while len(path) <= steps and energy.scene.relative_residual(path[-1].gradient) > residual:
            place, energy, free = _step(energy, solver, path, max_step, turn == _MAX_LBFGS_RESTARTS)
            cut = cut or free < 1.0
            if place is None:
                break
            path.append(place)
        if not touches:
            break
        energy, good = energy.verify_pairs(np.stack([place.nodes for place in path[checked:]]))
        if checked + good == len(path) - 1:
            break
        del path[checked + good + 1 :]
    return _end_run(energy, path, cut)


def step_with_frozen_pairs(
    energy: Energy, solver: Solver, nodes: np.ndarray, start: float, gradient: np.ndarray, max_step: float
) -> LbfgsRun:
    """Take one descent step as `descend` does, without checking its path; the caller checks it (`Energy.verify_pairs`).

    Args:
        energy: What is minimised; its known pairs are frozen (`Energy.freeze`).
        solver: Has the factors of a positive definite matrix.
        nodes: Start [m], shape [node_count, 3].
        start: Energy there [J].
        gradient: Gradient there [N], shape [node_count, 3].
        max_step: Largest displacement of a node [m].
    """
    path = [_Iterate(nodes, start, gradient)]
    place, energy, free = _step(energy, solver, path, max_step, False)
    return _end_run(energy, path if place is None else [*path, place], free < 1.0)


def _end_run(energy: Energy, path: list[_Iterate], cut: bool) -> LbfgsRun:
    """Return the run of a path."""
    end = path[-1]
    motion = float(largest_length(end.nodes - path[0].nodes))
    return LbfgsRun(end.nodes, energy.scene.relative_residual(end.gradient), motion, len(path) - 1, cut, energy)


class _CorrectionPair(NamedTuple):
    """Correction pair of a step: the step [m], the gradient's change [N], both [3 node_count], and their product."""

    step: np.ndarray
    change: np.ndarray
    curvature: float


class _Iterate(NamedTuple):
    """Place of a run: nodes [m], energy [J] and gradient [N] there, and the correction pair of the step to it or
    None."""

    nodes: np.ndarray
    energy: float
    gradient: np.ndarray
    pair: _CorrectionPair | None = None

    def reached_from(self, before: _Iterate) -> _Iterate:
        """Return the place with the correction pair of the step from another one, unless it is round-off."""
        step, change = (self.nodes - before.nodes).ravel(), (self.gradient - before.gradient).ravel()
        curvature = float(step @ change)
        tells = curvature > _MIN_CURVATURE_COSINE * float(np.linalg.norm(step) * np.linalg.norm(change))
        return self._replace(pair=_CorrectionPair(step, change, curvature) if tells else None)


def _step(
    energy: Energy, solver: Solver, path: list[_Iterate], max_step: float, search_ahead: bool
) -> tuple[_Iterate | None, Energy, float]:
    """Return the place after the next step, or None where no step lowers the energy. Also returns the energy with the
    pairs on the path, and the share of the step, 0 to 1, without collision. `search_ahead` searches the pairs along the
    step before it is taken."""
    last = path[-1]
    pairs = [place.pair for place in path if place.pair is not None]
    direction = -_apply(solver, pairs, last.gradient.ravel()).reshape(-1, 3)
    slope = float((last.gradient * direction).sum())
    if not np.isfinite(direction).all() or slope >= 0:
        return None, energy, 1.0
    share = min(1.0, max_step / max(float(largest_length(direction)), 1e-300))
    if search_ahead and energy.scene.self_contact is not None:
        energy = replace(energy, near=None).watch(last.nodes, last.nodes + share * direction).freeze(last.nodes)
    energy, free = energy.free_share(last.nodes, share * direction)
    return _search_line(energy, last, direction, slope, share * free), energy, free


def _apply(solver: Solver, pairs: list[_CorrectionPair], gradient: np.ndarray) -> np.ndarray:
    """Multiply the corrected inverse with a gradient (two-loop recursion)."""
    result, weights = gradient.copy(), []
    for step, change, curvature in reversed(pairs):
        weights.append(float(step @ result) / curvature)
        result -= weights[-1] * change
    result = solver.solve(result)
    for (step, change, curvature), weight in zip(pairs, reversed(weights), strict=True):
        result += (weight - float(change @ result) / curvature) * step
    return result


def _search_line(energy: Energy, last: _Iterate, direction: np.ndarray, slope: float, share: float) -> _Iterate | None:
    """Return the place at a share of the direction, shortened until the energy falls; None where it does not."""
    noise = 1e-13 * abs(last.energy)
    for _ in range(_MAX_LINE_SEARCH_TRIALS):
        trial = last.nodes + share * direction
        reached, gradient = energy.gradient(trial)
        if np.isfinite(reached) and reached <= last.energy + ARMIJO_DECREASE_SHARE * share * slope + noise:
            return _Iterate(trial, reached, gradient).reached_from(last)
        # minimum of the parabola through both energies and the slope, clamped to a tenth to a half of the step
        parabola = -0.5 * slope * share**2 / (reached - last.energy - slope * share) if np.isfinite(reached) else 0.0
        share = min(max(parabola, 0.1 * share), 0.5 * share)
    return None
