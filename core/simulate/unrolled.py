"""Derivatives through time: implicit Euler steps and their adjoint (thesis eq. 3.2 and 2.27 to 2.30)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .derivative import adjoint, factor, place_held, pull_hold
from .energy import Energy, Inertia
from .rest import find_rest
from .sensitivity import Sensitivity, pull_forces
from .solver import Solver, make_solver


@dataclass(frozen=True)
class Unrolled:
    """Differentiate implicit Euler steps one by one, backwards in time (the thesis' way).

        x_t = argmin E(x; p) + |x - y_t|_M^2 / (2 dt^2),    y_t = x_{t-1} + damping (x_{t-1} - x_{t-2})

    Every step is a linear system with M / dt^2 + K, and so is its adjoint (eq. 2.27 to 2.30; the matrix is symmetric):

        (M / dt^2 + K_t) lambda_t = dL/dx_t,    dL/dp -= lambda_t . dg_t/dp,    dL/dy_t = M lambda_t / dt^2

    **Deviation**: eq. 3.2 takes one linearised step, whose derivative needs that of the matrix too (eq. 2.30), third
    derivatives of the energy. Here each step is solved by Newton until no force is left, so that the derivative of the
    matrix is multiplied by zero; the cheap adjoint after a linearised step is wrong (cosine -0.18 was met).

    Attributes:
        steps: How many.
        dt: Length of a step [s]; the thesis has 0.05.
        damping: Share of velocity kept from one step to the next; the thesis has 1. `SimulateSettings.damping` is for
            coming to rest, this for targets in motion. At rest 0.6 takes a sway of a second just critically out of 20
            steps of 0.05 s, and the gradient is that of `Implicit`; undamped it still swings (docs/simulate.md).
        tolerance: Largest force left on a node, relative to the mean weight of a node. 1e-6: the gradient's relative
            error was 1e-8 to 2e-6 (1e-4: 1e-5). 0 asks for all that round-off allows.
        max_iterations: Matrices factored after which a step gives up.
    """

    steps: int = 20
    dt: float = 0.05
    damping: float = 1.0
    tolerance: float = 1e-6
    max_iterations: int = 200

    def solve(
        self, energy: Energy, nodes: np.ndarray, solver: Solver | None = None, velocities: np.ndarray | None = None
    ) -> InMotion:
        """Take the steps from nodes [m] and velocities [m/s], both [node_count, 3]; energy's friction stays as it is.

        Raises:
            NotAtRest: where a step cannot be solved; take shorter ones.
        """
        solver = solver or make_solver(energy.topology)
        start = np.array(nodes, dtype=np.float64)
        path = [start if velocities is None else start - self.dt * np.asarray(velocities), start]
        for _ in range(self.steps):
            step = self.energy_of_step(energy, path[-2], path[-1])
            assert step.inertia is not None
            guesses = (place_held(energy, path[-1]), place_held(energy, step.inertia.target))
            guess = min(guesses, key=step.value)
            path.append(find_rest(step, guess, solver, self.tolerance, self.max_iterations))
        return InMotion(energy, self, np.stack(path), solver)

    def energy_of_step(self, energy: Energy, before: np.ndarray, now: np.ndarray) -> Energy:
        """Give the energy that the next step minimises."""
        return replace(energy, inertia=Inertia(now + self.damping * (now - before), 1.0 / self.dt**2))


@dataclass(frozen=True)
class InMotion:
    """Hold the way that cloth took.

    Attributes:
        energy: The energy without inertia.
        unrolled: How the steps were taken.
        path: Positions before the start, at it and after each step [m], shape [steps + 2, node_count, 3].
        solver: Factors the steps' matrices again on the way back.
    """

    energy: Energy
    unrolled: Unrolled
    path: np.ndarray
    solver: Solver

    @property
    def nodes(self) -> np.ndarray:
        """Give the positions after the last step [m], shape [node_count, 3]."""
        return np.asarray(self.path[-1])

    def pull(self, upstream: np.ndarray) -> Sensitivity:
        """Give a loss's derivative by everything, from that by the positions [1/m].

        `upstream` by the last positions, shape [node_count, 3], or by those after every step (a target in motion),
        shape [steps, node_count, 3].
        """
        unrolled, path, energy = self.unrolled, self.path, self.energy
        bars = np.zeros_like(path)
        if np.ndim(upstream) == 3:
            bars[2:] = upstream
        else:
            bars[-1] = upstream
        held = 0 if energy.hold is None else len(energy.hold.nodes)
        rest, fabric, hold = np.zeros_like(energy.topology.rest), np.zeros(6), np.zeros((held, 3))
        tied = (energy.masses / unrolled.dt**2)[:, None]
        for t in range(len(path) - 1, 1, -1):
            step = unrolled.energy_of_step(energy, path[t - 2], path[t - 1])
            blocks = step.hessian(path[t])[2]
            weights = adjoint(step, factor(step, blocks, self.solver), bars[t])
            by_rest, by_fabric = pull_forces(step, path[t], weights)
            rest, fabric = rest - by_rest, fabric - by_fabric
            hold = hold + pull_hold(step, blocks, weights, bars[t])
            bars[t - 1] += (1.0 + unrolled.damping) * tied * weights
            bars[t - 2] -= unrolled.damping * tied * weights
        return Sensitivity(rest, fabric, hold, bars[1] + bars[0])
