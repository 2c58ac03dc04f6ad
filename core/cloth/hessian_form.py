"""The PSD Hessian's bilinear form in torch, for the adjoint through a linearised step."""

from __future__ import annotations

from typing import Any

import numpy as np
import torch

from .bending_friction import FoldFriction
from .energy import Energy
from .scene import Scene
from .topology import Topology

FormGradient = tuple[np.ndarray, np.ndarray, np.ndarray]


def pull_form(energy: Energy, nodes: np.ndarray, one: np.ndarray, other: np.ndarray) -> tuple[float, FormGradient]:
    """Return q = one . P(x; p) other, P the PSD Hessian, and its derivative by x, by rest triangles and by fabric.

    It is thesis eq. 2.30, dM / dx contracted with the adjoint and the solution: third derivatives of the energy, by
    torch's reverse mode over all faces and hinges at once. P is that of `Energy.hessian(nodes, exact=False)`; contact's
    normal and friction's limits are constants as there. Spring pins are left out: their share of q does not depend on
    the nodes.

    Args:
        energy: Whose Hessian.
        nodes: x [m], shape [node_count, 3].
        one, other: Directions, both of shape [node_count, 3].

    Returns:
        q [J], for directions in metres; derivatives of shapes [node_count, 3], [face_count, 3, 2] and [6]
            (`FABRIC_PARAMETERS`).
    """
    scene = energy.scene
    topology, fabric = scene.topology, scene.only_fabric
    values = [fabric.H00, fabric.H01, fabric.H11, fabric.H22, fabric.k, fabric.density]
    free = [torch.tensor(np.array(part), requires_grad=True) for part in (nodes, topology.rest.corners, values)]
    x, rest, stiffness = free
    first, second = torch.from_numpy(np.array(one)), torch.from_numpy(np.array(other))
    edges = rest[:, 1:] - rest[:, :1]
    areas = 0.5 * (edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0]).abs()
    corners = torch.from_numpy(topology.faces.ravel())
    shares = torch.zeros(len(nodes), dtype=x.dtype).index_add(0, corners, (areas / 3).repeat_interleave(3))
    form = _membrane(topology, x, edges, areas, stiffness, first, second)
    form = form + _bending(scene, x, rest, areas, stiffness[4], first, second)
    if scene.body is not None:
        form = form + _contact(scene, x, shares, first, second)
    if energy.friction is not None:
        form = form + _friction(energy, x, first, second)
    if energy.inertia is not None:
        form = form + energy.inertia.weight * stiffness[5] * (shares * (first * second).sum(1)).sum()
    found = torch.autograd.grad(form, free)
    by_nodes, by_rest, by_fabric = (part.numpy() for part in found)
    return float(form.detach()), (by_nodes, by_rest, by_fabric)


