"""The cloth's energy: derivatives, an independent oracle in torch, and what must not change it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sparse
import torch
from garmentq.core.cloth.bending_friction import measure_angles
from garmentq.core.cloth.contact import contact_forces
from garmentq.core.cloth.energy import Energy
from garmentq.core.cloth.pins import Pins
from garmentq.core.cloth.scene import Scene
from garmentq.core.cloth.topology import Topology, TopologyBad
from scipy.spatial.transform import Rotation


def dense(topology: Topology, data: np.ndarray) -> np.ndarray:
    return sparse.csc_matrix((data, topology.pattern.indices, topology.pattern.indptr)).toarray()


def test_gradient_against_differences(everything, crumpled):
    """A wrong sign or factor in any term's force, contact and friction included, breaks this."""
    _, nodes, _ = crumpled
    assert contact_forces(everything.scene, nodes)[0].max() > 0.1  # contact is on
    _, gradient = everything.gradient(nodes)
    measured = np.zeros(nodes.size)
    for i in range(nodes.size):
        step = np.zeros(nodes.size)
        step[i] = 1e-6
        step = step.reshape(nodes.shape)
        measured[i] = (everything.value(nodes + step) - everything.value(nodes - step)) / 2e-6
    assert np.abs(measured - gradient.ravel()).max() < 1e-7 * np.abs(gradient).max()


def test_hessian_against_differences(everything, crumpled):
    """A missing curvature term (of a hinge, of the distance) or a block in the wrong slot breaks this."""
    topology, nodes, _ = crumpled
    _, _, blocks = everything.hessian(nodes)
    matrix = dense(topology, topology.assemble(blocks, everything.scene.fixed))
    assert np.abs(matrix - matrix.T).max() < 1e-12 * np.abs(matrix).max()
    measured = np.zeros_like(matrix)
    for i in range(nodes.size):
        step = np.zeros(nodes.size)
        step[i] = 1e-7
        step = step.reshape(nodes.shape)
        measured[:, i] = (everything.gradient(nodes + step)[1] - everything.gradient(nodes - step)[1]).ravel() / 2e-7
    assert np.abs(measured - matrix).max() < 1e-7 * np.abs(matrix).max()


def test_psd_form_has_no_negative_direction(everything, crumpled):
    """A projection that leaves compression in breaks this: the exact form has negative eigenvalues here."""
    topology, nodes, _ = crumpled
    bare = replace(everything, inertia=None, scene=replace(everything.scene, pins=None))
    psd = dense(topology, topology.assemble(bare.hessian(nodes, exact=False)[2], bare.scene.fixed))
    exact = dense(topology, topology.assemble(bare.hessian(nodes)[2], bare.scene.fixed))
    scale = np.abs(psd).max()
    assert np.linalg.eigvalsh(psd).min() > -1e-9 * scale
    assert np.linalg.eigvalsh(exact).min() < -1e-3 * scale


def torch_energy(x, topology, fabric, centre, radius, thickness, stiffness):
    """The same physics written down once more, with another contact distance (exact), in plain torch."""
    faces, rest = torch.as_tensor(topology.faces), torch.as_tensor(topology.rest.corners)
    base = torch.stack([rest[:, 1] - rest[:, 0], rest[:, 2] - rest[:, 0]], dim=-1)
    area = base.det().abs() / 2
    edges = torch.stack([x[faces[:, 1]] - x[faces[:, 0]], x[faces[:, 2]] - x[faces[:, 0]]], dim=-1)
    F = edges @ torch.linalg.inv(base)
    strain = (F.transpose(1, 2) @ F - torch.eye(2, dtype=x.dtype)) / 2
    e0, e1, e2 = strain[:, 0, 0], strain[:, 1, 1], strain[:, 0, 1]
    density = fabric.H00 * e0**2 + 2 * fabric.H01 * e0 * e1 + fabric.H11 * e1**2 + fabric.H22 * e2**2
    energy = (area * density).sum() / 2
    total = 0.0
    owners = {}
    for f, face in enumerate(topology.faces.tolist()):
        for c in range(3):
            owners.setdefault(frozenset((face[c], face[(c + 1) % 3])), []).append(f)
    normal = torch.linalg.cross(edges[..., 0], edges[..., 1])
    normal = normal / normal.norm(dim=1, keepdim=True)
    for pair, (f, *more) in owners.items():
        if more:
            a, b = pair
            spot = {int(n): rest[f, c] for c, n in enumerate(topology.faces[f])}
            length = (spot[a] - spot[b]).norm() ** 2
            angle = torch.arccos(torch.clamp((normal[f] * normal[more[0]]).sum(), -1 + 1e-14, 1 - 1e-14))
            total = total + 2 * fabric.k * length / (area[f] + area[more[0]]) * (1 - torch.cos(angle / 2))
    lumped = torch.zeros(len(x), dtype=x.dtype).index_add(0, faces.reshape(-1), (area / 3).repeat_interleave(3))
    weight = fabric.density * 9.81 * (lumped * x[:, 1]).sum()
    depth = torch.relu(thickness - ((x - centre).norm(dim=1) - radius))
    return energy + total + weight + (lumped * stiffness / 3 * depth**3).sum()


