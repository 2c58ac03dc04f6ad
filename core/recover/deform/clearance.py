"""Move a garment out of the exact body by the smallest, smoothest displacement."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from ...body.exposed import ExposedSurface
from ...geometry.connectivity import HalfEdges
from ...geometry.geometry import bending_matrix, vertex_areas
from ...geometry.linear import analyse_pattern, factor_symmetric
from .settings import ClearanceSettings
from .strain_limits import find_strain_violations

PUSH_REVERSAL_COSINE = -0.5
"""Cosine between two successive pushes of one point below which the second reverses the first."""


class ProximityCache:
    """Find points nearer to the body than a margin, with new distance queries only where a point may have come so near.

    A distance changes no faster than its point moves: a point at distance d that has since moved by less than d minus
    the margin is still outside the margin. A point that is pushed back the way it came is in a gap narrower than two
    margins between two parts of the body: its margin is halved, so that it comes to rest in between.
    """

    def __init__(self, faces: np.ndarray, body: ExposedSurface, margin: float) -> None:
        self.faces, self.margin = faces, margin
        self._body = body
        self._places: np.ndarray | None = None

    def pushes(self, x: np.ndarray) -> tuple[sp.csr_matrix, np.ndarray, float]:
        """Return rows (nodes, then face centres) below their margins, their displacements [m], the greatest depth."""
        faces = self.faces
        points = np.concatenate([x, x[faces].mean(axis=1)])
        if self._places is None:
            self._places, self._known = points.copy(), np.full(len(points), -np.inf)
            self._margins, self._ways = np.full(len(points), self.margin), np.zeros_like(points)
        certain = self._known - np.linalg.norm(points - self._places, axis=1)
        queried = np.flatnonzero(certain < self._margins)
        distance, out = self._body.measure(points[queried])
        self._places[queried], self._known[queried] = points[queried], distance
        below = distance < self._margins[queried]
        low, distance, out = queried[below], distance[below], out[below]
        back = low[(out * self._ways[low]).sum(1) < PUSH_REVERSAL_COSINE]
        self._margins[back] *= 0.5
        self._ways[low] = out
        push = out * np.maximum(self._margins[low] - distance, 0.0)[:, None]
        single = low[low < len(x)]
        triple = faces[low[low >= len(x)] - len(x)]
        row = np.concatenate([np.arange(len(single)), len(single) + np.repeat(np.arange(len(triple)), 3)])
        column = np.concatenate([single, triple.reshape(-1)])
        value = np.concatenate([np.ones(len(single)), np.full(triple.size, 1 / 3)])
        rows = sp.csr_matrix((value, (row, column)), shape=(len(low), len(x)))
        return rows, push, float(-distance.min(initial=0.0))


def enforce_clearance(
    nodes: np.ndarray,
    gradient: sp.csr_matrix,
    areas: np.ndarray,
    watch: ProximityCache,
    settings: ClearanceSettings,
    ease: bool = True,
) -> np.ndarray:
    """Move nodes so that no node and no face centre is nearer to the body than a margin.

    Each round finds the nodes and face centres below the margin and the triangles out of their bounds of stretch, and
    solves for the displacement u that minimises
        sum_i m_i |u_i|^2 + s^4 |M^-1/2 L u|^2 + w sum_r m |u_r - push_r|^2 + h sum_f A_f |(G (x + u))_f - P_f|^2,
    which fades smoothly away from them; P_f as in `limit_strain`. Both are solved together: where parts of the body
    touch, the way out is long, and triangles that are only pushed are torn.

    Args:
        nodes: Positions [m], shape [node_count, 3].
        gradient: Positions to Jacobian rows, shape [2 face_count, node_count].
        areas: Rest areas [m2], shape [face_count].
        watch: The faces, the exact body and the margin.
        settings: Weights and bounds.
        ease: Keep triangles within their bounds.

    Returns:
        Positions [m], unchanged where nothing had to move. If no round cleared all, those of the round with the least
        depth beyond half the margin, then the fewest triangles out of bounds.
    """
    laplacian = (gradient.T @ sp.diags(np.repeat(areas, 2)) @ gradient).tocsr()
    mass = np.maximum(vertex_areas(nodes, watch.faces), 1e-12)
    stay = sp.diags(mass) + settings.fade**4 * bending_matrix(laplacian, 1 / mass)
    typical = float(mass.mean())
    x, weight, shallowest = np.array(nodes), settings.push * typical, np.inf
    best, least = x, (np.inf, 0)
    solver = analyse_pattern(HalfEdges.of(watch.faces, len(nodes)), rings=2)
    for _ in range(settings.iterations + 1):
        rows, push, depth = watch.pushes(x)
        wrong, change = find_strain_violations(x, gradient, areas, settings.least_stretch, settings.most_stretch)
        wrong &= ease
        # 0.1 mm short of the margin counts as cleared: the margin is ten times that
        if np.linalg.norm(push, axis=1).max(initial=0.0) < 0.1 * watch.margin and not wrong.any():
            return x
        remaining = settings.gap_depth * watch.margin
        left = (max(depth - remaining, 0.0), int(wrong.sum()))
        if left < least:
            best, least = x, left
        weight *= settings.push_growth if depth > max(remaining, settings.stalled * shallowest) else 1.0
        shallowest = min(shallowest, depth)
        pull = (gradient.T @ sp.diags(np.repeat(settings.strain * areas * wrong, 2))).tocsr()
        system = stay + weight * (rows.T @ rows) + pull @ gradient
        factor = factor_symmetric(system, solver)
        x = x + factor.solve(weight * np.asarray(rows.T @ push) + pull @ change)
    return best
