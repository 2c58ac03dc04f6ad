"""The thesis' own time steps, one linear system each, with the whole adjoint of such a step (eq. 3.2, 2.27 to 2.30)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .derivative import NotAtRest, adjoint, matrix_of, place_held
from .energy import Energy
from .sensitivity import Sensitivity, pull_forces
from .solver import Solver, make_solver
from .unrolled import Unrolled

NEAR = 1e-7
"""Largest motion of a node for a difference of Hessians [m]: forces change over millimetres (contact's thickness), so
its error is a billionth, and round-off's a ten-billionth."""


@dataclass(frozen=True)
class Linearised:
    """Differentiate linearised implicit Euler steps one by one, backwards in time: the thesis' way to the letter.

        A_t (x_t - x_{t-1}) = -g_t(x_{t-1}),    A_t = M / dt^2 + K(x_{t-1}),    g_t the gradient of `Unrolled`'s step

    Such a step is not solved until no force is left, so the derivative of its matrix counts (eq. 2.30):

        A_t lambda = dL/dx_t,    dL/dx_{t-1} += dL/dx_t - H_t lambda - d(lambda . P d_t)/dx,
        dL/dp -= lambda . dg_t/dp + d(lambda . A_t d_t)/dp,    d_t = x_t - x_{t-1}

    with H_t the exact Hessian of the step's energy, and dL/dy_t = M lambda / dt^2 as in `Unrolled`. Every step is as
    quick as one iteration of the converged ones and the gradient is that of the path that was taken; where the path has
    not come to rest, neither has the gradient.

    **Deviation**: K is the exact Hessian, as in the thesis, only where A is positive definite with it, else the PSD
    form: cloth that is pressed together then has a step, too, but a shorter one.

    Attributes:
        steps: How many.
        dt: Length of a step [s]; the thesis has 0.05.
        damping: Share of velocity kept from one step to the next; the thesis has 1.
    """

    steps: int = 20
    dt: float = 0.05
    damping: float = 1.0

    @property
    def converged(self) -> Unrolled:
        """Give the steps that these are the linearisation of."""
        return Unrolled(self.steps, self.dt, self.damping)

    def solve(
        self, energy: Energy, nodes: np.ndarray, solver: Solver | None = None, velocities: np.ndarray | None = None
    ) -> InLinearSteps:
        """Take the steps from nodes [m] and velocities [m/s], both [node_count, 3]; energy's friction stays as it is.

        Raises:
            NotAtRest: where a step's matrix cannot be factored; take shorter ones.
        """
        solver = solver or make_solver(energy.topology)
        start = place_held(energy, nodes)
        path = [start if velocities is None else start - self.dt * np.asarray(velocities), start]
        for _ in range(self.steps):
            step = self.converged.energy_of_step(energy, path[-2], path[-1])
            _, gradient = _factor(step, path[-1], solver)
            path.append(path[-1] - adjoint(step, solver, gradient))
        return InLinearSteps(energy, self, np.stack(path), solver)


@dataclass(frozen=True)
class InLinearSteps:
    """Hold the way that cloth took in linearised steps.

    Attributes:
        energy: The energy without inertia.
        linearised: How the steps were taken.
        path: Positions before the start, at it and after each step [m], shape [steps + 2, node_count, 3].
        solver: Factors the steps' matrices again on the way back.
    """

    energy: Energy
    linearised: Linearised
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
        from .hessian_form import pull_form

        linearised, path, energy = self.linearised, self.path, self.energy
        bars = np.zeros_like(path)
        if np.ndim(upstream) == 3:
            bars[2:] = upstream
        else:
            bars[-1] = upstream
        hold, rest, fabric = energy.hold, np.zeros_like(energy.topology.rest), np.zeros(6)
        held = np.zeros((0 if hold is None else len(hold.nodes), 3))
        tied = (energy.masses / linearised.dt**2)[:, None]
        for t in range(len(path) - 1, 1, -1):
            step = linearised.converged.energy_of_step(energy, path[t - 2], path[t - 1])
            exact, _ = _factor(step, path[t - 1], self.solver)
            weights, way = adjoint(step, self.solver, bars[t]), path[t] - path[t - 1]
            if exact:
                by_nodes, by_rest, by_fabric = _pull_exact(step, path[t - 1], weights, way)
            else:
                by_nodes, by_rest, by_fabric = pull_form(step, path[t - 1], weights, way)[1]
            forces_by_rest, forces_by_fabric = pull_forces(step, path[t - 1], weights)
            rest, fabric = rest - by_rest - forces_by_rest, fabric - by_fabric - forces_by_fabric
            if hold is not None and hold.stiffness is not None:
                held += hold.stiffness * np.array(hold.directions) * weights[hold.nodes]
            bars[t - 1] += bars[t] - _turn(step, path[t - 1], weights) - by_nodes
            bars[t - 1] += (1.0 + linearised.damping) * tied * weights
            bars[t - 2] -= linearised.damping * tied * weights
        start = bars[1] + bars[0]
        if hold is not None and hold.stiffness is None:
            held, start[hold.nodes] = start[hold.nodes], 0.0
        return Sensitivity(rest, fabric, held, start)


def _factor(step: Energy, nodes: np.ndarray, solver: Solver) -> tuple[bool, np.ndarray]:
    """Factor a step's Hessian at nodes [m]: tell whether it is the exact one, and give the step's gradient [N]."""
    for exact in (True, False):
        _, gradient, blocks = step.hessian(nodes, exact)
        if solver.factor(step.topology.assemble(blocks, step.fixed)) and solver.is_positive_definite():
            return exact, gradient
    raise NotAtRest("a step's matrix cannot be factored: take shorter steps.")


def _turn(step: Energy, nodes: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Multiply the exact Hessian at nodes [m] with weights, shape [node_count, 3]; fixed nodes' rows are whole."""
    free = np.zeros(len(nodes), dtype=bool)
    data = step.topology.assemble(step.hessian(nodes)[2], free)
    return np.asarray((matrix_of(step.topology, data) @ weights.ravel()).reshape(-1, 3))


def _pull_exact(step: Energy, nodes: np.ndarray, weights: np.ndarray, way: np.ndarray) -> tuple[np.ndarray, ...]:
    """Give the derivative of weights . H way as `pull_form` does: that of weights . g, differentiated along the way.

    H is the derivative of g, so the order may be exchanged; the outer derivative is a central difference over `NEAR`.
    """
    length = float(np.sqrt((way**2).sum(1).max()))
    if length == 0.0:
        return tuple(np.zeros_like(part) for part in (nodes, *pull_forces(step, nodes, weights)))
    share = NEAR / length
    ends = [nodes + s * share * way for s in (1.0, -1.0)]
    found = [(_turn(step, end, weights), *pull_forces(step, end, weights)) for end in ends]
    return tuple((ahead - behind) / (2.0 * share) for ahead, behind in zip(*found, strict=True))
