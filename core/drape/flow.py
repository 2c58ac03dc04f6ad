"""Move cloth out of a body as a current carries it: all layers alike, so that none passes another."""

from __future__ import annotations

import numpy as np

from ..body import SignedDistance
from ..mesh import self_intersections
from .follow import Threads, undo_crossings

STEP = 2e-3
"""Longest move in a round [m]: over the width of the current a strain of a few per cent, so nothing folds over."""

DEEP = 0.0
"""Distance [m] below which cloth is carried out."""


def flow_out(
    threads: Threads, nodes: np.ndarray, body: SignedDistance, rounds: int, clearance: float = 1e-3
) -> np.ndarray:
    """Carry cloth that is inside a body out of it, with all cloth around it, and give the nodes [m], [node_count, 3].

    Each low point i (a node, or a face's centre) wants the move m_i out of the body. The current is their mean, by
    nearness, and fades with the distance to them: u(x) = max_i w_i sum_i w_i m_i / sum_i w_i with
    w_i = exp(-|x - x_i|^2 / 2 h^2), h the mean edge. It is a smooth map of space in small steps, which takes layers
    that lie on each other along without passing them through each other; where a coarse triangle does not follow it
    well enough, its step is undone.

    Args:
        threads: The cloth.
        nodes: Positions [m], shape [node_count, 3].
        body: Where it is; of the surfaces that it shows a point only the first counts.
        rounds: Rounds at most; each moves up to 2 mm.
        clearance: Distance to reach [m].
    """
    faces = threads.faces
    width = float(np.mean(threads.lengths[: len(threads.edges)]))
    nodes = np.array(nodes)
    crossed: np.ndarray | None = None
    for _ in range(rounds):
        points = np.concatenate([nodes, nodes[faces].mean(axis=1)])
        distance, normal = (values[: len(points)] for values in body.measure(points))
        low = np.flatnonzero(distance < DEEP)
        if not len(low):
            break
        if crossed is None:
            crossed = self_intersections(nodes, faces)
        move = np.minimum(clearance - distance[low], STEP)[:, None] * normal[low]
        square = ((nodes[:, None] - points[low]) ** 2).sum(axis=2)
        nearness = np.exp(-0.5 * square / width**2)
        share = nearness.max(axis=1) / np.maximum(nearness.sum(axis=1), 1e-300)
        moved = nodes + share[:, None] * (nearness @ move)
        undo_crossings(moved, nodes, faces, crossed)
        if np.array_equal(moved, nodes):
            break
        nodes = moved
    return nodes
