"""Contact with the body: a cubic penalty within the cloth's thickness (thesis 3.2.4.4)."""

from __future__ import annotations

import numpy as np
from numba import njit

from ..body import sample_distance
from .scene import Scene

NO_BLOCKS = np.zeros((0, 3, 3))
"""Where a kernel is not asked for Hessian blocks."""


def contact_forces(scene: Scene, nodes: np.ndarray, areas: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Compute the contact force [N], shape [node_count], and its unit direction, shape [node_count, 3].

    Args:
        scene: The cloth and the body.
        nodes: Positions [m], shape [node_count, 3].
        areas: Area of each node [m2], shape [node_count]; the rest shape's where None.
    """
    force, normal, waste = np.zeros(len(nodes)), np.zeros((len(nodes), 3)), np.zeros((len(nodes), 3))
    if scene.body is not None:
        areas = scene.topology.node_areas if areas is None else areas
        add_contact(scene, nodes, areas, 1, False, (waste, NO_BLOCKS), (force, normal))
    return force, normal


def add_contact(
    scene: Scene,
    nodes: np.ndarray,
    areas: np.ndarray,
    order: int,
    exact: bool,
    derivatives: tuple[np.ndarray, np.ndarray],
    forces: tuple[np.ndarray, np.ndarray],
) -> float:
    """Add the contact's gradient and Hessian blocks to `derivatives`, write `forces`, and return its energy [J]."""
    grid, law = scene.body, scene.contact
    assert grid is not None
    return float(
        contact(
            nodes, grid.coefficients, grid.origin, grid.spacing, grid.offset, areas, law.stiffness, law.thickness,
            order, exact, scene.topology.diagonal, *derivatives, *forces,
        )
    )  # fmt: skip


@njit(cache=True)
def contact(x, coefficients, origin, spacing, offset, areas, stiffness, thickness, order, exact, diagonal, gradient,
            blocks, force, normal):  # type: ignore[no-untyped-def]  # fmt: skip
    """Add the contact's gradient (order >= 1) and Hessian blocks (order 2) and give its energy [J].

    E_v = a_v k / 3 (delta - d(x_v))^3 where d < delta, else 0: twice continuously differentiable, as d is.

    Notation: `areas` a_v [m2]; `stiffness` k [N/m4]; `thickness` delta [m]; the grid's four fields give d. `force`
    [node_count] and `normal` [node_count, 3] receive the contact force [N] and its direction, for friction.

    **Deviation**: the thesis' force is inversely proportional to the distance, which is unbounded at the surface. The
    PSD form drops the curvature of d.
    """
    energy = 0.0
    flat = coefficients.ravel()
    slope, curve = np.zeros(3), np.zeros((3, 3))
    for v in range(x.shape[0]):
        force[v] = 0.0
        distance = sample_distance(
            (x[v, 0], x[v, 1], x[v, 2]),
            flat,
            coefficients.shape,
            origin,
            spacing,
            offset,
            thickness,
            order,
            slope,
            curve,
        )
        if distance >= thickness:
            continue
        depth = thickness - distance
        scale = areas[v] * stiffness
        energy += scale * depth * depth * depth / 3.0
        if order == 0:
            continue
        first, second = -scale * depth * depth, 2.0 * scale * depth
        length = np.sqrt(slope[0] * slope[0] + slope[1] * slope[1] + slope[2] * slope[2])
        force[v] = -first * length
        for d in range(3):
            gradient[v, d] += first * slope[d]
            normal[v, d] = slope[d] / max(length, 1e-12)
        if order == 1:
            continue
        b = diagonal[v]
        for d in range(3):
            for e in range(3):
                blocks[b, d, e] += second * slope[d] * slope[e]
                if exact:
                    blocks[b, d, e] += first * curve[d, e]
    return energy
