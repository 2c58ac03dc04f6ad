"""Move cloth along with its wearer's skin, as far as no two parts of it collide."""

from __future__ import annotations

import numpy as np

from ..run.kernels import kernel
from .collision.collision_free_step import collision_free_share
from .energy import Energy

MAX_HOLD_BACK_ITERATIONS = 6
"""Largest number of iterations that shorten the displacement of colliding parts. Shortening one part's displacement
brings it nearer to the next part."""

MAX_EDGE_ADVANCE_SHARE = 0.25
"""Largest difference of the shares of displacement [1] of two neighbouring nodes. Around a collision the share so
changes over four edges."""


def move_collision_free(energy: Energy, nodes: np.ndarray, goal: np.ndarray) -> tuple[Energy, np.ndarray]:
    """Return positions on the straight paths from nodes to goals [m], [node_count, 3], up to which no two parts
    collide. Where cloth would collide (a sleeve that moves against the trunk), only the colliding parts stop short, and
    their neighbours by less with each edge. One share for the whole cloth would leave all of it behind, inside limbs
    that have moved. Also returns the energy with the near pairs of the path."""
    if energy.scene.self_contact is None:
        return energy, goal
    displacement, share = goal - nodes, np.ones(len(nodes))
    sides = energy.scene.self_contact.edges
    for turn in range(MAX_HOLD_BACK_ITERATIONS + 1):
        step = share[:, None] * displacement
        energy, free = energy.free_share(nodes, step)
        if free == 1.0 or turn == MAX_HOLD_BACK_ITERATIONS:
            break
        assert energy.near is not None
        pairs = energy.near.pairs
        found = _find_pair_shares(nodes, step, pairs)
        met = found < 1.0
        np.minimum.at(share, pairs.nodes[met], (share[pairs.nodes[met]].max(axis=1) * found[met])[:, None])
        for _ in range(int(1.0 / MAX_EDGE_ADVANCE_SHARE)):
            low = share.copy()
            for one, other in (sides.T, sides.T[::-1]):
                np.minimum.at(low, one, share[other] + MAX_EDGE_ADVANCE_SHARE)
            share = low
    return energy, goal if free == 1.0 and (share == 1.0).all() else nodes + free * step


@kernel()
def _find_pair_shares(x, step, pairs):  # type: ignore[no-untyped-def]
    """Return the largest share of a step [m] that each pair may go, 0 to 1, shape [pair_count]."""
    kinds, nodes, sizes = pairs
    found = np.ones(len(kinds))
    for n in range(len(kinds)):
        found[n] = collision_free_share(x, step, (kinds[n : n + 1], nodes[n : n + 1], sizes[n : n + 1]))
    return found
