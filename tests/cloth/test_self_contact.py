"""Contact of cloth with cloth: derivatives, pairs, steps that cross nothing, and where sheets come to rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sparse
from garmentq.core.cloth.collision.closest import EDGE_EDGE, NODE_FACE, closest_weights, pair_distance
from garmentq.core.cloth.collision.collision_free_step import collision_free_share
from garmentq.core.cloth.collision.coupling import extend_sparsity
from garmentq.core.cloth.collision.near_pairs import PairElements, find_near_pairs
from garmentq.core.cloth.collision.self_contact import SelfContact
from garmentq.core.cloth.dynamics import continue_time_steps, take_time_steps
from garmentq.core.cloth.energy import Energy
from garmentq.core.cloth.pins import Pins
from garmentq.core.cloth.scene import Scene
from garmentq.core.cloth.settings import SelfContactSettings, SettingsBad, SolveSettings
from garmentq.core.cloth.solver import make_solver
from garmentq.core.cloth.statics import equilibrium
from garmentq.core.cloth.topology import Topology
from garmentq.core.geometry.intersections import self_intersections
from scipy.optimize import minimize


def lay_sheets(sheet, heights, columns=7, rows=6) -> tuple[Topology, np.ndarray]:
    """Return sheets that lie level at some heights [m], each a little smaller and so with edges of its own."""
    faces, rest, nodes, count = [], [], [], 0
    for k, height in enumerate(heights):
        flat, own = sheet(columns - k % 2, rows + k % 2, 0.12 - 0.007 * k, 0.10 + 0.004 * k)
        faces.append(own + count)
        rest.append(flat[own])
        nodes.append(np.column_stack([flat[:, 0], np.full(len(flat), height), -flat[:, 1]]))
        count += len(flat)
    return Topology.from_mesh(np.concatenate(faces), np.concatenate(rest)), np.concatenate(nodes)


@pytest.fixture(scope="module")
def touching(sheet, cloth):
    """Two uneven sheets 1.5 mm apart: the contact alone, which counts from 2 mm, with room for it in the matrix."""
    topology, nodes = lay_sheets(sheet, (0.0, 1.5e-3))
    nodes = nodes + np.random.default_rng(0).normal(0, 2e-4, nodes.shape)
    scene = Scene(topology, cloth, gravity=(0.0, 0.0, 0.0), self_contact=SelfContact.of(topology))
    energy, _ = extend_sparsity(Energy(scene), make_solver(topology.pattern), nodes, missing=0.0)
    return energy, nodes


@pytest.mark.parametrize("kind", [NODE_FACE, EDGE_EDGE])
def test_nearest_points_against_a_general_minimiser(kind):
    """A region of the triangle, or an end of an edge, that is mistaken for another breaks this."""
    rng = np.random.default_rng(3)
    own, weights, rates, vector = np.arange(4), np.zeros(4), np.zeros((2, 4)), np.zeros(3)
    for _ in range(60):
        points = rng.normal(size=(4, 3))

        def at(p, points=points):
            if kind == NODE_FACE:
                w = np.array([1.0, p[0] + p[1] - 1.0, -p[0], -p[1]])
            else:
                w = np.array([1.0 - p[0], p[0], p[1] - 1.0, -p[1]])
            return w @ points

        bounds = {"bounds": [(0, 1), (0, 1)]}
        if kind == NODE_FACE:
            bounds["constraints"] = {"type": "ineq", "fun": lambda p: 1.0 - p.sum()}
        best = min(
            np.sqrt(minimize(lambda p: (at(p) ** 2).sum(), start, method="SLSQP", **bounds).fun)
            for start in ([0.3, 0.3], [0.05, 0.9], [0.9, 0.05])
        )
        closest_weights(points, own, kind, weights, rates)
        assert pair_distance(points, own, weights, vector) == pytest.approx(best, abs=1e-5)
        assert abs(weights.sum()) < 1e-12 and np.abs(rates.sum(1)).max() < 1e-12


def test_derivatives_against_differences(touching):
    """A wrong curvature of the distance or of the mollifier, or a block in the wrong slot, breaks this."""
    energy, nodes = touching
    pairs = energy.near.within(nodes, 0.0)
    assert (pairs.kinds == NODE_FACE).sum() > 50 and (pairs.kinds == EDGE_EDGE).sum() > 100
    topology = energy.scene.topology
    gradient, measured = energy.gradient(nodes)[1], np.zeros(nodes.size)
    data = topology.assemble(energy.hessian(nodes)[2], energy.scene.fixed)
    matrix = sparse.csc_matrix((data, topology.pattern.indices, topology.pattern.indptr)).toarray()
    curved = np.zeros_like(matrix)
    for i in range(nodes.size):
        step = np.zeros(nodes.size)
        step[i] = 1.0
        step = step.reshape(nodes.shape)
        measured[i] = (energy.value(nodes + 1e-8 * step) - energy.value(nodes - 1e-8 * step)) / 2e-8
        ends = [energy.gradient(nodes + s * step)[1] for s in (1e-9, -1e-9)]
        curved[:, i] = (ends[0] - ends[1]).ravel() / 2e-9
    assert np.abs(measured - gradient.ravel()).max() < 1e-7 * np.abs(gradient).max()
    assert np.abs(curved - matrix).max() < 1e-6 * np.abs(matrix).max()


def test_contact_neither_pulls_nor_turns_the_whole(touching):
    """Forces on both sides of a pair that do not balance, or that do not lie along its line, break this."""
    energy, nodes = touching
    bare = replace(energy, scene=replace(energy.scene, self_contact=None))
    forces = energy.gradient(nodes)[1] - bare.gradient(nodes)[1]
    size = np.abs(forces).max()
    assert size > 1e-3
    assert np.abs(forces.sum(0)).max() < 1e-12 * size * len(nodes)
    assert np.abs(np.cross(nodes, forces).sum(0)).max() < 1e-12 * size * len(nodes)


@pytest.mark.parametrize("room", [True, False])
def test_psd_form_has_no_negative_direction(touching, room):
    """A PSD form with the distance's curvature, or diagonal blocks below the pair's own matrix, breaks this."""
    energy, nodes = touching
    if not room:
        topology = Topology.from_mesh(energy.scene.topology.faces, energy.scene.topology.rest.corners)
        energy = replace(energy, scene=replace(energy.scene, topology=topology))
    topology, bare = energy.scene.topology, replace(energy, scene=replace(energy.scene, self_contact=None))
    data = [topology.assemble(e.hessian(nodes, exact=False)[2], e.scene.fixed) for e in (energy, bare)]
    own = sparse.csc_matrix((data[0] - data[1], topology.pattern.indices, topology.pattern.indptr)).toarray()
    assert np.linalg.eigvalsh(own).min() > -1e-9 * np.abs(own).max()


def test_flat_cloth_does_not_touch_itself(sheet, cloth):
    """A reach beyond the height of a triangle, which pushes neighbours apart at rest, breaks this."""
    flat, faces = sheet(9, 40, 0.12, 0.10)  # edges of 15 and of 2.5 mm
    topology = Topology.from_mesh(faces, flat[faces])
    nodes = np.column_stack([flat[:, 0], np.zeros(len(flat)), flat[:, 1]])
    energy = Energy(Scene(topology, cloth, self_contact=SelfContact.of(topology))).watch(nodes)
    assert energy.value(nodes) == Energy(Scene(topology, cloth)).value(nodes)
    assert len(energy.near.within(nodes, 0.0).kinds) == 0


def test_pairs_are_all_that_come_near(sheet):
    """A cell of the grid left out, a box too small for the way, or a pair counted twice breaks this."""
    topology, nodes = lay_sheets(sheet, (0.0, 3e-3))
    rng = np.random.default_rng(5)
    nodes = nodes + rng.normal(0, 1e-3, nodes.shape)
    end = nodes + np.where(nodes[:, 1:2] > 1.5e-3, [[0.02, -0.006, 0.01]], 0.0) + rng.normal(0, 1e-3, nodes.shape)
    cloth = SelfContact.of(topology)
    near = find_near_pairs(cloth, nodes, end)
    found = {(int(kind), *pair.tolist()) for kind, pair in zip(near.pairs.kinds, near.pairs.nodes, strict=True)}
    assert len(found) == len(near.pairs.kinds)
    weights, rates, vector, wanted = np.zeros(4), np.zeros((2, 4)), np.zeros(3), set()
    groups = [(NODE_FACE, (i, *f)) for i in range(len(nodes)) for f in topology.faces.tolist() if i not in f]
    edges = cloth.edges.tolist()
    groups += [(EDGE_EDGE, (*a, *b)) for n, a in enumerate(edges) for b in edges[n + 1 :] if not {*a} & {*b}]
    for t in (0.0, 0.3, 0.6, 1.0):
        at = nodes + t * (end - nodes)
        for kind, pair in groups:
            closest_weights(at, np.array(pair), kind, weights, rates)
            if pair_distance(at, np.array(pair), weights, vector) < 2e-3:
                wanted.add((kind, *pair))
    assert len(wanted) > 300 and wanted <= found


def test_no_step_tunnels():
    """A share of a step after which a pair has met, or one far shorter than it need be, breaks this."""
    rng = np.random.default_rng(7)
    own, weights, rates, vector = np.arange(4), np.zeros(4), np.zeros((2, 4)), np.zeros(3)
    cut = 0
    for kind in [NODE_FACE, EDGE_EDGE] * 200:
        points, step = rng.normal(size=(4, 3)), 3.0 * rng.normal(size=(4, 3))
        share = collision_free_share(points, step, PairElements(np.array([kind]), own[None], np.zeros((1, 3))))
        distances = []
        for t in np.linspace(0.0, 1.0, 400):
            place = points + t * step
            closest_weights(place, own, kind, weights, rates)
            distances.append(pair_distance(place, own, weights, vector))
        inside = np.linspace(0.0, 1.0, 400) <= share
        assert min(np.array(distances)[inside]) > 0.19 * distances[0]
        if share < 1.0:
            cut += 1
            place = points + share * step
            closest_weights(place, own, kind, weights, rates)
            assert pair_distance(place, own, weights, vector) < 0.25 * distances[0]
    assert cut > 50


def test_a_stack_of_sheets_falls_on_a_ball_and_crosses_nowhere(sheet, cloth, grid_of):
    """A step that is not cut where two parts meet breaks this: without contact hundreds of faces cross."""
    topology, nodes = lay_sheets(sheet, (0.053, 0.056, 0.059))
    nodes = nodes - [0.055, 0.0, -0.055]
    ball = grid_of(lambda p: np.linalg.norm(p, axis=-1) - 0.05, -0.12, 0.12)
    scene, crossed = Scene(topology, cloth, ball), []
    for kept in (replace(scene, self_contact=SelfContact.of(topology)), scene):
        x, v = nodes, None
        crossed.append([])
        for _ in range(12):
            state = take_time_steps(kept, x, v, steps=1)
            x, v = state.nodes, state.velocities
            crossed[-1].append(len(self_intersections(x, topology.faces)))
    assert max(crossed[0]) == 0
    assert max(crossed[1]) > 50


def test_settings_out_of_range_are_refused():
    """A thickness of zero that is taken as it is breaks this."""
    for wrong in ({"thickness": 0.0}, {"stiffness": -1.0}, {"friction": -0.1}):
        with pytest.raises(SettingsBad):
            SelfContactSettings(**wrong)


@pytest.fixture(scope="module")
def laid(sheet, cloth):
    """A sheet of 6 cm that lies on a held one of 12 cm, in level gravity, before it has sunk in."""
    wide, under = sheet(9, 9, 0.12, 0.12)
    small, over = sheet(5, 6, 0.06, 0.06)
    nodes = np.concatenate([
        np.column_stack([wide[:, 0], np.zeros(len(wide)), -wide[:, 1]]),
        np.column_stack([small[:, 0] + 0.021, np.full(len(small), 1.9e-3), -small[:, 1] - 0.033]),
    ])  # fmt: skip
    topology = Topology.from_mesh(np.concatenate([under, over + len(wide)]), np.concatenate([wide[under], small[over]]))
    held = np.arange(len(wide))
    scene = Scene(topology, cloth, pins=Pins(held, nodes[held]), self_contact=SelfContact.of(topology))
    return scene, nodes, slice(len(wide), None)


@pytest.mark.parametrize("share", [0.8, 1.4])
def test_sheets_slide_above_atan_mu_and_stay_below(laid, share):
    """Friction that is too weak or too strong, that creeps, or whose anchor is lost from step to step breaks this."""
    scene, nodes, upper = laid
    mu = scene.self_contact.settings.friction
    angle = np.arctan(share * mu)
    gravity = 9.81 * np.array([np.sin(angle), -np.cos(angle), 0.0])
    scene = replace(scene, gravity=tuple(gravity))
    dt, steps = 0.01, 20
    settings = SolveSettings(damping=1.0, newton_per_step=4)
    state = take_time_steps(scene, nodes, steps=steps, dt=dt, settings=settings)
    way = (state.nodes[upper] - nodes[upper])[:, 0].mean()
    free = 0.5 * (gravity[0] + mu * gravity[1]) * (steps * dt) ** 2 * (1.0 + 1.0 / steps)
    if share < 1.0:
        assert abs(way) < 2 * scene.self_contact.settings.slip
        later = continue_time_steps(scene, state, steps=steps, dt=dt, settings=settings)
        assert abs(later.nodes[upper] - state.nodes[upper]).max() < 0.1 * scene.self_contact.settings.slip
    else:
        assert way == pytest.approx(free, rel=0.1)


def test_friction_against_differences_and_balanced(touching):
    """A wrong sign or a block in the wrong slot of cloth's friction on cloth breaks this."""
    energy, nodes = touching
    rng = np.random.default_rng(11)
    given = energy.lag_friction(nodes).rubbing
    given = replace(given, anchors=given.anchors + rng.normal(0, 4e-4, given.anchors.shape))
    energy, bare = replace(energy, rubbing=given), energy
    forces = energy.gradient(nodes)[1] - bare.gradient(nodes)[1]
    assert np.abs(forces).max() > 1e-3 and np.abs(forces.sum(0)).max() < 1e-13
    topology, along = energy.scene.topology, rng.normal(size=nodes.shape)
    data = topology.assemble(energy.hessian(nodes)[2] - bare.hessian(nodes)[2], energy.scene.fixed)
    matrix = sparse.csc_matrix((data, topology.pattern.indices, topology.pattern.indptr))
    values = [e.value(nodes + s * along) for e in (energy, bare) for s in (1e-8, -1e-8)]
    slope = (values[0] - values[1] - values[2] + values[3]) / 2e-8
    assert slope == pytest.approx(float((forces * along).sum()), rel=1e-5)
    ends = [e.gradient(nodes + s * along)[1] for e in (energy, bare) for s in (1e-9, -1e-9)]
    turned = (ends[0] - ends[1] - ends[2] + ends[3]) / 2e-9
    assert np.abs(turned.ravel() - matrix @ along.ravel()).max() < 1e-5 * np.abs(turned).max()


