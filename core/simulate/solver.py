"""The solver of the cloth's symmetric sparse systems, whose entries come in 3x3 blocks."""

from __future__ import annotations

from ..mesh.linear import Solver, SuperLU
from .topology import Topology

__all__ = ["Solver", "SuperLU", "make_solver"]


def make_solver(topology: Topology) -> Solver:
    """Return the quickest solver for definite matrices of a mesh, with the pattern analysed.

    It refuses an indefinite matrix, as descent must; an adjoint at an equilibrium with an indefinite Hessian takes
    `SuperLU`.
    """
    from ..mesh.multifrontal import Cholesky

    return Cholesky(topology.indptr, topology.indices, block=3)
