"""Extend the sparsity pattern of the matrix by the pairs of cloth in contact."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...geometry.linear import Solver
from ..block_pattern import ABSENT_BLOCK_SLOT
from ..solver import make_solver

if TYPE_CHECKING:
    from ..energy import Energy

_MAX_MISSING_PAIR_SHARE = 0.1
"""Share of the pairs in contact that may be absent from the pattern before it is rebuilt. Rebuilding costs as much as
three factorisations (80 ms for 22 at 4000 nodes); an absent pair resists motion as if its other side were fixed."""


def extend_sparsity(
    energy: Energy, solver: Solver | None, nodes: np.ndarray, missing: float = _MAX_MISSING_PAIR_SHARE
) -> tuple[Energy, Solver]:
    """Return the energy with its pairs near nodes [m], shape [node_count, 3], and a solver whose pattern has them. Both
    are returned unchanged where nothing touches, or where at most a share `missing` of the pairs in contact is absent.
    A missing solver is made here, so that for cloth in contact at the start the matrix is analysed once; in single
    precision, for descent needs no more of a preconditioner."""
    cloth, topology = energy.scene.self_contact, energy.scene.topology
    if cloth is None:
        return energy, solver or make_solver(topology.pattern, single=True)
    energy = energy.watch(nodes)
    assert energy.near is not None
    touching = energy.near.within(nodes, 0.0)
    absent = (
        (topology.pattern.find_slots(touching.nodes)[:, 0] == ABSENT_BLOCK_SLOT).sum() if len(touching.kinds) else 0
    )
    if absent <= missing * len(touching.kinds):
        return energy, solver or make_solver(topology.pattern, single=True)
    wide = energy.near.within(nodes, cloth.margin)
    coupled = topology.couple(wide.nodes)
    single = solver is None or solver.single
    return replace(energy, scene=replace(energy.scene, topology=coupled)), make_solver(coupled.pattern, single)
