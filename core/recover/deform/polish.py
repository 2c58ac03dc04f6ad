"""Polish nodes by local-global closest-point iterations that keep triangles close to their rest stretch (ARAP)."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from ...body.exposed import ExposedSurface
from ...geometry.connectivity import HalfEdges
from ...geometry.geometry import bending_matrix, polar_rotations, unit, vertex_areas
from ...geometry.linear import analyse_pattern, factor_symmetric
from ...geometry.surface import TriangleSurface
from ...run.hooks import Hooks
from .contour_match import ContourMatch
from .jacobian_stage import rows_to_jacobians
from .rest_metric import RestMetric
from .settings import DeformSettings
from .target_repair import PreparedTarget

REST_STRETCH_WEIGHTS = (1e-3, 2e-4)
"""Weights of the rest stretch relative to the distance, at first and last step [m2]: a reach of 3 and of 1.4 cm."""

SQUARED_CURVATURE_WEIGHTS = (1e-8, 1e-9)
"""Weights of the squared curvature at first and last step [m4]: they resist folds shorter than 1 cm and 0.6 cm."""

POINT_DISTANCE_WEIGHT, PLANE_DISTANCE_WEIGHT, CONTOUR_DISTANCE_WEIGHT = 0.2, 1.0, 10.0
"""Weights of the squared distances to the closest point, along the normal and of contours, relative to that along the
normal. A fifth along the surface lets triangles slide; the contours keep the border from sliding too."""

MIN_MATCH_NORMAL_COSINE = 0.2
"""Cosine between normals below which a match has no weight: it belongs to another layer or to a wrong fold."""

BODY_CONTACT_WEIGHT = 10.0
"""Weight of a node inside the body, relative to a match's: larger, since its match may be inside the body, too."""


def polish_nodes(
    nodes: np.ndarray,
    faces: np.ndarray,
    gradient: sp.csr_matrix,
    metric: RestMetric,
    target: PreparedTarget,
    body: ExposedSurface,
    settings: DeformSettings,
    hooks: Hooks,
) -> np.ndarray:
    """Bring nodes onto the target by alternating rotations (local) and positions (global).

    Each step solves one sparse system for x that minimises
        sum_i w_i (|n_i.(x_i - p_i)|^2 + 0.2 |x_i - p_i|^2) + the same for the target's vertices on the garment
        + 10 contours + a sum_f A_f |(G x)_f - R_f S_f|^2 + b |M^-1/2 L x|^2
    with p_i the closest point, R_f the rotation nearest to (G x)_f S_f^-1 and S_f the rest stretch. The plane term is
    majorised by a point (the projection of x_i on the plane), so that x, y and z share one factor.

    Args:
        nodes: Result of the main stage [m], shape [node_count, 3].
        faces: Shape [face_count, 3].
        gradient: Positions to Jacobian rows.
        metric: Rest areas, and rest stretch at the end of the main stage.
        target: The repaired target.
        body: The exact body.
        settings: Number of steps and the margin to the body.
        hooks: Progress and cancellation.

    Returns:
        Polished nodes [m], unchecked (`accept_polish`).
    """
    weighted = (gradient.T @ sp.diags(np.repeat(metric.areas, 2))).tocsr()
    laplacian = (weighted @ gradient).tocsr()
    mass, shown = vertex_areas(nodes, faces), vertex_areas(nodes, target.shown_faces)
    solver = analyse_pattern(HalfEdges.of(faces, len(nodes)), rings=2)
    bending = bending_matrix(laplacian, 1 / np.maximum(mass, 1e-12))
    curves = ContourMatch(target.pairs, nodes, target.surface.vertices)
    goal_area = target.shares * shown.sum()
    x, surface = nodes.copy(), TriangleSurface(nodes, target.shown_faces)
    planes: tuple[np.ndarray, ...] = ()
    steps = settings.polish_iterations
    for step in range(steps):
        part = step / max(steps - 1, 1)
        rigidity = REST_STRETCH_WEIGHTS[0] ** (1 - part) * REST_STRETCH_WEIGHTS[1] ** part
        stiffness = SQUARED_CURVATURE_WEIGHTS[0] ** (1 - part) * SQUARED_CURVATURE_WEIGHTS[1] ** part
        surface = surface.moved(x)
        normals = surface.vertex_normals
        matrix, right = _assemble_node_pulls(x, normals, shown, target)
        back_matrix, back_right = _assemble_target_pulls(surface, normals, goal_area, target)
        matrix, right = matrix + back_matrix, right + back_right
        rows = curves.rows(x)
        if rows is not None:
            # rows sum to 2; scaled by the area of a strip as wide as the garment's mean edge along the border
            strip = float(np.sum(mass[np.unique(rows.nodes[:, 0])]))
            weight = CONTOUR_DISTANCE_WEIGHT * 0.5 * rows.weights * strip
            picks = _selection_matrix(rows.nodes, rows.shares, len(x))
            matrix, right = (
                matrix + picks.T @ sp.diags(weight) @ picks,
                right + picks.T @ (weight[:, None] * rows.goals),
            )
        if step % 5 == 0:
            distance, out = body.measure(x)
            planes = (out, (out * x).sum(1) - distance)
        inside, push = _find_body_violations(x, planes, settings.body_margin)
        weight = BODY_CONTACT_WEIGHT * mass * inside
        matrix, right = matrix + sp.diags(weight), right + weight[:, None] * (x + push)
        rotation = polar_rotations(rows_to_jacobians(gradient @ x) @ metric.undo) @ metric.stretch
        right = right + rigidity * (weighted @ rotation.transpose(0, 2, 1).reshape(-1, 3))
        system = matrix + rigidity * laplacian + stiffness * bending
        x = factor_symmetric(system, solver).solve(right)
        hooks.progress("deform", 0.7 + 0.2 * (step + 1) / steps, f"polish {step + 1}")
    return np.asarray(x)


