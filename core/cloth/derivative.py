"""Derivatives of a drape through its equilibrium, by the implicit function theorem."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.sparse import csr_matrix

from ..geometry.linear import Solver, SuperLU
from .collision.cloth_friction import ClothFriction
from .collision.coupling import extend_sparsity
from .energy import Energy, Inertia
from .factorisation import factor_regularised
from .friction import Friction, lag_friction
from .rest import NotAtRest, RestSettings, find_rest
from .scene import Scene
from .sensitivity import Sensitivity, fabric_forces, pull_forces, push_forces
from .solver import make_solver
from .topology import Topology

__all__ = ["Derivative", "FactoredEquilibrium", "ImplicitDerivative", "Response"]


class Response(Protocol):
    """Describe the positions of a solved cloth, with the derivative of a loss by all that they depend on."""

    @property
    def nodes(self) -> np.ndarray:
        """Return the positions [m], shape [node_count, 3]."""

    def pull(self, upstream: np.ndarray) -> Sensitivity:
        """Return a loss's derivative by everything, from that by the positions [1/m], shape [node_count, 3]."""


class Derivative(Protocol):
    """Solve for the cloth's positions in a way that can be differentiated."""

    def solve(
        self, scene: Scene, nodes: np.ndarray, solver: Solver | None = None, *, friction: Friction | None = None
    ) -> Response:
        """Solve from nodes [m], shape [node_count, 3], for the positions at which the derivative is taken. The friction
        is constant (`lag_friction` where a drape stopped), or None."""


@dataclass(frozen=True)
class ImplicitDerivative:
    """Differentiate the quasi-static equilibrium g(x*; p) = dE/dx = 0.

        dx*/dp = -K^-1 dg/dp,    dL/dp = -lambda . dg/dp  with  K lambda = dL/dx

    K is the exact Hessian at x*, including contact, pins and lagged friction: one factorisation, then a
    back-substitution per parameter (`FactoredEquilibrium.push`) or per loss (`pull`). Friction's limits and anchors are
    constants, as in the last iterations of `equilibrium`.

    **Deviation**: the thesis differentiates 20 time steps, as `UnrolledSteps` does. At rest both give the same gradient
    (docs/concepts/simulation.md).

    Attributes:
        tolerance: Largest force left on a node, relative to the mean weight of a node. It displaces the point at which
            the derivative is taken and adds no other error, so 1e-5 is enough. 0: all that round-off allows (about
            1e-10 at 1000 nodes), for difference quotients.
        max_iterations: Largest number of matrices factored by `solve`.
    """

    tolerance: float = 1e-5
    max_iterations: int = 200

    def solve(
        self,
        scene: Scene,
        nodes: np.ndarray,
        solver: Solver | None = None,
        *,
        friction: Friction | None = None,
        inertia: Inertia | None = None,
        rubbing: ClothFriction | None = None,
    ) -> FactoredEquilibrium:
        """Solve for the equilibrium from nodes near it [m], shape [node_count, 3], with constant friction on the body
        and, `rubbing`, of cloth on cloth. With inertia the solution is that of one implicit time step.

        Raises:
            NotAtRest: where the force left stays above the tolerance.
        """
        energy = Energy(scene, friction, inertia, rubbing)
        solver = solver or make_solver(scene.topology.pattern)
        nodes = place_pinned(scene, nodes)
        while True:
            energy, solver = extend_sparsity(energy, solver, nodes, missing=0.0)
            nodes = find_rest(energy, nodes, solver, RestSettings(self.tolerance, self.max_iterations))
            energy, complete = energy.watch(nodes), solver
            energy, solver = extend_sparsity(energy, solver, nodes, missing=0.0)
            if solver is complete:
                break
        blocks = energy.hessian(nodes)[2]
        return FactoredEquilibrium(energy, nodes, blocks, factor(energy, blocks, solver))


