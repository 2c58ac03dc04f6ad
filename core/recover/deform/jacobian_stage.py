"""Optimise per-face Jacobians with Adam, positions by the Poisson solve (thesis section 4.2.2)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
import torch

from ...run.hooks import Hooks
from .objective import Objective
from .poisson import PoissonSystem, solve_poisson
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

    def __init__(self, values: torch.Tensor, block: int, rate: float) -> None:
        self.values, self._block, self._rate = values, block, rate
        self._mean = torch.zeros_like(values)
        self._square = torch.zeros(len(values) // block, 1, dtype=values.dtype)
        self._count = 0

    def step(self, factor: float) -> None:
        """Take one step at the rate times a factor; decay rates 0.9 and 0.999 are those of the source."""
        gradient = self.values.grad
        if gradient is None:
            return
        self._count += 1
        with torch.no_grad():
            self._mean.mul_(0.9).add_(gradient, alpha=0.1)
            square = (gradient.reshape(len(self._square), -1) ** 2).mean(1, keepdim=True)
            self._square.mul_(0.999).add_(square, alpha=0.001)
            mean = self._mean / (1 - 0.9**self._count)
            size = (self._square / (1 - 0.999**self._count)).sqrt() + 1e-12
            self.values.sub_(self._rate * factor * mean / size.repeat_interleave(self._block, 0))


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
    jacobians = torch.from_numpy(np.asarray(gradient @ nodes)).requires_grad_(True)
    # positions() returns zero mean up to the regularisation's share: the rest is in the offset
    offset = torch.from_numpy(nodes - system.positions(np.asarray(gradient @ nodes)))
    shift = torch.zeros(1, 3, dtype=torch.float64, requires_grad=True)
    moves = (FaceAdam(jacobians, 2, settings.learning_rate), FaceAdam(shift, 1, settings.translation_rate))
    history: dict[str, list[float]] = {}
    best = (math.inf, np.array(nodes))
    totals: list[float] = []
    taken = 0
    for step in range(settings.iterations + 1):
        for move in moves:
            move.values.grad = None
        x = solve_poisson(jacobians, system) + offset + shift
        now = x.detach().numpy()
        if step % settings.metric_every == 0:
            metric.follow(rows_to_jacobians(gradient @ now))
        if step % settings.match_every == 0:
            matches = objective.match(now)
        strained = step >= settings.strain_from
        terms = objective.terms(x, matches, metric, strained)
        total = torch.stack(list(terms.values())).sum()
        value = float(total.detach())
        if not math.isfinite(value):
            break
        if value < best[0] or step == settings.strain_from:
            best = (value, now.copy())
        if step == settings.iterations or _is_flat(totals, settings):
            break
        totals.append(value)
        taken = step + 1
        for name in terms:
            history.setdefault(name, [0.0] * step)
        for name, values in history.items():
            values.append(float(terms[name].detach()) if name in terms else 0.0)
        total.backward()  # type: ignore[no-untyped-call]
        for move in moves:
            move.step(_decay(step, settings))
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
