"""Optimise per-face Jacobians with Adam, positions by the Poisson solve (thesis section 4.2.2)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from ...run.hooks import Hooks
from .objective import Objective
from .poisson import PoissonSystem
from .rest_metric import RestMetric
from .settings import DeformSettings

PLATEAU_WINDOW = 20
"""Number of iterations over which the improvement is judged: longer than a step's ripple, a seventh of the whole."""


@dataclass(frozen=True)
class StageResult:
    """Describe the nodes [m], the steps taken, and the weighted terms per step."""

    nodes: np.ndarray
    iterations: int
    losses: dict[str, np.ndarray]


class FaceAdam:
    """Take Adam steps with one second moment per face (or row block) instead of one per number.

    **Deviation** from Kingma and Ba 2015: the mean of the squared gradient over a block's numbers replaces the square
    of each, so that the step turns with the garment (Ling et al. 2022, VectorAdam).
    """

    def __init__(self, values: np.ndarray, block: int, rate: float) -> None:
        """Begin at `values`, shape [n, d], which are moved in place; `block` rows share a second moment."""
        self.values, self._rate = values, rate
        self._mean = np.zeros((len(values) // block, block * values.shape[1]))
        self._square = np.zeros((len(self._mean), 1))
        self._count = 0

    def step(self, gradient: np.ndarray, factor: float) -> None:
        """Take one step at the rate times a factor, against a gradient, shape [n, d]; decay rates 0.9 and 0.999 are
        those of the source."""
        self._count += 1
        pull = gradient.reshape(self._mean.shape)
        self._mean = 0.9 * self._mean + 0.1 * pull
        self._square = 0.999 * self._square + 0.001 * np.mean(pull**2, axis=1, keepdims=True)
        size = np.sqrt(self._square / (1 - 0.999**self._count)) + 1e-12
        rate = self._rate * factor / (1 - 0.9**self._count)
        self.values -= (rate / size * self._mean).reshape(self.values.shape)


def optimise_jacobians(
    nodes: np.ndarray,
    gradient: sp.csr_matrix,
    areas: np.ndarray,
    objective: Objective,
    metric: RestMetric,
    settings: DeformSettings,
    hooks: Hooks,
) -> StageResult:
    """Deform the nodes by their Jacobians until the loss no longer improves.

    Args:
        nodes: Initial positions [m], shape [node_count, 3].
        gradient: Positions to Jacobian rows, shape [2 face_count, node_count].
        areas: Rest areas [m2], shape [face_count].
        objective: The loss.
        metric: Rest metric of the strain; it follows the surface during the stage.
        settings: Weights and steps.
        hooks: Progress and cancellation, called at every step.
    """
    system = PoissonSystem(gradient, areas)
    jacobians = np.ascontiguousarray(gradient @ nodes)
    # positions() returns zero mean up to the regularisation's share: the rest is in the offset
    offset, shift = nodes - system.positions(jacobians), np.zeros((1, 3))
    turns, moves = FaceAdam(jacobians, 2, settings.learning_rate), FaceAdam(shift, 1, settings.translation_rate)
    history: dict[str, list[float]] = {}
    best = (math.inf, np.array(nodes))
    totals: list[float] = []
    taken = 0
    for step in range(settings.iterations + 1):
        now = system.positions(jacobians) + offset + shift
        if step % settings.metric_every == 0:
            metric.follow(rows_to_jacobians(gradient @ now))
        if step % settings.match_every == 0:
            matches = objective.match(now)
        terms, slope = objective.evaluate(now, matches, metric, step >= settings.strain_from)
        value = sum(terms.values())
        if not math.isfinite(value):
            break
        if value < best[0] or step == settings.strain_from:
            best = (value, now)
        if step == settings.iterations or _is_flat(totals, settings):
            break
        totals.append(value)
        taken = step + 1
        for name in terms:
            history.setdefault(name, [0.0] * step)
        for name, values in history.items():
            values.append(terms.get(name, 0.0))
        turns.step(system.pull_back(slope), _decay(step, settings))
        moves.step(slope.sum(axis=0, keepdims=True), _decay(step, settings))
        hooks.progress("deform", 0.1 + 0.6 * taken / max(settings.iterations, 1), f"step {taken}")
    losses = {name: np.array(values) for name, values in history.items()}
    losses["total"] = np.array(totals)
    return StageResult(best[1], taken, losses)


def rows_to_jacobians(rows: np.ndarray) -> np.ndarray:
    """Turn gradient rows [2 face_count, 3] into Jacobians, shape [face_count, 3, 2]."""
    return np.asarray(rows).reshape(-1, 2, 3).transpose(0, 2, 1)


def _decay(step: int, settings: DeformSettings) -> float:
    if not settings.cosine_decay:
        return 1.0
    return 0.02 + 0.49 * (1 + math.cos(math.pi * step / settings.iterations))


def _is_flat(totals: list[float], settings: DeformSettings) -> bool:
    """Return whether the second half's last steps improved by less than the plateau's share."""
    if settings.plateau <= 0 or len(totals) < max(settings.iterations // 2, 2 * PLATEAU_WINDOW):
        return False
    before, after = min(totals[:-PLATEAU_WINDOW]), min(totals[-PLATEAU_WINDOW:])
    return before - after < settings.plateau * before