@dataclass(frozen=True)
class FactoredEquilibrium:
    """Describe an equilibrium with its factored Hessian.

    Attributes:
        nodes: Positions [m], shape [node_count, 3].
        blocks: The exact Hessian's blocks [N/m], for `Topology.assemble`.
        solver: Has the Hessian's factors, until another matrix is factored with it.
    """

    energy: Energy
    nodes: np.ndarray
    blocks: np.ndarray
    solver: Solver

    @property
    def scene(self) -> Scene:
        """Return the scene that is at rest."""
        return self.energy.scene

    def pull(self, upstream: np.ndarray) -> Sensitivity:
        """Return a loss's derivative by everything, from that by the positions [1/m], shape [node_count, 3]."""
        weights = adjoint(self.scene, self.solver, upstream)
        rest, fabric = pull_forces(self.energy, self.nodes, weights)
        return Sensitivity(
            -rest, -fabric, pull_pins(self.scene, self.blocks, weights, upstream), np.zeros_like(weights)
        )

    def push(self, rest_rates: np.ndarray | None = None, fabric_rates: np.ndarray | None = None) -> np.ndarray:
        """Return dx*/dp [m per unit], shape [node_count, 3, direction_count], along directions of the parameters.
        `rest_rates`: of the flat triangles [m], shape [face_count, 3, 2, direction_count]. `fabric_rates`: of
        `FABRIC_PARAMETERS`, shape [6, direction_count]. Where both are given their directions are the same ones."""
        if rest_rates is None and fabric_rates is None:
            raise ValueError("push needs directions of the rest shape, of the fabric or of both")
        parts = []
        if rest_rates is not None:
            parts.append(push_forces(self.energy, self.nodes, rest_rates))
        if fabric_rates is not None:
            parts.append(fabric_forces(self.energy, self.nodes) @ fabric_rates)
        forces = np.sum(parts, axis=0)
        forces[self.scene.fixed] = 0.0
        return -self.solver.solve(forces.reshape(forces.shape[0] * 3, -1)).reshape(forces.shape)


def linearise_at(scene: Scene, nodes: np.ndarray, anchors: np.ndarray, solver: Solver) -> FactoredEquilibrium:
    """Linearise where a drape stopped, at nodes and anchors [m], shape [node_count, 3], without solving further. The
    largest positive definite share of the exact Hessian is factored: all of it where the cloth is at rest. Elsewhere a
    pulled-back loss derivative is still a direction of descent."""
    energy, solver = extend_sparsity(Energy(scene, lag_friction(scene, nodes, anchors)), solver, nodes, missing=0.0)
    energy = energy.lag_friction(nodes)
    blocks = energy.hessian(nodes)[2]
    factor_regularised(energy, solver, nodes, blocks, 1.0)
    return FactoredEquilibrium(energy, nodes, blocks, solver)


def factor(energy: Energy, blocks: np.ndarray, solver: Solver) -> Solver:
    """Factor an exact Hessian and return the solver with its factors: `SuperLU` for an indefinite one (unstable rest).

    Raises:
        NotAtRest: where the Hessian is singular: the cloth is free to move.
    """
    topology = energy.scene.topology
    data = topology.assemble(blocks, energy.scene.fixed)
    if solver.factor(data):
        return solver
    general = SuperLU(topology.pattern.indptr, topology.pattern.indices)
    if not general.factor(data):
        raise NotAtRest("the cloth is free to move; hold it, or lay it on a body.")
    return general


def adjoint(scene: Scene, solver: Solver, upstream: np.ndarray) -> np.ndarray:
    """Solve K lambda = dL/dx (thesis eq. 2.28; K is symmetric), shape [node_count, 3]; zero where nodes are fixed."""
    right = np.array(upstream, dtype=np.float64)
    right[scene.fixed] = 0.0
    return np.asarray(solver.solve(right.ravel())).reshape(-1, 3)


def place_pinned(scene: Scene, nodes: np.ndarray) -> np.ndarray:
    """Return a copy of nodes [m], shape [node_count, 3], with fixed nodes at their pinned points."""
    nodes = np.array(nodes, dtype=np.float64)
    if scene.pins is not None and scene.pins.stiffness is None:
        nodes[scene.pins.nodes] = scene.pins.points
    return nodes


def pull_pins(scene: Scene, blocks: np.ndarray, weights: np.ndarray, upstream: np.ndarray) -> np.ndarray:
    """Compute the derivative by the pinned points [1/m], shape [pin_count, 3]. Fixed: dL/dx_h - K_hf lambda_f, since
    x_h is the point itself. On springs: stiffness lambda_h."""
    pins = scene.pins
    if pins is None:
        return np.zeros((0, 3))
    if pins.stiffness is not None:
        found: np.ndarray = pins.stiffness * np.array(pins.directions) * weights[pins.nodes]
        return found
    topology = scene.topology
    data = topology.assemble(blocks, np.zeros(len(weights), dtype=bool))
    found = upstream[pins.nodes] - (matrix_of(topology, data) @ weights.ravel()).reshape(-1, 3)[pins.nodes]
    return found


def matrix_of(topology: Topology, data: np.ndarray) -> csr_matrix:
    """Return the sparse matrix with these entries, shape [3 node_count, 3 node_count]."""
    return csr_matrix((data, topology.pattern.indices, topology.pattern.indptr), shape=(3 * topology.node_count,) * 2)
