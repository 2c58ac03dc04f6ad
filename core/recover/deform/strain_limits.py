"""Correct triangles out of their bounds of stretch, and smooth folds that cross themselves."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from ...geometry.geometry import bending_matrix, vertex_areas
from ...geometry.linear import factor_symmetric
from .acceptance import falloff_weights, find_crossing_faces
from .settings import EasingSettings


def limit_strain(
    nodes: np.ndarray, gradient: sp.csr_matrix, areas: np.ndarray, faces: np.ndarray, settings: EasingSettings
) -> np.ndarray:
    """Bring triangles with singular values out of bounds back to them, moving the others as little as possible.

    Each round solves for the displacement u that minimises
        sum_i m_i |u_i|^2 + s^4 |M^-1/2 L u|^2 + w sum_f A_f |(G (x + u))_f - P_f|^2,  f out of bounds,
    with P_f the 3x2 gradient of f, its singular values clipped.

    Args:
        nodes: Positions [m], shape [node_count, 3].
        gradient: Positions to Jacobian rows, shape [2 face_count, node_count].
        areas: Rest areas [m2], shape [face_count].
        faces: Shape [face_count, 3].
        settings: Bounds and weights.

    Returns:
        Positions [m] of the round with the fewest triangles out of bounds, unchanged if none was out.
    """
    x, stay = np.array(nodes), _regularisation_matrix(nodes, gradient, areas, faces, settings.fade)
    best, fewest = x, len(faces) + 1
    for _ in range(settings.strain_iterations):
        wrong, change = find_strain_violations(x, gradient, areas, settings.least_stretch, settings.most_stretch)
        if wrong.sum() < fewest:
            best, fewest = x, int(wrong.sum())
        if fewest == 0:
            break
        pull = (gradient.T @ sp.diags(np.repeat(settings.strain * areas * wrong, 2))).tocsr()
        factor = factor_symmetric(stay + pull @ gradient)
        x = x + factor.solve(pull @ change)
    return best


def find_strain_violations(
    nodes: np.ndarray, gradient: sp.csr_matrix, areas: np.ndarray, lowest: float, highest: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return which triangles' singular values are out of bounds, and the correction of their gradients.

    Args:
        nodes: Positions [m], shape [node_count, 3].
        gradient: Positions to Jacobian rows, shape [2 face_count, node_count].
        areas: Rest areas [m2], shape [face_count].
        lowest, highest: The bounds.

    Returns:
        Which are out of bounds, shape [face_count], and the change of all rows of the gradient, [2 face_count, 3].
    """
    jacobians = np.asarray(gradient @ nodes).reshape(-1, 2, 3).transpose(0, 2, 1)
    values, axes = np.linalg.eigh(np.einsum("fki,fkj->fij", jacobians, jacobians))
    size = np.sqrt(np.maximum(values, 1e-6))
    # the stretch of a degenerate panel triangle is not defined
    wrong = ((size[:, 0] < lowest) | (size[:, 1] > highest)) & (areas > 1e-3 * areas.mean())
    share = np.clip(size, lowest, highest) / size - 1.0
    change = jacobians @ np.einsum("fik,fk,fjk->fij", axes, share, axes)
    return wrong, change.transpose(0, 2, 1).reshape(-1, 3)


def smooth_crossings(
    nodes: np.ndarray,
    gradient: sp.csr_matrix,
    areas: np.ndarray,
    faces: np.ndarray,
    allowed: int,
    settings: EasingSettings,
) -> np.ndarray:
    """Smooth patches whose faces cross, until no more faces cross than are allowed.

    A panel wider than the scan folds over itself at its seams. In a patch around each crossing the nodes are released
    and take the smoothest course between those around: sum_i w_i |x_i - y_i|^2 + s^4 / 100 |M^-1/2 L x|^2, with w_i the
    node's area, down to a ten-thousandth of it in the middle of a patch.

    Args:
        nodes: Positions [m], shape [node_count, 3].
        gradient: Positions to Jacobian rows.
        areas: Rest areas [m2].
        faces: Shape [face_count, 3].
        allowed: Faces that may cross: those of the graded drape.
        settings: Size of the patches.

    Returns:
        Positions [m]; unchanged where no round reached what is allowed, since smooth patches fit less well.
    """
    mass, bending = _mass_and_bending(nodes, gradient, areas, faces)
    x, free = nodes, np.zeros(len(nodes))
    for turn in range(settings.crossing_iterations + 1):
        wrong = find_crossing_faces(x, faces)
        if wrong.sum() <= allowed:
            return x
        free = np.maximum(free, falloff_weights(wrong, faces, len(nodes), settings.rings + turn // 2))
        weight = mass * np.maximum((1.0 - free) ** 2, settings.kept_weight)
        matrix = sp.diags(weight) + 1e-2 * (settings.crossing_length * settings.crossing_growth**turn) ** 4 * bending
        factor = factor_symmetric(matrix)
        x = nodes + np.minimum(2.0 * free, 1.0)[:, None] * (factor.solve(weight[:, None] * nodes) - nodes)
    return nodes


def _mass_and_bending(
    nodes: np.ndarray, gradient: sp.csr_matrix, areas: np.ndarray, faces: np.ndarray
) -> tuple[np.ndarray, sp.csr_matrix]:
    mass = np.maximum(vertex_areas(nodes, faces), 1e-12)
    laplacian = (gradient.T @ sp.diags(np.repeat(areas, 2)) @ gradient).tocsr()
    return mass, bending_matrix(laplacian, 1 / mass)


def _regularisation_matrix(
    nodes: np.ndarray, gradient: sp.csr_matrix, areas: np.ndarray, faces: np.ndarray, fade: float
) -> sp.csr_matrix:
    mass, bending = _mass_and_bending(nodes, gradient, areas, faces)
    return (sp.diags(mass) + fade**4 * bending).tocsr()
