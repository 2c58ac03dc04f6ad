"""Control points and fabrics as parameters, and the operation for torch."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch
from garmentq.core.cloth.derivative import ImplicitDerivative
from garmentq.core.cloth.energy import Energy
from garmentq.core.cloth.parameters import Parameters, list_gathers, map_rest, stretch_edge
from garmentq.core.cloth.pins import Pins
from garmentq.core.cloth.scene import Scene
from garmentq.core.cloth.sensitivity import FABRIC_PARAMETERS, pull_forces
from garmentq.core.cloth.topology import Topology
from garmentq.core.cloth.torch_bridge import drape_tensor
from garmentq.core.cloth.unrolled import UnrolledSteps
from garmentq.core.garment.control import map_controls
from garmentq.core.garment.curves import edge_length
from garmentq.core.garment.pattern import Edge, EdgeRef, Panel, Pattern, Seam
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.garment.symmetry import find_symmetry
from scipy.sparse import csr_matrix


@pytest.fixture(scope="module")
def garment():
    """Two rectangles sewn along one edge, the second on the bias and with a curved hem."""
    points = np.array([[0.0, 0.0], [0.2, 0.0], [0.2, 0.3], [0.0, 0.3]])
    line, curve = Edge(), Edge("quadratic", np.array([[0.5, -0.1]]))
    front = Panel("front", points, (line,) * 4)
    back = Panel("back", points, (curve, line, line, line), translation=np.array([0.2, 0.0, 0.0]), grainline=0.6)
    return mesh_pattern(
        Pattern("pair", (front, back), (Seam(EdgeRef("front", 1), EdgeRef("back", 3)),)), edge_length=0.03
    )


def test_rest_map_gives_the_rest_triangles(garment):
    """A grainline turned the wrong way, or corners in another order than the topology's, break this."""
    rest = (map_rest(garment) @ garment.uv.ravel()).reshape(-1, 3, 2)
    np.testing.assert_allclose(rest, Topology.from_garment(garment).rest.corners, atol=1e-15)


def test_control_points_pull_back_through_the_map(garment, cloth):
    """A parameter vector that is not the control points, one by one, breaks this."""
    control = map_controls(garment)
    topology = Topology.from_garment(garment)
    parameters = Parameters.of_garment(garment, control, fabric=("k", "density"))
    rng = np.random.default_rng(0)
    nodes = garment.nodes + rng.normal(0, 2e-3, garment.nodes.shape)
    energy, weights = Energy(Scene(topology, cloth)), rng.normal(size=nodes.shape)
    rest, _ = pull_forces(energy, nodes, weights)
    found = parameters.shape.T @ rest.ravel()
    for index in (0, 5, 10, 15):
        ends = []
        for sign in (1, -1):
            points = garment.pattern.points.ravel().copy()
            points[index] += sign * 1e-6
            moved = replace(garment, uv=control.apply(points.reshape(-1, 2)))
            ends.append(Energy(Scene(Topology.from_garment(moved), cloth)).gradient(nodes)[1])
        assert found[index] == pytest.approx(float((weights * (ends[0] - ends[1])).sum()) / 2e-6, rel=1e-6)


def test_symmetry_leaves_effective_points_only():
    """Parameters of a symmetric pattern are its effective control points: both halves move as mirror images."""
    points = np.array([[-0.1, 0.0], [0.1, 0.0], [0.06, 0.2], [-0.06, 0.2]])
    flat = mesh_pattern(Pattern("apron", (Panel("apron", points, (Edge(),) * 4),), ()), edge_length=0.03)
    symmetry = find_symmetry(flat.pattern)
    parameters = Parameters.of_garment(flat, map_controls(flat), symmetry)
    assert parameters.count == 2 * len(symmetry.effective) == 4
    move = (parameters.shape @ np.array([1.0, 0.0, 1.0, 0.0])).reshape(-1, 2)
    corners = flat.rest.reshape(-1, 2)
    left, right = (int(np.abs(corners - points[n]).sum(1).argmin()) for n in (0, 1))
    np.testing.assert_allclose(move[left], -move[right], atol=1e-9)
    assert abs(move[left, 0]) == pytest.approx(1.0)


def test_fabric_moves_by_logarithms(garment, cloth):
    """A fabric parameter that may turn negative, or a derivative by the value itself, breaks this."""
    parameters = Parameters(csr_matrix((6 * len(garment.faces), 0)), ("k", "H22"))
    scene = Scene(Topology.from_garment(garment), cloth)
    moved = parameters.move(scene, np.array([np.log(2.0), -50.0]))
    assert moved.fabric.k == pytest.approx(2 * cloth.k)
    assert moved.fabric.H22 > 0
    assert moved.topology is scene.topology
    assert parameters.rates(scene)[1][FABRIC_PARAMETERS.index("k"), 0] == cloth.k


@pytest.mark.parametrize(("panel", "edge"), [("front", 1), ("back", 0)])
def test_stretched_edge_lengthens_by_its_ratio(garment, panel, edge):
    """The step is the logarithm of a gather ratio only if length' = length, curved edges included."""
    ref = EdgeRef(panel, edge)
    motion = stretch_edge(garment.pattern, ref)
    lengths = []
    for step in (1e-6, -1e-6):
        of_panel = [p.name for p in garment.pattern.panels].index(panel)
        first = garment.pattern.point_starts[of_panel]
        drawn = garment.pattern.panels[of_panel]
        moved = replace(drawn, points=drawn.points + step * motion[first : first + len(drawn.points)])
        lengths.append(edge_length(moved, edge))
    mean = 0.5 * sum(lengths)
    assert (lengths[0] - lengths[1]) / 2e-6 == pytest.approx(mean, rel=1e-6)


