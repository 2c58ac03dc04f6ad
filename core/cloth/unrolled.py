"""Derivatives through time: implicit Euler steps and their adjoint (thesis eq. 3.2 and 2.27 to 2.30)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..geometry.linear import Solver
from .derivative import adjoint, factor, place_pinned, pull_pins
from .energy import Energy
from .rest import RestSettings, find_rest
from .sensitivity import Sensitivity, pull_forces
from .steps import TimeSteps

__all__ = ["UnrolledSteps"]


@dataclass(frozen=True)
class UnrolledSteps(TimeSteps):
    """Differentiate implicit Euler steps one by one, backwards in time (the thesis' way).

        x_t = argmin E(x; p) + |x - y_t|_M^2 / (2 dt^2),    y_t = x_{t-1} + damping (x_{t-1} - x_{t-2})

    Every step is a linear system with M / dt^2 + K, and so is its adjoint (eq. 2.27 to 2.30; the matrix is symmetric):

        (M / dt^2 + K_t) lambda_t = dL/dx_t,    dL/dp -= lambda_t . dg_t/dp,    dL/dy_t = M lambda_t / dt^2

    **Deviation**: eq. 3.2 takes one linearised step, whose derivative needs that of the matrix too (eq. 2.30), third
    derivatives of the energy. Here each step is solved by Newton until no force is left, so that the derivative of the
    matrix is multiplied by zero; this adjoint after a linearised step would be wrong (cosine -0.18 was measured).

    Attributes (beside those of `TimeSteps`):
        tolerance: Largest force left on a node, relative to the mean weight of a node. 1e-6: the gradient's relative
            error was 1e-8 to 2e-6 (1e-4: 1e-5). 0: all that round-off allows.
        max_iterations: Largest number of matrices factored per step.
    """

    tolerance: float = 1e-6
    max_iterations: int = 200

    def _advance(self, step: Energy, nodes: np.ndarray, solver: Solver) -> np.ndarray:
        assert step.inertia is not None
        guess = min((place_pinned(step.scene, x) for x in (nodes, step.inertia.target)), key=step.value)
        return find_rest(step, guess, solver, RestSettings(self.tolerance, self.max_iterations))

    def pull_step(
        self, step: Energy, start: np.ndarray, end: np.ndarray, bar: np.ndarray, solver: Solver
    ) -> tuple[np.ndarray, Sensitivity]:
        """Pull dL/d(end), `bar`, [node_count, 3], back (`TimeSteps`): the step depends on its start through y alone."""
        blocks = step.hessian(end)[2]
        weights = adjoint(step.scene, factor(step, blocks, solver), bar)
        rest, fabric = pull_forces(step, end, weights)
        return weights, Sensitivity(-rest, -fabric, pull_pins(step.scene, blocks, weights, bar), np.zeros_like(weights))
