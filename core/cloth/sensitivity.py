"""Derivatives of the forces on the nodes by the flat pattern and the fabric, at fixed positions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix

from .bending import bending
from .bending_friction import FoldFriction
from .block_pattern import Derivatives
from .contact import NO_BLOCKS, contact_forces
from .energy import NO_STRESS, Energy
from .fabric import Fabric
from .membrane import membrane
from .topology import Topology

__all__ = ["FABRIC_PARAMETERS", "Sensitivity"]

FABRIC_PARAMETERS = ("H00", "H01", "H11", "H22", "k", "density")
"""The fabric's parameters in the order of derivatives by them."""


@dataclass(frozen=True)
class Sensitivity:
    """Describe the derivative of one number by everything a drape depends on.

    Attributes:
        rest: By the corners of the flat rest triangles [1/m], shape [face_count, 3, 2].
        fabric: By `FABRIC_PARAMETERS`, in the inverse of their units, shape [6].
        pins: By the points at which nodes are pinned [1/m], shape [pin_count, 3].
        start: By the start positions [1/m], shape [node_count, 3]; zero at an equilibrium.
    """

    rest: np.ndarray
    fabric: np.ndarray
    pins: np.ndarray
    start: np.ndarray


def pull_forces(energy: Energy, nodes: np.ndarray, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the derivative of sum(weights * g) by the rest triangles, [face_count, 3, 2], and `FABRIC_PARAMETERS`,
    [6].

    Everything that depends on a face's flat corners r_b does so through D = sum_b dr_b S_b^T, S_b the gradients of the
    shape functions: dS_b = -D^T S_b, dA = A tr D, dF = -F D. With L = sum_a weights_a S_a^T, C = F^T L, B = F^T F, the
    stress Sigma and T = H sym(C), the membrane's share is

        d(weights . g) = < A [ (Sigma : C) I - (C + C^T) Sigma - B T ], D >.

    Hinges follow through c = |e|^2 / (A1 + A2); weight, contact and inertia through the area of a node. Friction is
    lagged: its limits and anchors are constants.

    Notation: g = dE/dx [N], `nodes` x and `weights`, both of shape [node_count, 3].
    """
    topology, fabric = energy.scene.topology, energy.scene.only_fabric
    shape, areas, faces = topology.rest.gradients, topology.rest.areas, topology.faces
    F, sigma = _deform(topology, fabric, nodes)
    L = np.swapaxes(weights[faces], 1, 2) @ shape
    C = np.swapaxes(F, 1, 2) @ L
    T = _stress(fabric, 0.5 * (C + np.swapaxes(C, 1, 2)))
    Q = -(C + np.swapaxes(C, 1, 2)) @ sigma - np.swapaxes(F, 1, 2) @ F @ T
    by_area = (sigma * C).sum((1, 2))

    folds = _unit_folds(energy, nodes)
    by_scale = fabric.k * (folds * weights[topology.hinges.nodes]).sum((1, 2))
    around = areas[topology.hinges.faces].sum(1)
    by_total = -by_scale * topology.hinge_scale / around
    count = len(faces)
    by_area += sum(np.bincount(topology.hinges.faces[:, s], by_total, minlength=count) for s in (0, 1))
    by_area += (weights * _load_per_area(energy, nodes)).sum(1)[faces].sum(1) / 3
    Q[:, 0, 0] += by_area
    Q[:, 1, 1] += by_area
    rest = areas[:, None, None] * (shape @ np.swapaxes(Q, 1, 2))

    corners, edges = topology.hinges.corners, topology.hinges.edges(topology.rest)
    flat = rest.reshape(-1, 2)
    for s in (0, 1):
        push = (by_scale / around)[:, None] * edges[s]
        first = 3 * topology.hinges.faces[:, s]
        ends = ((first + (corners[:, s] + 1) % 3, 1.0), (first + corners[:, s], -1.0))
        for end, sign in ends:
            for axis in (0, 1):
                flat[:, axis] += np.bincount(end, sign * push[:, axis], minlength=3 * count)
    return rest, np.einsum("vdm,vd->m", fabric_forces(energy, nodes), weights)


def push_forces(energy: Energy, nodes: np.ndarray, rest_rates: np.ndarray) -> np.ndarray:
    """Return dg along directions of the rest triangles, shape [node_count, 3, direction_count]; see `pull_forces`.
    `rest_rates` [m] has shape [face_count, 3, 2, direction_count]."""
    topology, fabric = energy.scene.topology, energy.scene.only_fabric
    shape, areas, faces = topology.rest.gradients, topology.rest.areas, topology.faces
    count, many = len(faces), rest_rates.shape[-1]
    F, sigma = _deform(topology, fabric, nodes)
    metric, stress = np.swapaxes(F, 1, 2) @ F, F @ sigma
    local = np.zeros((count, 9, 4))
    for entry in range(4):
        unit = np.zeros((2, 2))
        unit[entry // 2, entry % 2] = 1.0
        stretch = metric @ unit
        change = _stress(fabric, -0.5 * (stretch + np.swapaxes(stretch, 1, 2)))
        force = np.trace(unit) * stress - F @ unit @ sigma + F @ change - stress @ unit.T
        local[:, :, entry] = (areas[:, None, None] * (shape @ np.swapaxes(force, 1, 2))).reshape(count, 9)
    D = np.einsum("fbim,fbj->fijm", rest_rates, shape, optimize=True)
    found = _gather(faces, topology.node_count) @ (local @ D.reshape(count, 4, many)).reshape(3 * count, 3 * many)

    area_rates = areas[:, None] * (D[:, 0, 0] + D[:, 1, 1])
    corners, edges = topology.hinges.corners, topology.hinges.edges(topology.rest)
    around = areas[topology.hinges.faces].sum(1)[:, None]
    scale_rates = -topology.hinge_scale[:, None] * area_rates[topology.hinges.faces].sum(1)
    for s in (0, 1):
        side = topology.hinges.faces[:, s]
        turn = rest_rates[side, (corners[:, s] + 1) % 3] - rest_rates[side, corners[:, s]]
        scale_rates += (edges[s][:, :, None] * turn).sum(1)
    scale_rates *= fabric.k / around
    spread = (_unit_folds(energy, nodes)[..., None] * scale_rates[:, None, None, :]).reshape(-1, 3 * many)
    found += _gather(topology.hinges.nodes, topology.node_count) @ spread
    node_rates = _gather(faces, topology.node_count) @ np.repeat(area_rates / 3, 3, axis=0)
    found = found.reshape(-1, 3, many)
    whole: np.ndarray = found + _load_per_area(energy, nodes)[:, :, None] * node_rates[:, None, :]
    return whole


def fabric_forces(energy: Energy, nodes: np.ndarray) -> np.ndarray:
    """Return dg by `FABRIC_PARAMETERS`, shape [node_count, 3, 6]: the forces are linear in each of them."""
    topology = energy.scene.topology
    nodes = np.ascontiguousarray(nodes, dtype=np.float64)
    found = np.zeros((len(nodes), 3, len(FABRIC_PARAMETERS)))
    for n in range(4):
        gradient = np.zeros_like(nodes)
        membrane(nodes, topology.face_elements, np.eye(4)[n], NO_STRESS, 1, True, Derivatives(gradient, NO_BLOCKS))
        found[:, :, n] = gradient
    gradient = np.zeros_like(nodes)
    folds, pushed = FoldFriction.of(topology), Derivatives(gradient, NO_BLOCKS)
    bending(nodes, topology.hinge_elements, 1.0, folds, 1, True, pushed)
    found[:, :, 4] = gradient
    found[:, :, 5] = _acceleration(energy, nodes) * topology.rest.node_areas[:, None]
    return found


def _deform(topology: Topology, fabric: Fabric, nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return F, shape [face_count, 3, 2], and the stress per rest length Sigma [N/m], shape [face_count, 2, 2]."""
    F = np.swapaxes(nodes[topology.faces], 1, 2) @ topology.rest.gradients
    return F, _stress(fabric, 0.5 * (np.swapaxes(F, 1, 2) @ F - np.eye(2)))


def _stress(fabric: Fabric, strain: np.ndarray) -> np.ndarray:
    """Return the symmetric stress [N/m] that is conjugate to a symmetric strain, both of shape [..., 2, 2]."""
    stress = np.zeros_like(strain)
    stress[..., 0, 0] = fabric.H00 * strain[..., 0, 0] + fabric.H01 * strain[..., 1, 1]
    stress[..., 1, 1] = fabric.H01 * strain[..., 0, 0] + fabric.H11 * strain[..., 1, 1]
    stress[..., 0, 1] = stress[..., 1, 0] = 0.5 * fabric.H22 * strain[..., 0, 1]
    return stress


def _unit_folds(energy: Energy, nodes: np.ndarray) -> np.ndarray:
    """Return each hinge's own force at k = c = 1, shape [hinge_count, 4, 3], not summed at shared nodes."""
    topology = energy.scene.topology
    count = len(topology.hinges.nodes)
    apart = np.ascontiguousarray(nodes[topology.hinges.nodes].reshape(-1, 3))
    gradient = np.zeros_like(apart)
    rows = np.arange(4 * count).reshape(count, 4)
    elements = topology.hinge_elements._replace(nodes=rows, scale=np.ones(count))
    bending(apart, elements, 1.0, FoldFriction.of(topology), 1, True, Derivatives(gradient, NO_BLOCKS))
    return gradient.reshape(count, 4, 3)


def _acceleration(energy: Energy, nodes: np.ndarray) -> np.ndarray:
    """Return the gradient of weight, rotation and inertia per mass [m/s2], shape [node_count, 3]."""
    found = -energy.scene.acceleration(nodes)
    if energy.inertia is not None:
        found += energy.inertia.weight * (nodes - energy.inertia.target)
    return found


def _load_per_area(energy: Energy, nodes: np.ndarray) -> np.ndarray:
    """Return the gradient of mass and contact per node area [N/m2], shape [node_count, 3]."""
    scene = energy.scene
    found = scene.only_fabric.density * _acceleration(energy, nodes)
    if scene.body is not None:
        force, normal = contact_forces(scene, nodes, np.ones(len(nodes)))
        found -= force[:, None] * normal
    return found


def _gather(elements: np.ndarray, count: int) -> csr_matrix:
    """Return the matrix that sums the corners of elements to nodes, shape [node_count, elements.size]."""
    places = np.arange(elements.size)
    return csr_matrix((np.ones(elements.size), (elements.ravel(), places)), shape=(count, elements.size))
