"""Cloth in motion: a twirling skirt of our own is known as one, cloth at rest stays under its weight alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.cloth.energy import Energy
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.cloth.scene import Scene, SteadyRotation
from garmentq.core.cloth.topology import Topology
from garmentq.core.garment.seams import equalise_seams
from garmentq.core.garment.templates import load_template
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.recover.drape.motion import drape_as_scanned, rotation_of, surface_rms
from garmentq.core.recover.drape.stage import DrapeSettings, drape_graded, drape_template, remesh
from garmentq.core.scan.contours.target import Target
from wearers import find_wearer

COUNT = 250


@pytest.fixture(scope="module")
def worn():
    """A skirt flared to nearly a circle on a woman: wearer, mesh and fabric."""
    wearer = find_wearer()
    straight = load_template("skirt")
    down = (straight.points[:, 1].max() - straight.points[:, 1]) / np.ptp(straight.points[:, 1])
    wide = straight.points * np.stack([1.0 + 1.2 * down, np.full(len(down), 0.7)], axis=1)
    flared = equalise_seams(straight.with_points(wide), base=straight)
    skirt = drape_template(flared, wearer, settings=DrapeSettings(template_vertices=COUNT))
    return wearer, skirt, get_fabric("cotton_poplin")


def as_scan(garment) -> Target:
    normals = vertex_normals(garment.nodes, garment.faces)
    return Target(garment.nodes, garment.faces, normals, garment.contours, (), "skirt")


@pytest.mark.slow
def test_a_twirl_is_told_from_rest(worn):
    """A load that is found where there is none, or missed where the skirt stands out, breaks this: another mesh."""
    wearer, skirt, fabric = worn
    rotation = rotation_of(wearer.body, 12.0)
    turning, turned = drape_graded(remesh(skirt, 320), wearer, fabric, as_scan(skirt), rotation=rotation)
    assert turned.converged
    found, drape = drape_as_scanned(skirt, wearer, fabric, as_scan(turning), vertex_count=COUNT)
    assert drape.converged
    assert drape.rotation is not None
    assert 8.0 <= drape.rotation.rate <= 12.0
    assert surface_rms(found, as_scan(turning)) < 0.015
    still, calm = drape_graded(remesh(skirt, COUNT), wearer, fabric, as_scan(skirt))
    assert calm.rotation is None
    assert surface_rms(still, as_scan(turning)) > 0.05
    rest = drape_as_scanned(skirt, wearer, fabric, as_scan(still), vertex_count=COUNT)[1]
    assert rest.rotation is None
    plain = drape_graded(remesh(skirt, COUNT), wearer, fabric, as_scan(still))[1]
    np.testing.assert_array_equal(rest.nodes, plain.nodes)


def test_rotation_pulls_outwards(crumpled_sheet):
    """A wrong sign, a forgotten mass or a Hessian that does not belong to the force breaks this: differences."""
    topology, nodes, cloth = crumpled_sheet
    scene = Scene(topology, cloth, gravity=(0.0, 0.0, 0.0))
    energy = Energy(replace(scene, rotation=SteadyRotation(7.0, (0.1, 5.0, -0.2))))
    calm = Energy(scene)
    pull = calm.gradient(nodes)[1] - energy.gradient(nodes)[1]
    outward = (nodes - [0.1, 5.0, -0.2]) * [1.0, 0.0, 1.0]
    np.testing.assert_allclose(pull, 49.0 * scene.masses[:, None] * outward, rtol=1e-6, atol=1e-12)
    way = np.random.default_rng(0).normal(size=nodes.shape)
    ends = [energy.value(nodes + s * 1e-6 * way) for s in (1.0, -1.0)]
    gradient = energy.gradient(nodes)[1]
    assert (ends[0] - ends[1]) / 2e-6 == pytest.approx(float((gradient * way).sum()), rel=1e-6)
    extra = energy.hessian(nodes)[2] - calm.hessian(nodes)[2]
    expected = -49.0 * scene.masses[:, None, None] * np.diag([1.0, 0.0, 1.0])
    np.testing.assert_allclose(extra[topology.pattern.diagonal], expected, rtol=1e-6, atol=1e-9)


@pytest.fixture
def crumpled_sheet():
    """A hexagon of cloth with noise."""
    ring = np.stack([np.cos(np.arange(6) * np.pi / 3), np.sin(np.arange(6) * np.pi / 3)], axis=1) * 0.02
    flat = np.concatenate([np.zeros((1, 2)), ring])
    faces = np.array([[0, 1 + k, 1 + (k + 1) % 6] for k in range(6)])
    nodes = np.column_stack([flat[:, 0], np.zeros(7), -flat[:, 1]])
    nodes += np.random.default_rng(3).normal(0, 1e-3, nodes.shape)
    return Topology.from_mesh(faces, flat[faces]), nodes, get_fabric("cotton_poplin")
