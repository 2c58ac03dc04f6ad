"""The thesis' time steps, one linear system each, with the full adjoint of such a step (eq. 3.2, 2.27 to 2.30)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..geometry.linear import Solver
from .derivative import adjoint, matrix_of, place_pinned
from .energy import Energy
from .rest import NotAtRest
from .sensitivity import Sensitivity, pull_forces
from .steps import TimeSteps

__all__ = ["LinearisedSteps"]

HESSIAN_DIFFERENCE_STEP = 1e-7
"""Largest motion of a node for a difference of Hessians [m]: forces change over millimetres (contact's thickness), so
its relative error is 1e-9, and round-off's 1e-10."""


@dataclass(frozen=True)
class LinearisedSteps(TimeSteps):
    """Differentiate linearised implicit Euler steps one by one, backwards in time, as the thesis does.

        A_t (x_t - x_{t-1}) = -g_t(x_{t-1}),    A_t = M / dt^2 + K(x_{t-1}),    g_t the step's gradient

    Such a step leaves forces on the nodes, so the derivative of its matrix matters (eq. 2.30):

        A_t lambda = dL/dx_t,    dL/dx_{t-1} += dL/dx_t - H_t lambda - d(lambda . P d_t)/dx,
        dL/dp -= lambda . dg_t/dp + d(lambda . A_t d_t)/dp,    d_t = x_t - x_{t-1}

    with H_t the exact Hessian of the step's energy; g_t and dL/dy_t = M lambda / dt^2 as in `UnrolledSteps`. A step
    costs one iteration of a converged one. The gradient is that of the computed path, even if its end is not at rest.

    **Deviation**: K is the exact Hessian, as in the thesis, only where A is positive definite with it, else the PSD
    form: compressed cloth then also has a step, though a shorter one.
    """

    def _advance(self, step: Energy, nodes: np.ndarray, solver: Solver) -> np.ndarray:
        placed = place_pinned(step.scene, nodes)
        _, gradient = _factor(step, placed, solver)
        found: np.ndarray = placed - adjoint(step.scene, solver, gradient)
        return found

    def pull_step(
        self, step: Energy, start: np.ndarray, end: np.ndarray, bar: np.ndarray, solver: Solver
    ) -> tuple[np.ndarray, Sensitivity]:
        """Pull dL/d(end), `bar`, [node_count, 3], back (`TimeSteps`); that by fixed nodes is by their pinned points."""
        from .hessian_form import pull_form

        placed, pins = place_pinned(step.scene, start), step.scene.pins
        exact, _ = _factor(step, placed, solver)
        weights = adjoint(step.scene, solver, bar)
        if exact:
            by_nodes, by_rest, by_fabric = _pull_exact(step, placed, weights, end - placed)
        else:
            by_nodes, by_rest, by_fabric = pull_form(step, placed, weights, end - placed)[1]
        rest, fabric = pull_forces(step, placed, weights)
        back, by_pins = bar - _hessian_product(step, placed, weights) - by_nodes, np.zeros((0, 3))
        if pins is not None and pins.stiffness is not None:
            by_pins = pins.stiffness * np.array(pins.directions) * weights[pins.nodes]
        elif pins is not None:
            by_pins, back[pins.nodes] = back[pins.nodes].copy(), 0.0
        return weights, Sensitivity(-rest - by_rest, -fabric - by_fabric, by_pins, back)


def _factor(step: Energy, nodes: np.ndarray, solver: Solver) -> tuple[bool, np.ndarray]:
    """Factor a step's Hessian at nodes [m]; return whether it is the exact one, and the step's gradient [N]."""
    for exact in (True, False):
        _, gradient, blocks = step.hessian(nodes, exact)
        if solver.factor(step.scene.topology.assemble(blocks, step.scene.fixed)) and solver.is_positive_definite():
            return exact, gradient
    raise NotAtRest("a step's matrix cannot be factored: take shorter steps.")


def _hessian_product(step: Energy, nodes: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Multiply the exact Hessian at nodes [m] with weights, shape [node_count, 3]; rows of fixed nodes are kept."""
    free = np.zeros(len(nodes), dtype=bool)
    topology = step.scene.topology
    data = topology.assemble(step.hessian(nodes)[2], free)
    return np.asarray((matrix_of(topology, data) @ weights.ravel()).reshape(-1, 3))


def _pull_exact(step: Energy, nodes: np.ndarray, weights: np.ndarray, direction: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return the derivative of weights . H way as `pull_form` does: that of weights . g, differentiated along
    `direction`. H is the derivative of g, so the order can be exchanged; the outer derivative is a central difference
    over `HESSIAN_DIFFERENCE_STEP`."""
    length = float(np.sqrt((direction**2).sum(1).max()))
    if length == 0.0:
        return tuple(np.zeros_like(part) for part in (nodes, *pull_forces(step, nodes, weights)))
    share = HESSIAN_DIFFERENCE_STEP / length
    ends = [nodes + s * share * direction for s in (1.0, -1.0)]
    found = [(_hessian_product(step, end, weights), *pull_forces(step, end, weights)) for end in ends]
    return tuple((ahead - behind) / (2.0 * share) for ahead, behind in zip(*found, strict=True))
