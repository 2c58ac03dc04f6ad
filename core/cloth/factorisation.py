"""Factor the largest positive definite share of the exact Hessian of the cloth's energy."""

from __future__ import annotations

import numpy as np

from ..geometry.linear import Solver
from .energy import Energy

_EXACT_SHARE_DECAY_FACTOR = 0.6
"""Factor on the exact share after each indefinite matrix; below a tenth only the PSD form is factored."""


def factor_regularised(energy: Energy, solver: Solver, nodes: np.ndarray, blocks: np.ndarray, share: float) -> float:
    """Factor the largest definite share of the exact Hessian and return it; -1 where nothing can be factored. The
    matrix is share K + (1 - share) K_psd: the exact Hessian is indefinite on compressed cloth. `blocks` is the exact
    Hessian where `share` > 0, else the PSD form. Slack cloth makes the PSD form singular, so it is shifted, first by a
    node's weight per metre, which is negligible against the cloth's stiffness."""
    scene = energy.scene
    topology, fixed = scene.topology, scene.fixed
    if share >= 1.0:
        if solver.factor(topology.assemble(blocks, fixed)) and solver.is_positive_definite():
            return 1.0
        share = _EXACT_SHARE_DECAY_FACTOR
    psd = energy.hessian(nodes, False)[2] if share > 0 else blocks
    shift = scene.mean_weight
    psd[topology.pattern.diagonal] += shift * np.eye(3)
    while True:
        mixed = share * blocks + (1.0 - share) * psd if share > 0 else psd
        if solver.factor(topology.assemble(mixed, fixed)) and solver.is_positive_definite():
            return share
        if share > 0:
            share = share * _EXACT_SHARE_DECAY_FACTOR if share > 0.1 else 0.0
        elif shift > 1e12 * scene.mean_weight:
            return -1.0
        else:
            psd[topology.pattern.diagonal] += 99.0 * shift * np.eye(3)
            shift *= 100.0
