"""One descent step on the cloth's energy, and the factorisation of as much of the exact Hessian as is definite."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .energy import Energy
from .solver import Solver

_ARMIJO = 1e-4
"""Share of the predicted decrease asked for; the usual value (Nocedal and Wright 2006, 3.1)."""

_SHORTEST = 2.0**-12
"""Shortest step tried: shorter ones move nothing that can be seen."""


_RETREAT = 0.6
"""Factor on the exact share after each indefinite matrix; below a tenth the PSD form alone is taken."""


@dataclass(frozen=True)
class Step:
    """Hold the outcome of one Newton iteration.

    Attributes:
        nodes: Positions after it [m], shape [node_count, 3].
        motion: Largest displacement [m]; 0 where no step helped.
    """

    nodes: np.ndarray
    motion: float


def mean_weight(energy: Energy) -> float:
    """Give the mean weight of a node under standard gravity [N]: the unit of residuals."""
    return float(energy.masses.mean()) * 9.81


def relative_residual(energy: Energy, gradient: np.ndarray) -> float:
    """Give the largest force on a node, relative to the mean weight of a node."""
    return float(np.sqrt((gradient**2).sum(1).max())) / mean_weight(energy)


def newton_step(energy: Energy, solver: Solver, nodes: np.ndarray) -> Step:
    """Take one clamped Newton step with the PSD Hessian and a line search on the energy."""
    start, gradient, blocks = energy.hessian(nodes, False)
    if factor_blend(energy, solver, nodes, blocks, 0.0) < 0:
        return Step(nodes, 0.0)
    direction = -solver.solve(gradient.ravel()).reshape(-1, 3)
    slope = float((gradient * direction).sum())
    if not np.isfinite(direction).all() or slope >= 0:
        # round-off has eaten the direction: down the gradient, a millimetre at most
        direction = -gradient * (1e-3 / max(float(np.abs(gradient).max()), 1e-300))
        slope = float((gradient * direction).sum())
    nodes, motion = search_line(energy, nodes, direction, start, slope)
    return Step(nodes, motion)


def factor_blend(energy: Energy, solver: Solver, nodes: np.ndarray, blocks: np.ndarray, share: float) -> float:
    """Factor the largest share of the exact Hessian that is definite and give it; -1 where nothing can be factored.

    The matrix is share K + (1 - share) K_psd: the exact Hessian is indefinite on compressed cloth.
    `blocks` is the exact Hessian where `share` > 0, else the PSD form. Slack cloth makes the PSD form singular, so it
    is shifted, first by a node's weight per metre, which is nothing beside the cloth's stiffness.
    """
    topology, fixed = energy.topology, energy.fixed
    if share >= 1.0:
        if solver.factor(topology.assemble(blocks, fixed)) and solver.is_positive_definite():
            return 1.0
        share = _RETREAT
    psd = energy.hessian(nodes, False)[2] if share > 0 else blocks
    shift = mean_weight(energy)
    psd[topology.diagonal] += shift * np.eye(3)
    while True:
        mixed = share * blocks + (1.0 - share) * psd if share > 0 else psd
        if solver.factor(topology.assemble(mixed, fixed)) and solver.is_positive_definite():
            return share
        if share > 0:
            share = share * _RETREAT if share > 0.1 else 0.0
        elif shift > 1e12 * mean_weight(energy):
            return -1.0
        else:
            psd[topology.diagonal] += 99.0 * shift * np.eye(3)
            shift *= 100.0


def search_line(
    energy: Energy, nodes: np.ndarray, direction: np.ndarray, start: float, slope: float
) -> tuple[np.ndarray, float]:
    """Halve the step until the energy falls; give the new nodes and the largest displacement."""
    length = float(np.sqrt((direction**2).sum(1).max()))
    share = min(1.0, energy.settings.max_step / max(length, 1e-300))
    noise = 1e-13 * abs(start)
    while share >= _SHORTEST:
        trial = nodes + share * direction
        reached = energy.value(trial)
        if np.isfinite(reached) and reached <= start + _ARMIJO * share * slope + noise:
            return trial, share * length
        share *= 0.5
    return nodes, 0.0
