"""The clean-up: a garment moved out of the exact body with the smallest, smoothest displacement."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from .body_distance import BodyDistance
from .operators import vertex_areas

SMOOTH_LENGTH = 0.02
"""Length over which a push fades [m]: beyond an edge, so that neighbours follow and no face turns over."""

PUSH = 100.0
"""Weight of a pushed row beside the wish to stay: it goes 60 to 99 % of its way in one round."""

ROUNDS = 15
"""Rounds of the smooth push at most; what is left after three is usually below 0.1 mm."""

HARD_ROUNDS = 10
"""Rounds of moving what is still inside straight out; met only in narrow places such as the crotch."""


def clear_body(
    nodes: np.ndarray, faces: np.ndarray, laplacian: sp.csr_matrix, body: BodyDistance, margin: float
) -> np.ndarray:
    """Move nodes so that no node and no face centre is nearer to the body than a margin.

    Each round finds the nodes and face centres below the margin and solves for the displacement u that minimises
    sum_i m_i |u_i|^2 + s^4 |M^-1/2 L u|^2 + w sum_r m_r |u_r - push_r|^2, which fades smoothly away from them.

    Args:
        nodes: Positions [m], shape [node_count, 3].
        faces: Shape [face_count, 3].
        laplacian: Positive semi-definite Laplacian of the rest triangles.
        body: The exact body.
        margin: Distance to keep [m].

    Returns:
        Positions [m], the given ones where nothing had to move.
    """
    mass = np.maximum(vertex_areas(nodes, faces), 1e-12)
    bending = (laplacian @ sp.diags(1 / mass) @ laplacian).tocsr()
    stay = sp.diags(mass) + SMOOTH_LENGTH**4 * bending
    typical = float(mass.mean())
    x = np.array(nodes)
    for _ in range(ROUNDS):
        rows, push = _pushes(x, faces, body, margin)
        # 0.05 mm short of the margin is at rest: the margin itself is ten times that
        if not len(push) or np.linalg.norm(push, axis=1).max() < 0.1 * margin:
            return x
        system = stay + PUSH * typical * (rows.T @ rows)
        factor = splu(system.tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
        x = x + factor.solve(PUSH * typical * np.asarray(rows.T @ push))
    for _ in range(HARD_ROUNDS):
        rows, push = _pushes(x, faces, body, margin)
        if not len(push) or np.linalg.norm(push, axis=1).max() < margin:
            break
        hit = np.asarray((rows > 0).sum(axis=0)).ravel()
        x = x + np.asarray((rows > 0).T.astype(float) @ push) / np.maximum(hit, 1)[:, None]
    return x


def _pushes(x: np.ndarray, faces: np.ndarray, body: BodyDistance, margin: float) -> tuple[sp.csr_matrix, np.ndarray]:
    """Rows (nodes, then face centres) below the margin and the way each has to go [m]."""
    points = np.concatenate([x, x[faces].mean(axis=1)])
    distance, out, _ = body(points)
    low = np.flatnonzero(distance < margin)
    push = out[low] * (margin - distance[low])[:, None]
    single = low[low < len(x)]
    triple = faces[low[low >= len(x)] - len(x)]
    row = np.concatenate([np.arange(len(single)), len(single) + np.repeat(np.arange(len(triple)), 3)])
    column = np.concatenate([single, triple.reshape(-1)])
    value = np.concatenate([np.ones(len(single)), np.full(triple.size, 1 / 3)])
    return sp.csr_matrix((value, (row, column)), shape=(len(low), len(x))), push