def _normal_weights(cosine: np.ndarray, unsigned: bool) -> np.ndarray:
    cosine = np.abs(cosine) if unsigned else cosine
    return np.clip((cosine - MIN_MATCH_NORMAL_COSINE) / (1 - MIN_MATCH_NORMAL_COSINE), 0.0, 1.0)


def _assemble_node_pulls(
    x: np.ndarray, normals: np.ndarray, mass: np.ndarray, target: PreparedTarget
) -> tuple[sp.csr_matrix, np.ndarray]:
    """Return rows that pull nodes to the target."""
    found = target.surface.closest(x)
    foot = found.foot
    normal = unit(found.interpolate(target.normals, target.surface.faces))
    weight = mass * _normal_weights((normals * normal).sum(1), target.unsigned) * ~target.on_rim(found)
    onto = x + normal * ((foot - x) * normal).sum(1)[:, None]
    return sp.diags(weight * (PLANE_DISTANCE_WEIGHT + POINT_DISTANCE_WEIGHT)).tocsr(), weight[:, None] * (
        PLANE_DISTANCE_WEIGHT * onto + POINT_DISTANCE_WEIGHT * foot
    )


def _assemble_target_pulls(
    surface: TriangleSurface, normals: np.ndarray, area: np.ndarray, target: PreparedTarget
) -> tuple[sp.csr_matrix, np.ndarray]:
    """Return rows that pull the garment to the target's vertices."""
    found = surface.closest(target.surface.vertices)
    x = surface.vertices
    picks = found.interpolation(surface.faces, len(x))
    cover, normal = picks @ x, target.normals
    weight = area * _normal_weights((unit(picks @ normals) * normal).sum(1), target.unsigned)
    goal = target.surface.vertices
    onto = cover + normal * ((goal - cover) * normal).sum(1)[:, None]
    matrix = (picks.T @ sp.diags(weight * (PLANE_DISTANCE_WEIGHT + POINT_DISTANCE_WEIGHT)) @ picks).tocsr()
    return matrix, np.asarray(
        picks.T @ (weight[:, None] * (PLANE_DISTANCE_WEIGHT * onto + POINT_DISTANCE_WEIGHT * goal))
    )


def _selection_matrix(columns: np.ndarray, values: np.ndarray, count: int) -> sp.csr_matrix:
    rows = np.repeat(np.arange(len(columns)), columns.shape[1])
    return sp.csr_matrix((values.reshape(-1), (rows, columns.reshape(-1))), shape=(len(columns), count))


def _find_body_violations(
    x: np.ndarray, planes: tuple[np.ndarray, ...], margin: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return which nodes are nearer than the margin by the body's planes, and their displacement to it."""
    out, height = planes
    missing = margin + height - (x * out).sum(1)
    # a plane is not valid for a node that has left its neighbourhood
    violated = (missing > 0) & (missing < 0.02)
    return violated, out * (missing * violated)[:, None]
