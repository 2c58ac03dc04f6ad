"""One descent step on the cloth's energy: exact Hessian where it is positive definite, its PSD form elsewhere."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .energy import Energy
from .solver import Solver

_ARMIJO = 1e-4
"""Share of the predicted decrease asked for; the usual value (Nocedal and Wright 2006, 3.1)."""

_SHORTEST = 2.0**-12
"""Shortest step tried: shorter ones move nothing that can be seen."""


@dataclass(frozen=True)
class Step:
    """Hold the outcome of one Newton iteration.

    Attributes:
        nodes: Positions after it [m], shape [node_count, 3].
        energy: Energy before it [J].
        residual: Largest force before it, relative to the mean weight of a node.
        motion: Largest displacement [m]; 0 where no step helped.
        definite: Whether the exact Hessian was asked for and was positive definite.
    """

    nodes: np.ndarray
    energy: float
    residual: float
    motion: float
    definite: bool


def mean_weight(energy: Energy) -> float:
    """Give the mean weight of a node under standard gravity [N]: the unit of residuals."""
    return float(energy.masses.mean()) * 9.81


def newton_step(energy: Energy, solver: Solver, nodes: np.ndarray, exact: bool) -> Step:
    """Take one clamped Newton step with a line search on the energy."""
    start, gradient, blocks = energy.hessian(nodes, exact)
    residual = float(np.sqrt((gradient**2).sum(1).max())) / mean_weight(energy)
    topology, fixed = energy.topology, energy.fixed
    usable = solver.factor(topology.assemble(blocks, fixed))
    definite = exact and usable and solver.is_positive_definite()
    if exact and not definite:
        _, _, blocks = energy.hessian(nodes, False)
        usable = False
    # the PSD form may be singular (slack cloth): shift it by the weight of a node per centimetre, then ever more
    shift = 100.0 * mean_weight(energy)
    while not usable or (not definite and not np.isfinite(shift)):
        shifted = blocks.copy()
        shifted[topology.diagonal] += shift * np.eye(3)
        usable = solver.factor(topology.assemble(shifted, fixed))
        shift *= 10.0
        if shift > 1e12:
            return Step(nodes, start, residual, 0.0, False)
    direction = -solver.solve(gradient.ravel()).reshape(-1, 3)
    slope = float((gradient * direction).sum())
    if not np.isfinite(direction).all() or slope >= 0:
        direction = -gradient * (1e-3 / max(float(np.abs(gradient).max()), 1e-300))
        slope = float((gradient * direction).sum())
    nodes, motion = _search(energy, nodes, direction, start, slope)
    return Step(nodes, start, residual, motion, definite)


def _search(
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