def draw_ruffles() -> Pattern:
    """A bib with a ruffle gathered to each side of it, mirror images, and one below."""
    line, bib = Edge(), np.array([[-0.1, 0.0], [0.1, 0.0], [0.1, 0.2], [-0.1, 0.2]])
    side = np.array([[0.1, -0.02], [0.16, -0.02], [0.15, 0.24], [0.1, 0.24]])
    left = (side * [-1.0, 1.0])[[1, 0, 3, 2]]
    below = np.array([[-0.13, -0.1], [0.13, -0.1], [0.13, 0.0], [-0.13, 0.0]])
    panels = tuple(Panel(n, p, (line,) * 4) for n, p in (("bib", bib), ("r", side), ("l", left), ("hem", below)))
    seams = [(("bib", 1), ("r", 3)), (("l", 1), ("bib", 3)), (("bib", 0), ("hem", 2))]
    return Pattern("bib", panels, tuple(Seam(EdgeRef(*a), EdgeRef(*b), gathered=True) for a, b in seams))


def test_mirror_images_share_their_gather_ratio():
    """A ruffle that may differ from its mirror image, or the shorter edge taken for the gathered one, breaks this."""
    pattern = draw_ruffles()
    gathers = list_gathers(pattern, find_symmetry(pattern))
    assert gathers == ((EdgeRef("r", 3), EdgeRef("l", 1)), (EdgeRef("hem", 2),))


@pytest.mark.parametrize("index", [0, 1])
def test_gather_ratios_are_parameters(cloth, index):
    """A column that is not the logarithm of the ratio breaks this: forces and lengths by differences."""
    pattern = draw_ruffles()
    garment = mesh_pattern(pattern, edge_length=0.03)
    gathers = list_gathers(pattern, find_symmetry(pattern))
    parameters = Parameters.of_garment(garment, map_controls(garment), gathers=gathers)
    assert parameters.count == 2 * len(pattern.points) + 2
    rng = np.random.default_rng(1)
    nodes = garment.nodes + rng.normal(0, 2e-3, garment.nodes.shape)
    scene, weights = Scene(Topology.from_garment(garment), cloth), rng.normal(size=garment.nodes.shape)
    rest, _ = pull_forces(Energy(scene), nodes, weights)
    way = np.zeros(parameters.count)
    way[-2 + index] = 1e-6
    ends = [parameters.move(scene, s * way) for s in (1, -1)]
    forces = [Energy(end).gradient(nodes)[1] for end in ends]
    change = float((weights * (forces[0] - forces[1])).sum())
    assert float((parameters.shape.T @ rest.ravel())[-2 + index]) == pytest.approx(change / 2e-6, rel=1e-6)
    on_edge = garment.edge_uv[gathers[index][0]]
    corner = int(np.flatnonzero(garment.uv_faces.ravel() == on_edge[0])[0])
    other = int(np.flatnonzero(garment.uv_faces.ravel() == on_edge[-1])[0])
    lengths = [np.linalg.norm(np.subtract(*end.topology.rest.corners.reshape(-1, 2)[[corner, other]])) for end in ends]
    assert np.log(lengths[0] / lengths[1]) / 2e-6 == pytest.approx(1.0, rel=1e-6)


@pytest.mark.parametrize("derivative", [ImplicitDerivative(tolerance=0.0), UnrolledSteps(steps=3, tolerance=0.0)])
def test_torch_passes_gradcheck(sheet, cloth, derivative):
    """A gradient that lands on the wrong input, or an output cut off from the graph, breaks this."""
    flat, faces = sheet(5, 4, 0.08, 0.06)
    topology = Topology.from_mesh(faces, flat[faces])
    nodes = np.column_stack([flat[:, 0], flat[:, 1], 0.002 * np.sin(40 * flat[:, 0])])
    top = np.flatnonzero(flat[:, 1] > 0.059)
    scene = Scene(topology, replace(cloth, k=2e-4), pins=Pins(top, nodes[top]))
    start = torch.from_numpy(derivative.solve(scene, nodes).nodes)
    uv = torch.from_numpy(flat).requires_grad_()
    logs = torch.zeros(6, dtype=torch.float64, requires_grad=True)
    pins = torch.from_numpy(nodes[top]).requires_grad_()
    values = torch.tensor([getattr(scene.fabric, name) for name in FABRIC_PARAMETERS], dtype=torch.float64)
    index = torch.from_numpy(faces)

    def loss(uv: torch.Tensor, logs: torch.Tensor, pins: torch.Tensor) -> torch.Tensor:
        x = drape_tensor(scene, derivative, start, rest=uv[index], fabric=values * torch.exp(logs), pins=pins)
        return torch.sin(20 * x + torch.arange(3, dtype=torch.float64)).sum()

    assert torch.autograd.gradcheck(loss, (uv, logs, pins), eps=1e-6, atol=1e-4, rtol=1e-4)
