"""Contact with the body: a cubic penalty within the cloth's thickness (thesis 3.2.4.4)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..body.distance import sample_distance
from ..run.kernels import kernel
from .block_pattern import Derivatives
from .scene import Scene
from .tangent_planes import TangentPlanes, plane_contact

NO_BLOCKS = np.zeros((0, 3, 3))
"""Hessian blocks [N/m] of a kernel call of order 0 or 1."""


class NodeElements(NamedTuple):
    """Nodes as the kernels take them: area of each [m2] and slot of its diagonal block, both [node_count]."""

    areas: np.ndarray
    slots: np.ndarray


class Forces(NamedTuple):
    """Contact force on each node [N], shape [node_count], and its unit direction, shape [node_count, 3]."""

    size: np.ndarray
    normal: np.ndarray

    @classmethod
    def none(cls, count: int) -> Forces:
        """Return zero forces."""
        return cls(np.zeros(count), np.zeros((count, 3)))


def contact_forces(scene: Scene, nodes: np.ndarray, areas: np.ndarray | None = None) -> Forces:
    """Compute the contact forces at nodes [m], shape [node_count, 3].

    Args:
        scene: The cloth and the body.
        nodes: Positions [m], shape [node_count, 3].
        areas: Area of each node [m2], shape [node_count]; the rest shape's where None.
    """
    forces = Forces.none(len(nodes))
    if scene.body is not None:
        areas = scene.topology.rest.node_areas if areas is None else areas
        elements = NodeElements(areas, scene.topology.pattern.diagonal)
        waste = Derivatives(np.zeros((len(nodes), 3)), NO_BLOCKS)
        add_contact(nodes, scene, elements, (1, False), waste, forces)
    return forces


def add_contact(
    nodes: np.ndarray,
    scene: Scene,
    elements: NodeElements,
    order: tuple[int, bool],
    derivatives: Derivatives,
    forces: Forces,
) -> float:
    """Add a scene's contact with its body and return the energy [J]; `order` is the kernels' order and exactness."""
    body = scene.body
    assert body is not None
    kernel = plane_contact if isinstance(body, TangentPlanes) else contact
    return float(kernel(nodes, body.arrays, elements, scene.contact.law, *order, derivatives, forces))


@kernel()
def contact(x, grid, nodes, law, order, exact, derivatives, forces):  # type: ignore[no-untyped-def]
    """Add the contact's gradient (order >= 1) and Hessian blocks (order 2) and return its energy [J].

    E_v = a_v k / 3 (delta - d(x_v))^3 where d < delta, else 0: twice continuously differentiable, as d is.

    Notation: `grid` gives d; `nodes` a `NodeElements` with the areas a_v [m2]; `law` k [N/m4] and delta [m];
    `derivatives` a `Derivatives`; `forces` receives the contact force and its direction, for friction.

    **Deviation**: the thesis' force is inversely proportional to the distance, and so unbounded at the surface. The PSD
    form drops the curvature of d.
    """
    areas, diagonal = nodes
    stiffness, thickness = law
    gradient, blocks = derivatives
    force, normal = forces
    energy = 0.0
    slope, curve = np.zeros(3), np.zeros((3, 3))
    for v in range(x.shape[0]):
        force[v] = 0.0
        distance = sample_distance((x[v, 0], x[v, 1], x[v, 2]), grid, thickness, order, slope, curve)
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
