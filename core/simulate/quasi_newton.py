"""Several descent steps from one factorisation: limited-memory BFGS that starts from the factored PSD Hessian."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .energy import Energy
from .settings import SolveSettings
from .solver import Solver

ARMIJO = 1e-4
"""Share of the predicted decrease asked for; the usual value (Nocedal and Wright 2006, 3.1)."""

_TRIALS = 12
"""Step lengths tried: each is at most half of the one before, and a 4000th of a step moves nothing that can be seen."""

_BENT = 1e-12
"""Cosine between a step and the change of the gradient under which the pair tells nothing but round-off."""


@dataclass(frozen=True)
class Leg:
    """Hold where a few steps with one factored matrix have led.

    Attributes:
        nodes: Positions after them [m], shape [node_count, 3].
        residual: Largest force there, relative to the mean weight of a node.
        motion: Largest displacement of a node over all of them [m].
        steps: Steps that lowered the energy.
        energy: What was minimised; it knows the pairs of cloth near its end.
    """

    nodes: np.ndarray
    residual: float
    motion: float
    steps: int
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
) -> Leg:
    """Take up to `steps` descent steps with the matrix that `solver` has factored; stop at the residual.

    d = -B g, B the inverse of the factored matrix as the BFGS formula corrects it by all pairs (s, y) of the leg, s the
    steps and y the gradient's changes (Nocedal and Wright 2006, algorithm 7.4). A factored PSD Hessian bends the cloth
    along straight lines; folds move along curved ones, and the pairs tell how, for a tenth of a factorisation each.

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
    origin, done = nodes, 0
    pairs: list[tuple[np.ndarray, np.ndarray]] = []
    reached = energy.scene.relative_residual(gradient)
    while done < steps and reached > residual:
        direction = -_apply(solver, pairs, gradient.ravel()).reshape(-1, 3)
        slope = float((gradient * direction).sum())
        if not np.isfinite(direction).all() or slope >= 0:
            break
        length = float(np.sqrt((direction**2).sum(1).max()))
        share = min(1.0, max_step / max(length, 1e-300))
        energy, free = energy.free_share(nodes, share * direction)
        share *= free
        found = _search(energy, nodes, direction, start, slope, share)
        if found is None:
            break
        moved, start, after = found
        step, change = (moved - nodes).ravel(), (after - gradient).ravel()
        if float(step @ change) > _BENT * float(np.linalg.norm(step) * np.linalg.norm(change)):
            pairs.append((step, change))
        nodes, gradient, done = moved, after, done + 1
        reached = energy.scene.relative_residual(gradient)
    return Leg(nodes, reached, float(np.sqrt(((nodes - origin) ** 2).sum(1).max())), done, energy)


def _apply(solver: Solver, pairs: list[tuple[np.ndarray, np.ndarray]], gradient: np.ndarray) -> np.ndarray:
    """Multiply with the corrected inverse (two-loop recursion)."""
    result, weights = gradient.copy(), []
    for step, change in reversed(pairs):
        weights.append(float(step @ result) / float(step @ change))
        result -= weights[-1] * change
    result = solver.solve(result)
    for (step, change), weight in zip(pairs, reversed(weights), strict=True):
        result += (weight - float(change @ result) / float(step @ change)) * step
    return result


def _search(
    energy: Energy, nodes: np.ndarray, direction: np.ndarray, start: float, slope: float, share: float
) -> tuple[np.ndarray, float, np.ndarray] | None:
    """Shorten a share of the direction until the energy falls: nodes, energy, gradient there, or None if none helps."""
    noise = 1e-13 * abs(start)
    for _ in range(_TRIALS):
        trial = nodes + share * direction
        reached, gradient = energy.gradient(trial)
        if np.isfinite(reached) and reached <= start + ARMIJO * share * slope + noise:
            return trial, reached, gradient
        # the lowest point of the parabola through what is known, between a tenth and a half of the step
        parabola = -0.5 * slope * share**2 / (reached - start - slope * share) if np.isfinite(reached) else 0.0
        share = min(max(parabola, 0.1 * share), 0.5 * share)
    return None
