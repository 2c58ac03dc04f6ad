"""Smooth cloth that crosses itself after dressing."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from ...body.signed_distance import SignedDistance
from ...geometry.connectivity import adjacency_matrix
from ...geometry.intersections import self_intersections
from ...geometry.linear import factor_symmetric
from .layer_contact import LayerContact
from .pbd import DistanceConstraints, PbdSettings, PbdState, simulate_pbd

MAX_UNFOLD_ITERATIONS = 6
"""Largest number of iterations; one is enough for the crotches of all shipped trousers, at 350 to 1500 nodes."""

UNFOLD_STEP_COUNT = 5
"""Number of position-based steps that restore a patch's rest lengths after each iteration."""


def unfold_crossings(
    threads: DistanceConstraints,
    nodes: np.ndarray,
    body: SignedDistance,
    *,
    settings: PbdSettings,
    pins: np.ndarray | None = None,
) -> np.ndarray:
    """Smooth patches that cross themselves, and restore their lengths with layers kept apart.

    Trouser panels are flattened before they are worn; their crotches, worn from front to back, are crumpled into the
    plane and cross themselves. Once the body has its size there is room for them: a patch around the crossings becomes
    a minimal surface (least sum of |x_i - x_j|^2 over its edges), which does not cross where its rim does not.

    Args:
        threads: The cloth.
        nodes: Positions [m], shape [node_count, 3].
        body: Signed distance to the body.
        settings: The position-based steps.
        pins: Nodes that do not move, or None.

    Returns:
        Positions [m], shape [node_count, 3]; the given ones where nothing crosses.
    """
    count = len(nodes)
    laplacian = sparse.csr_matrix(sparse.csgraph.laplacian(adjacency_matrix(threads.edges, count)))
    for turn in range(MAX_UNFOLD_ITERATIONS):
        crossed = self_intersections(nodes, threads.faces)
        if not len(crossed):
            break
        loose = _patch(threads.faces, crossed, 1 + turn // 2, count)
        if pins is not None:
            loose[pins] = False
        free, rim = np.flatnonzero(loose), np.flatnonzero(~loose)
        if not len(free) or not len(rim):
            break
        nodes = nodes.copy()
        nodes[free] = factor_symmetric(laplacian[free][:, free]).solve(-(laplacian[free][:, rim] @ nodes[rim]))
        start = PbdState.at_rest(nodes)
        nodes = simulate_pbd(
            threads, start, body, UNFOLD_STEP_COUNT, settings=settings, pins=pins, layers=LayerContact()
        ).nodes
    return nodes


def _patch(faces: np.ndarray, crossed: np.ndarray, rings: int, count: int) -> np.ndarray:
    """Find the nodes of crossed faces and of some rings of faces around them, shape [count]."""
    inside = np.zeros(count, dtype=bool)
    inside[faces[crossed]] = True
    for _ in range(rings):
        inside[faces[inside[faces].any(axis=1)]] = True
    return inside
