"""Garments one upon the other: each keeps its own fabric, and the outer one rests on the inner one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.cloth.collision.self_contact import SelfContact
from garmentq.core.cloth.energy import Energy
from garmentq.core.cloth.fabric import Fabric
from garmentq.core.cloth.layers import stack_garments
from garmentq.core.cloth.scene import Scene
from garmentq.core.cloth.sensitivity import pull_forces
from garmentq.core.cloth.settings import SettingsBad
from garmentq.core.cloth.statics import equilibrium
from garmentq.core.cloth.topology import Topology
from garmentq.core.geometry.intersections import self_intersections
from scipy.sparse import csr_matrix


def matrix_of(topology: Topology, blocks: np.ndarray) -> csr_matrix:
    """Return the matrix of a mesh, nothing fixed."""
    pattern = topology.pattern
    return csr_matrix((topology.assemble(blocks, np.zeros(topology.node_count, bool)), pattern.indices, pattern.indptr))


def test_each_garment_keeps_its_fabric(crumpled, cloth):
    """Broken where faces, hinges or nodes of one garment are taken for the other's."""
    topology, nodes, _ = crumpled
    heavy = replace(cloth, H00=900.0, H11=500.0, k=8e-5, density=0.6)
    whole, layers = stack_garments([topology, topology], [cloth, heavy])
    moved = np.concatenate([nodes, nodes + [0.0, 1.0, 0.0]])
    together = Energy(Scene(whole, heavy, layers=layers))
    alone = [Energy(Scene(topology, fabric)) for fabric in (cloth, heavy)]
    for exact in (True, False):
        found, gradient, blocks = together.hessian(moved, exact)
        parts = [each.hessian(at, exact) for each, at in zip(alone, np.split(moved, 2), strict=True)]
        assert found == pytest.approx(sum(part[0] for part in parts), rel=1e-12)
        np.testing.assert_allclose(gradient, np.concatenate([part[1] for part in parts]), atol=1e-12)
        whole_matrix = matrix_of(whole, blocks)
        assert abs(whole_matrix[: 3 * len(nodes), 3 * len(nodes) :]).sum() == 0.0
        own = [matrix_of(topology, part[2]) for part in parts]
        for k, matrix in enumerate(own):
            half = slice(3 * len(nodes) * k, 3 * len(nodes) * (k + 1))
            assert abs(whole_matrix[half, half] - matrix).max() < 1e-9 * abs(matrix).max()
    step = np.random.default_rng(2).normal(0, 1e-3, moved.shape)
    stress = [
        each.predict_stress(at, by) for each, at, by in zip(alone, np.split(moved, 2), np.split(step, 2), strict=True)
    ]
    np.testing.assert_allclose(together.predict_stress(moved, step), np.concatenate(stress))
    with pytest.raises(SettingsBad):
        pull_forces(together, moved, np.ones_like(moved))


def tube(radius: float, around: int, along: int, height: float, rest: float) -> tuple[Topology, np.ndarray, np.ndarray]:
    """Return the topology, nodes [m] and faces of a tube about the y axis whose cloth was cut for a radius `rest`."""
    turn, level = np.meshgrid(np.arange(around + 1), np.linspace(0.0, height, along), indexing="ij")
    number = (turn[:, :, None] % around * along + np.arange(along)[None, :, None])[..., 0]
    flat = np.stack([-turn * 2.0 * np.pi * rest / around, level], axis=-1)  # outward faces
    a, b, c, d = (np.s_[:-1, :-1], np.s_[1:, :-1], np.s_[1:, 1:], np.s_[:-1, 1:])
    corners = [[a, c, b], [a, d, c]]
    faces = np.concatenate([np.stack([number[k].ravel() for k in three], axis=1) for three in corners])
    shape = np.concatenate([np.stack([flat[k].reshape(-1, 2) for k in three], axis=1) for three in corners])
    angle = 2.0 * np.pi * np.arange(around) / around
    ring = np.stack([np.cos(angle), np.zeros(around), np.sin(angle)], axis=1) * radius
    nodes = (ring[:, None] + np.linspace(0.0, height, along)[None, :, None] * [0.0, 1.0, 0.0]).reshape(-1, 3)
    return Topology.from_mesh(faces, shape), nodes, faces


def press(fabric: Fabric, radius: float, cut: float, around: int) -> float:
    """Return the force by area [Pa] of a tube cut for one radius on another [m]: dW/dr of W = H / 2 ((l^2 - 1) / 2)^2.

    H = H00 - H01^2 / H11 around, the ends are free; l the stretch of the sides of a regular polygon.
    """
    side = np.sinc(1.0 / around) / cut
    stretch = side * radius
    return (fabric.H00 - fabric.H01**2 / fabric.H11) * 0.5 * (stretch**2 - 1.0) * stretch * side


def test_the_outer_tube_rests_on_the_inner(cloth, grid_of):
    """Broken where layers share a fabric, feel each other at no distance, or the inner one does not carry the outer.

    Both are stretched over a cylinder. The inner one lies as deep in the body's contact as both press, and the outer as
    far off it as the contact of cloth lets its own pressure through.
    """
    radius, around, cuts = 0.1, 40, (0.1025, 0.1045)
    inner, low, _ = tube(radius + 3.5e-3, around, 7, 0.09, cuts[0])
    outer, high, _ = tube(radius + 7e-3, around, 7, 0.09, cuts[1])
    firm = replace(cloth, H00=600.0)
    topology, layers = stack_garments([inner, outer], [cloth, firm])
    axis = grid_of(lambda p: np.hypot(p[..., 0], p[..., 2]) - radius, -0.15, 0.15)
    contact = SelfContact.of(topology)
    scene = Scene(topology, firm, axis, gravity=(0.0, 0.0, 0.0), self_contact=contact, layers=layers)
    rest = equilibrium(scene, np.concatenate([low, high]))
    assert rest.converged and len(self_intersections(rest.nodes, topology.faces)) == 0
    radii = np.hypot(rest.nodes[:, 0], rest.nodes[:, 2]).reshape(2, around, 7)[:, :, 2:5].mean(axis=(1, 2))
    pressures = [press(*each, around) for each in zip((cloth, firm), radii, cuts, strict=True)]
    depth = np.sqrt(sum(pressures) / scene.contact.stiffness)
    assert radii[0] - radius == pytest.approx(scene.contact.thickness - depth, abs=1e-4)
    pressed = np.sqrt(pressures[1] / (3.0 * contact.settings.stiffness))  # 3 K (1 - s)^2 where cloth begins to touch
    assert radii[1] - radii[0] == pytest.approx((1.0 - pressed) * contact.settings.thickness, rel=0.15)