def _membrane(
    topology: Topology,
    x: torch.Tensor,
    edges: torch.Tensor,
    areas: torch.Tensor,
    H: torch.Tensor,
    one: torch.Tensor,
    other: torch.Tensor,
) -> torch.Tensor:
    """Return A (eps_1 : H eps_2 + sum_ij S+_ij f_1i . f_2j), f_n = D(F)[n], eps_n = sym(F^T f_n), S+ the stress's PSD
    part."""
    undo = torch.linalg.inv(edges)
    faces = torch.from_numpy(topology.faces)

    def gradient(field: torch.Tensor) -> torch.Tensor:
        # rows: derivatives along both flat axes, shape [face_count, 2, 3]
        found: torch.Tensor = undo @ (field[faces[:, 1:]] - field[faces[:, :1]])
        return found

    def stress(e: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        e0, e1, e2 = e[:, 0, 0], e[:, 1, 1], 0.5 * (e[:, 0, 1] + e[:, 1, 0])
        return H[0] * e0 + H[1] * e1, H[1] * e0 + H[2] * e1, H[3] * e2

    F, f1, f2 = gradient(x), gradient(one), gradient(other)
    turned = F.transpose(1, 2)
    s0, s1, s2 = stress(0.5 * (F @ turned - torch.eye(2, dtype=x.dtype)))
    e1, (m0, m1, m2) = f1 @ turned, stress(f2 @ turned)
    material = m0 * e1[:, 0, 0] + m1 * e1[:, 1, 1] + 0.5 * m2 * (e1[:, 0, 1] + e1[:, 1, 0])
    t0, t1, t2 = _positive_part(s0, s1, 0.5 * s2)
    cross = f1 @ f2.transpose(1, 2)
    geometric = t0 * cross[:, 0, 0] + t1 * cross[:, 1, 1] + t2 * (cross[:, 0, 1] + cross[:, 1, 0])
    return (areas * (material + geometric)).sum()


def _positive_part(a: torch.Tensor, b: torch.Tensor, c: torch.Tensor) -> tuple[torch.Tensor, ...]:
    """Return `membrane.positive_part` of many matrices [[a, c], [c, b]] at once."""
    mean, half = 0.5 * (a + b), 0.5 * (a - b)
    tense = mean.detach() - torch.sqrt(half.detach() ** 2 + c.detach() ** 2) >= 0
    slack = mean.detach() + torch.sqrt(half.detach() ** 2 + c.detach() ** 2) <= 0
    # 1 where the part is all or nothing: the square root is not used there, and its slope at zero is infinite
    radius = torch.sqrt(torch.where(tense | slack, torch.ones_like(a), half**2 + c**2))
    scale = (mean + radius) / (2.0 * radius)
    mixed = (scale * (radius + half), scale * (radius - half), scale * c)
    none = torch.zeros_like(a)
    return tuple(
        torch.where(tense, whole, torch.where(slack, none, part)) for whole, part in zip((a, b, c), mixed, strict=True)
    )


def _bending(
    scene: Scene,
    x: torch.Tensor,
    rest: torch.Tensor,
    areas: torch.Tensor,
    k: torch.Tensor,
    one: torch.Tensor,
    other: torch.Tensor,
) -> torch.Tensor:
    """Return E'' (grad theta . one)(grad theta . other) summed over hinges; see `bending` and `BendingFriction`."""
    topology = scene.topology
    hinged = topology.hinges
    sides, corners = torch.from_numpy(hinged.faces), torch.from_numpy(hinged.corners)
    flat = [rest[sides[:, s], (corners[:, s] + 1) % 3] - rest[sides[:, s], corners[:, s]] for s in (0, 1)]
    scale = sum((edge**2).sum(1) for edge in flat) / 2.0 / areas[sides].sum(1)
    hinges = torch.from_numpy(hinged.nodes)
    start, end, before, after = (x[hinges[:, n]] for n in range(4))
    e, p, q = end - start, before - start, after - start
    n1, n2 = torch.linalg.cross(e, p), torch.linalg.cross(q, e)
    squared, m1, m2 = (e**2).sum(1), (n1**2).sum(1), (n2**2).sum(1)
    length = torch.sqrt(squared)
    turn = torch.atan2(-length * (n1 * q).sum(1), (n1 * n2).sum(1))
    angle = 0.5 * (turn - torch.from_numpy(hinged.angles))
    second = 0.5 * k * scale * torch.cos(angle).abs()
    angles, moments, slip = FoldFriction.of(topology, scene.bending_friction)
    change = turn - torch.from_numpy(angles)
    change = change - 2.0 * np.pi * torch.round(change.detach() / (2.0 * np.pi))
    second = second + torch.from_numpy(moments) * slip**2 / (change**2 + slip**2) ** 1.5
    g2, g3 = -(length / m1)[:, None] * n1, -(length / m2)[:, None] * n2
    t1, t2 = ((p * e).sum(1) / squared)[:, None], ((q * e).sum(1) / squared)[:, None]
    slopes = (-(1.0 - t1) * g2 - (1.0 - t2) * g3, -t1 * g2 - t2 * g3, g2, g3)

    def turns(field: torch.Tensor) -> torch.Tensor:
        found: torch.Tensor = sum((slope * field[hinges[:, n]]).sum(1) for n, slope in enumerate(slopes))
        return found

    sound = ~((m1 < 1e-8 * squared**2) | (m2 < 1e-8 * squared**2))
    return torch.where(sound, second * turns(one) * turns(other), torch.zeros_like(second)).sum()


def _contact(
    scene: Scene, x: torch.Tensor, shares: torch.Tensor, one: torch.Tensor, other: torch.Tensor
) -> torch.Tensor:
    """Return 2 a_v k (delta - d) (n . one)(n . other) where d < delta; d and n to first order about the nodes."""
    body: Any = scene.body
    distance, slope, curve = (torch.from_numpy(part) for part in body.evaluate(x.detach().numpy()))
    moved = x - x.detach()
    depth = torch.relu(scene.contact.thickness - distance - (slope * moved).sum(1))
    normal = slope + (curve @ moved[:, :, None])[:, :, 0]
    pressed = 2.0 * scene.contact.stiffness * shares * depth
    return (pressed * (normal * one).sum(1) * (normal * other).sum(1)).sum()


def _friction(energy: Energy, x: torch.Tensor, one: torch.Tensor, other: torch.Tensor) -> torch.Tensor:
    """Return L (f'/y one_t . other_t + (f'' - f'/y) (u . one)(u . other) / y^2), u the slide, y = |u|; see
    `friction`."""
    elements = energy.friction
    assert elements is not None
    active = np.flatnonzero(elements.limits > 0)
    n, limits = torch.from_numpy(elements.normals[active]), torch.from_numpy(elements.limits[active])
    offset, first, second = x[active] - torch.from_numpy(elements.anchors[active]), one[active], other[active]
    u = offset - (offset * n).sum(1, keepdim=True) * n
    square = (u**2).sum(1)
    # a node on its anchor: the second part is 0 there, and the square root is not differentiable
    y, slip = torch.sqrt(torch.clamp(square, min=1e-30)), elements.slip
    stuck = y < slip
    over = torch.where(stuck, 2.0 / slip - y / slip**2, 1.0 / y)
    along = torch.where(stuck, -1.0 / (slip**2 * y), -1.0 / y**3)
    level = (first * second).sum(1) - (n * first).sum(1) * (n * second).sum(1)
    return (limits * (over * level + along * (u * first).sum(1) * (u * second).sum(1))).sum()