def test_against_torch_oracle(crumpled, cloth, grid_of):
    """Any disagreement with an independent transcription of eq. 3.3, 3.4 and the contact law breaks this."""
    topology, nodes, _ = crumpled
    centre = np.array([0.06, -0.1, 0.05])
    grid = grid_of(lambda p: np.linalg.norm(p - centre, axis=-1) - 0.1, -0.15, 0.25)
    ours = Energy(Scene(topology, cloth, grid))
    x = torch.tensor(nodes, requires_grad=True)
    theirs = torch_energy(x, topology, cloth, torch.tensor(centre), 0.1, 4e-3, 1e8)
    theirs.backward()
    value, gradient = ours.gradient(nodes)
    # the grid's distance is not the exact one: 1e-3 in contact, round-off without it
    assert value == pytest.approx(theirs.item(), rel=1e-3)
    bare = Energy(Scene(topology, cloth))
    y = torch.tensor(nodes, requires_grad=True)
    free = torch_energy(y, topology, cloth, torch.tensor(centre) - 9.0, 0.1, 4e-3, 1e8)
    free.backward()
    value, gradient = bare.gradient(nodes)
    assert value == pytest.approx(free.item(), rel=1e-12)
    assert np.abs(gradient - y.grad.numpy()).max() < 1e-9 * np.abs(gradient).max()


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_rigid_motion_costs_nothing(crumpled, cloth, seed):
    """An energy that sees the frame of reference breaks this; forces must turn with the cloth."""
    topology, nodes, _ = crumpled
    energy = Energy(Scene(topology, cloth, gravity=(0.0, 0.0, 0.0)))
    rng = np.random.default_rng(seed)
    turn = Rotation.random(random_state=rng).as_matrix()
    moved = nodes @ turn.T + rng.normal(0, 1, 3)
    value, gradient = energy.gradient(nodes)
    again, turned = energy.gradient(moved)
    assert again == pytest.approx(value, rel=1e-10)
    assert np.abs(turned - gradient @ turn.T).max() < 1e-9 * np.abs(gradient).max()
    assert np.abs(gradient.sum(0)).max() < 1e-10 * np.abs(gradient).max()  # no net force


def test_rest_shape_is_at_rest(crumpled, cloth):
    """A prestressed rest shape breaks this: flat cloth without weight has no energy and no force."""
    topology, _, flat = crumpled
    nodes = np.column_stack([flat, np.zeros(len(flat))])
    value, gradient = Energy(Scene(topology, cloth, gravity=(0.0, 0.0, 0.0))).gradient(nodes)
    assert abs(value) < 1e-20
    assert np.abs(gradient).max() < 1e-10


def test_cylinder_costs_half_of_k(sheet, cloth):
    """The relation B = k / 2 that the fabric library rests on: a cylinder costs k kappa^2 / 4 per area."""
    flat, faces = sheet(81, 5, 0.4, 0.02)
    topology = Topology.from_mesh(faces, flat[faces])
    radius = 0.2
    nodes = np.column_stack([radius * np.sin(flat[:, 0] / radius), flat[:, 1], radius * np.cos(flat[:, 0] / radius)])
    bare = replace(cloth, H00=0.0, H01=0.0, H11=0.0, H22=0.0)
    energy = Energy(Scene(topology, bare, gravity=(0.0, 0.0, 0.0))).value(nodes)
    inner = 79 / 80  # the first and last half cell have no hinge
    assert energy == pytest.approx(cloth.k / radius**2 / 4 * 0.4 * 0.02 * inner, rel=2e-3)


@pytest.mark.parametrize("rest", [0.0, 0.7, -2.5])
@pytest.mark.parametrize("angle", [1e-7, 0.3, -1.2, 1.6, -2.9, 3.1])
def test_one_hinge_folds_as_its_formula_says(cloth, angle, rest):
    """A half angle of the wrong quadrant beyond a right angle, or small angles lost in 1 - cos, breaks this."""
    flat = np.array([[0.0, 0.0], [0.02, 0.0], [0.01, 0.02], [0.01, -0.02]])
    faces = np.array([[0, 1, 2], [1, 0, 3]])
    topology = Topology.from_mesh(faces, flat[faces], rest_angles=np.array([rest]))
    nodes = np.column_stack([flat, np.zeros(4)])
    nodes[3, 1:] = -0.02 * np.cos(angle), -0.02 * np.sin(angle)
    measured = float(measure_angles(topology, nodes)[0])
    assert abs(measured) == pytest.approx(abs(angle), rel=1e-8)
    expected = 4.0 * cloth.k * topology.hinge_scale[0] * np.sin(0.25 * (measured - rest)) ** 2
    flat_out = replace(cloth, H00=1e-30, H01=0.0, H11=1e-30, H22=1e-30)
    energy = Energy(Scene(topology, flat_out, gravity=(0.0, 0.0, 0.0)))
    # the formula's period is two turns: an angle that has passed half a turn against its rest is still told
    assert energy.value(nodes) == pytest.approx(expected, rel=1e-9)


def test_fixed_nodes_feel_nothing(crumpled, cloth):
    """A fixed node whose row leaks into the system breaks this."""
    topology, nodes, _ = crumpled
    energy = Energy(Scene(topology, cloth, pins=Pins(np.array([4, 9]), nodes[[4, 9]])))
    _, gradient, blocks = energy.hessian(nodes)
    matrix = dense(topology, topology.assemble(blocks, energy.scene.fixed))
    rows = (3 * np.array([[4], [9]]) + np.arange(3)).ravel()
    assert not gradient[[4, 9]].any()
    assert np.array_equal(matrix[rows], np.eye(len(matrix))[rows])


def test_bad_meshes_are_refused(sheet):
    """A mesh that would divide by zero or read past the end has to end in one clear error."""
    flat, faces = sheet(3, 3, 0.1, 0.1)
    with pytest.raises(TopologyBad, match="node that does not exist"):
        Topology.from_mesh(faces + 5, flat[faces], len(flat))
    with pytest.raises(TopologyBad, match="no area"):
        Topology.from_mesh(faces, flat[faces] * [1.0, 0.0], len(flat))
    with pytest.raises(TopologyBad, match="no triangles"):
        Topology.from_mesh(np.zeros((0, 3), dtype=int), np.zeros((0, 3, 2)))
