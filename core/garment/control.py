"""Linear map from control points to a panel's mesh: thesis eq. 3.1 on the outline, mean value coordinates inside."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import block_diag, csr_matrix

from .curves import edge_points, relative_to_chord
from .garment import Garment
from .memo import memoise
from .pattern import EdgeRef, Pattern

MEAN_VALUE_CHUNK_SIZE = 1000
"""Number of points whose mean value coordinates are computed at once: 10 MB on the finest panels."""


@dataclass(frozen=True)
class ControlMap:
    """Describe the linear map from all control points to all uv vertices.

        u = M c,    u and c stacked as x0, y0, x1, y1, ...

    A boundary vertex keeps its relative position (alpha, beta) on the chord of its edge (thesis eq. 3.1, both divided
    by the squared chord, so that they have no unit), v = c_i + alpha x_i + beta R90 x_i. An inner vertex is the average
    of its panel's boundary vertices by mean value coordinates. Both reproduce every similarity of the control points
    exactly, and affine maps too on panels without curves. The map depends on the flat mesh alone.

    **Deviation** The thesis updates inner vertices iteratively; mean value coordinates are an explicit linear map.

    Attributes:
        matrix: M, shape [2 uv_count, 2 point_count].
        points: The control points it was computed at [m], shape [point_count, 2].
    """

    matrix: csr_matrix
    points: np.ndarray

    def apply(self, points: np.ndarray) -> np.ndarray:
        """Return the uv vertices [m], shape [uv_count, 2], for moved control points [m], shape [point_count, 2]."""
        found: np.ndarray = (self.matrix @ np.asarray(points, float).ravel()).reshape(-1, 2)
        return found

    def pull_back(self, gradient: np.ndarray) -> np.ndarray:
        """Return the derivative by the control points, shape [point_count, 2], from that by uv, shape [uv_count, 2]."""
        found: np.ndarray = (self.matrix.T @ np.asarray(gradient, float).ravel()).reshape(-1, 2)
        return found


@memoise
def map_controls(garment: Garment) -> ControlMap:
    """Compute the control map of a flat mesh."""
    blocks = []
    for index, panel in enumerate(garment.pattern.panels):
        weights = np.zeros((len(garment.uv), len(panel.points)), complex)
        for i in range(len(panel.edges)):
            along = garment.edge_uv[EdgeRef(panel.name, i)][:-1]
            after = (i + 1) % len(panel.points)
            place = relative_to_chord(garment.uv[along], panel.points[i], panel.points[after]) @ np.array([1.0, 1j])
            weights[along, i] = 1.0 - place
            weights[along, after] += place
        spread_inside(garment, index, weights)
        blocks.append(_as_real(weights[garment.panel_of_uv == index]))
    return ControlMap(csr_matrix(block_diag(blocks, format="csr")), garment.pattern.points)


def update_flat_mesh(garment: Garment, pattern: Pattern) -> Garment:
    """Return a garment whose flat mesh follows its pattern's changed curves; faces and nodes stay. Outline vertices are
    on the new curves, uniform in arc length as in the mesh; an inner vertex moves by the average of its panel's outline
    by mean value coordinates.

    Args:
        garment: The garment.
        pattern: The same panels, seams and kinds of corners, with slightly different points and edge shapes.
    """
    moved = np.zeros_like(garment.uv)
    for index, panel in enumerate(pattern.panels):
        for i in range(len(panel.edges)):
            along = garment.edge_uv[EdgeRef(panel.name, i)]
            moved[along[:-1]] = edge_points(panel, i, len(along) - 1)[:-1] - garment.uv[along[:-1]]
        spread_inside(garment, index, moved)
    return replace(garment, pattern=pattern, uv=garment.uv + moved)


def spread_inside(garment: Garment, panel: int, values: np.ndarray) -> None:
    """Set values at a panel's inner vertices to the average of its outline's, by mean value coordinates.

    Args:
        garment: The flat mesh.
        panel: Index of the panel.
        values: At all uv vertices, shape [uv_count, ...]; those of the panel's outline are given.
    """
    points, drawn = np.flatnonzero(garment.panel_of_uv == panel), garment.pattern.panels[panel]
    rim = np.concatenate([garment.edge_uv[EdgeRef(drawn.name, i)][:-1] for i in range(len(drawn.edges))])
    inner = np.setdiff1d(points, rim)
    for part in np.array_split(inner, len(inner) // MEAN_VALUE_CHUNK_SIZE + 1):
        values[part] = np.tensordot(mean_value_coordinates(garment.uv[rim], garment.uv[part]), values[rim], 1)


def mean_value_coordinates(polygon: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return mean value coordinates of points inside a simple polygon (Floater 2003; Hormann and Floater 2006).

        w_k = (tan(a_{k-1} / 2) + tan(a_k / 2)) / |v_k - p|,    lambda_k = w_k / sum w

    a_k: signed angle at p from polygon vertex v_k to v_{k+1}. The tangent of the half angle is (1 - cos) / sin,
    computed as cross / (r r' + dot), which has no pole inside.

    Args:
        polygon: Vertices [m], shape [m, 2].
        points: Points [m], shape [n, 2].

    Returns:
        The coordinates, rows sum to 1, shape [n, m].
    """
    offset = polygon[None] - points[:, None]
    after = np.roll(offset, -1, axis=1)
    radius = np.linalg.norm(offset, axis=2)
    cross = offset[..., 0] * after[..., 1] - offset[..., 1] * after[..., 0]
    dot = (offset * after).sum(axis=2)
    tangent = cross / (radius * np.roll(radius, -1, axis=1) + dot)
    weight = (tangent + np.roll(tangent, 1, axis=1)) / radius
    found: np.ndarray = weight / weight.sum(axis=1, keepdims=True)
    return found


def _as_real(weights: np.ndarray) -> np.ndarray:
    """Return a complex matrix as the real one on interleaved (x, y): p + iq becomes [[p, -q], [q, p]]."""
    rows, columns = weights.shape
    real = np.zeros((rows, 2, columns, 2))
    real[:, 0, :, 0] = real[:, 1, :, 1] = weights.real
    real[:, 1, :, 0] = weights.imag
    real[:, 0, :, 1] = -weights.imag
    return real.reshape(2 * rows, 2 * columns)