def poke(sheet, cloth, where) -> tuple[Scene, np.ndarray]:
    """Return two level sheets 4 mm apart, the upper one pushed through the lower one by 4 mm at one of its points."""
    flat, faces = sheet(13, 13, 0.12, 0.12)
    count = len(flat)
    topology = Topology.from_mesh(np.concatenate([faces, faces + count]), np.concatenate([flat[faces]] * 2))
    upper = flat * 0.97 + 0.0017
    away = np.linalg.norm(upper - where, axis=1)
    nodes = np.concatenate([
        np.column_stack([flat[:, 0], np.zeros(count), -flat[:, 1]]),
        np.column_stack([upper[:, 0], 4e-3 - 8e-3 * np.exp(-((away / 0.02) ** 2)), -upper[:, 1]]),
    ])  # fmt: skip
    return Scene(topology, cloth, gravity=(0.0, 0.0, 0.0), self_contact=SelfContact.of(topology)), nodes


@pytest.mark.parametrize("where", [(0.06, 0.06), (0.0, 0.06)])
def test_what_starts_crossed_comes_apart(sheet, cloth, where):
    """A contour that does not contract, or contact that holds crossed faces where they are, breaks this.

    Once inside the sheet, where the contour is closed, and once at its border, where it is open.
    """
    scene, nodes = poke(sheet, cloth, np.array(where))
    faces = scene.topology.faces
    assert len(self_intersections(nodes, faces)) > 20
    rest = equilibrium(scene, nodes, settings=SolveSettings(max_iterations=1))
    assert len(self_intersections(rest.nodes, faces)) == 0
    state = take_time_steps(scene, nodes, steps=15, dt=0.01)
    assert len(self_intersections(state.nodes, faces)) == 0
