"""Solver of the cloth's symmetric sparse systems, whose entries are 3x3 blocks."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .block_pattern import BlockPattern

if TYPE_CHECKING:
    from ..geometry.multifrontal import Cholesky

__all__ = ["make_solver"]


def make_solver(pattern: BlockPattern, single: bool = False) -> Cholesky:
    """Return the fastest solver for definite matrices of a pattern, analysed; in single precision on request. It
    refuses an indefinite matrix, as descent needs; an adjoint with an indefinite Hessian takes `SuperLU`."""
    from ..geometry.multifrontal import Cholesky

    return Cholesky(pattern.indptr, pattern.indices, block=3, single=single)
