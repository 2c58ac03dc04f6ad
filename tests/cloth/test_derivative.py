"""Derivatives of drapes against central differences of fully converged drapes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from garmentq.core.cloth.contact import contact_forces
from garmentq.core.cloth.derivative import Derivative, ImplicitDerivative
from garmentq.core.cloth.dynamics import take_time_steps
from garmentq.core.cloth.energy import Energy, Inertia
from garmentq.core.cloth.friction import Friction, lag_friction
from garmentq.core.cloth.parameters import Parameters
from garmentq.core.cloth.pins import Pins
from garmentq.core.cloth.rest import NotAtRest
from garmentq.core.cloth.scene import Scene
from garmentq.core.cloth.sensitivity import FABRIC_PARAMETERS, fabric_forces, pull_forces, push_forces
from garmentq.core.cloth.settings import SolveSettings
from garmentq.core.cloth.solver import make_solver
from garmentq.core.cloth.statics import equilibrium
from garmentq.core.cloth.topology import Topology
from garmentq.core.cloth.unrolled import UnrolledSteps
from scipy.sparse import csr_matrix

SHAPE_STEP, LOG_STEP = 1e-7, 1e-5
"""Steps of the difference quotients: 1e-7 m because a drape has folds at 0.1 mm that bend the landscape; a hundred
thousandth of the fabric. At ten times that a quotient near a fold is off by up to a twentieth."""


@dataclass(frozen=True)
class Sheet:
    """A sheet at rest on a ball, two of its nodes pinned, friction on."""

    scene: Scene
    friction: Friction
    nodes: np.ndarray
    parameters: Parameters
    upstream: np.ndarray

    def solve(self, derivative: Derivative, scene: Scene, nodes: np.ndarray, solver=None):
        """Solve with this sheet's friction."""
        return derivative.solve(scene, nodes, solver, friction=self.friction)


def lay(sheet, grid_of, cloth, count: int) -> Sheet:
    """Lay a rectangle off-centre over a ball, pull two corners up, and bring it to rest."""
    flat, faces = sheet(count, count, 0.30, 0.28)
    middle = flat - [0.13, 0.15]
    grid = grid_of(lambda p: np.linalg.norm(p, axis=-1) - 0.1, -0.25, 0.25)
    nodes = np.column_stack([middle[:, 0], np.full(len(flat), 0.103), -middle[:, 1]])
    topology = Topology.from_mesh(faces, flat[faces])
    scene = Scene(topology, cloth, grid)
    moving = take_time_steps(scene, nodes, steps=15)
    held = np.array([0, count - 1])
    pins = Pins(held, moving.nodes[held] + [0.0, 0.01, 0.0])
    settings = SolveSettings(max_iterations=300, rest_motion=0.0)
    scene = replace(scene, pins=pins)
    drape = equilibrium(scene, moving.nodes, anchors=moving.anchors, settings=settings)
    assert drape.converged
    friction = lag_friction(scene, drape.nodes, drape.anchors)
    u, v = (middle / 0.15).T
    # the rest shape's directions: wider, longer, sheared, and a dart-like swelling
    fields = [(u, 0 * u), (0 * u, v), (v, 0 * u), (u * v, v * v)]
    shape = np.stack([np.stack(field, axis=1)[faces].ravel() for field in fields], axis=1)
    upstream = np.sin(9 * drape.nodes[:, [1, 2, 0]] + [0.3, 0.5, 0.7])
    return Sheet(scene, friction, drape.nodes, Parameters(csr_matrix(shape), FABRIC_PARAMETERS), upstream)


@pytest.fixture(scope="module")
def large(sheet, grid_of, cloth):
    return lay(sheet, grid_of, cloth, 32)


@pytest.fixture(scope="module")
def small(sheet, grid_of, cloth):
    return lay(sheet, grid_of, cloth, 12)


def differ(sheet: Sheet, derivative, scene: Scene, nodes: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Return the central differences of upstream . x by every parameter."""
    solver, found = make_solver(scene.topology.pattern), []
    for direction in np.diag(steps):
        moved = [sheet.parameters.move(scene, s * direction) for s in (1, -1)]
        ends = [sheet.solve(derivative, each, nodes, solver).nodes for each in moved]
        found.append(float((sheet.upstream * (ends[0] - ends[1])).sum()) / (2 * direction.sum()))
    return np.array(found)


def step_sizes(parameters: Parameters, shape_step: float, log_step: float) -> np.ndarray:
    """Return a step for each parameter."""
    first = parameters.shape.shape[1]
    return np.repeat([shape_step, log_step], [first, parameters.count - first])


def test_forces_follow_rest_shape_and_fabric(crumpled, cloth, grid_of):
    """A wrong term in dg/dp (membrane, bending, weight, contact, inertia) breaks this; g alone, no equilibrium."""
    topology, nodes, _ = crumpled
    grid = grid_of(lambda p: p[..., 1] + 0.001)
    rng = np.random.default_rng(2)
    scene, inertia = Scene(topology, cloth, grid), Inertia(nodes + rng.normal(0, 1e-2, nodes.shape), 400.0)
    energy = Energy(scene, inertia=inertia)
    assert (contact_forces(scene, nodes)[0] > 0).sum() > 10
    weights = rng.normal(size=nodes.shape)
    rest, fabric = pull_forces(energy, nodes, weights)
    ways = rng.normal(0, 1e-3, (*topology.rest.corners.shape, 3))
    pushed = push_forces(energy, nodes, ways)
    for n in range(3):
        moved = [topology.reshape(topology.rest.corners + s * ways[..., n]) for s in (1e-4, -1e-4)]
        ends = [weights * Energy(replace(scene, topology=each), inertia=inertia).gradient(nodes)[1] for each in moved]
        expected = float((ends[0] - ends[1]).sum()) / 2e-4
        assert (rest * ways[..., n]).sum() == pytest.approx(expected, rel=1e-6)
        assert (pushed[..., n] * weights).sum() == pytest.approx(expected, rel=1e-6)
    forces = fabric_forces(energy, nodes)
    for n, name in enumerate(FABRIC_PARAMETERS):
        value = getattr(cloth, name)
        moved = [replace(scene, fabric=replace(cloth, **{name: s * value})) for s in (1.1, 0.9)]
        ends = [Energy(each, inertia=inertia).gradient(nodes)[1] for each in moved]
        np.testing.assert_allclose(forces[:, :, n] * value, (ends[0] - ends[1]) / 0.2, rtol=1e-8, atol=1e-9)
        assert fabric[n] == pytest.approx(float((forces[:, :, n] * weights).sum()), rel=1e-9)


def test_reshape_equals_a_new_topology(crumpled):
    """A rest quantity that reshape forgets breaks this."""
    topology, _, flat = crumpled
    moved = (flat * [1.1, 0.9] + 0.1 * flat[:, ::-1])[topology.faces]
    new, reshaped = Topology.from_mesh(topology.faces, moved), topology.reshape(moved)
    for name in ("corners", "gradients", "areas", "node_areas"):
        np.testing.assert_array_equal(getattr(reshaped.rest, name), getattr(new.rest, name), err_msg=name)
    np.testing.assert_array_equal(reshaped.hinge_scale, new.hinge_scale)


@pytest.mark.slow
def test_implicit_against_central_differences(large):
    """A wrong adjoint, Hessian or dg/dp breaks this: 1K nodes, contact, friction and pins on, every parameter kind."""
    implicit = ImplicitDerivative(tolerance=0.0)
    rest = large.solve(implicit, large.scene, large.nodes)
    assert (contact_forces(large.scene, rest.nodes)[0] > 0).sum() > 50
    found = large.parameters.pull(large.scene, rest.pull(large.upstream))
    expected = differ(large, implicit, large.scene, rest.nodes, step_sizes(large.parameters, SHAPE_STEP, LOG_STEP))
    np.testing.assert_allclose(found, expected, rtol=1e-5)


def test_push_and_pull_are_transposes(large):
    """A push that forgets a term of the pull, or fixed nodes that move, break this."""
    rest = large.solve(ImplicitDerivative(), large.scene, large.nodes)
    moves = rest.push(*large.parameters.rates(large.scene))
    found = large.parameters.pull(large.scene, rest.pull(large.upstream))
    np.testing.assert_allclose(np.einsum("vd,vdp->p", large.upstream, moves), found, rtol=1e-9)
    assert not moves[large.scene.fixed].any()


def pin_differences(sheet: Sheet, scene: Scene, derivative, nodes: np.ndarray) -> np.ndarray:
    """Return the central differences of upstream . x by the pinned points."""
    pins, solver = scene.pins, make_solver(scene.topology.pattern)
    found = np.zeros_like(pins.points)
    for place in np.ndindex(found.shape):
        ends = []
        for sign in (1, -1):
            points = pins.points.copy()
            points[place] += sign * SHAPE_STEP
            moved = replace(scene, pins=replace(pins, points=points))
            ends.append(sheet.solve(derivative, moved, nodes, solver).nodes)
        found[place] = float((sheet.upstream * (ends[0] - ends[1])).sum()) / (2 * SHAPE_STEP)
    return found


@pytest.mark.parametrize("stiffness", [None, 5.0])
def test_pins_differentiate(small, stiffness):
    """A pinned point whose pull on its neighbours is forgotten, or a spring of the wrong sign, breaks this."""
    scene = replace(small.scene, pins=replace(small.scene.pins, stiffness=stiffness))
    implicit = ImplicitDerivative(tolerance=0.0)
    rest = small.solve(implicit, scene, small.nodes)
    found = rest.pull(small.upstream).pins
    expected = pin_differences(small, scene, implicit, rest.nodes)
    np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-5 * np.abs(expected).max())


def test_loose_cloth_has_no_derivative(crumpled, cloth):
    """A derivative of cloth that falls for ever would be noise; it must be refused."""
    topology, nodes, _ = crumpled
    with pytest.raises(NotAtRest):
        ImplicitDerivative(max_iterations=5).solve(Scene(topology, cloth), nodes)


def test_unrolled_against_central_differences(small):
    """A wrong step adjoint or a lost term of inertia breaks this: the sheet moves by 2 cm, in 6 steps.

    An eightieth of a second, so that inertia leaves each step one minimum: in longer ones a sheet that buckles has two,
    and a quotient's two ends may part.
    """
    start = small.nodes
    scene = small.parameters.move(small.scene, np.array([0.01, -0.01, 0.005, 0.01] + 6 * [0.0]))
    unrolled = UnrolledSteps(steps=6, dt=0.0125, tolerance=0.0)
    moved = small.solve(unrolled, scene, start)
    assert np.abs(moved.nodes - start).max() > 1e-2
    found = moved.pull(small.upstream)
    # the third derivative is large: 1e-7 m and 1e-5 keep its share under 1e-6; 1e-9 is the quotients' round-off
    expected = differ(small, unrolled, scene, start, step_sizes(small.parameters, 1e-7, 1e-5))
    np.testing.assert_allclose(small.parameters.pull(scene, found), expected, rtol=1e-6, atol=1e-9)
    way = 1e-7 * np.sin(np.arange(start.size)).reshape(start.shape)
    ends = [small.solve(unrolled, scene, start + s * way).nodes for s in (1, -1)]
    change = float((small.upstream * (ends[0] - ends[1])).sum()) / 2
    assert float((found.start * way).sum()) == pytest.approx(change, rel=1e-5)


def test_unrolled_sums_losses_along_the_way(small):
    """A loss on every step must be the sum of losses on single steps (targets in motion)."""
    scene = small.parameters.move(small.scene, np.array([0.01, 0.0, 0.0, 0.0] + 6 * [0.0]))
    moved = small.solve(UnrolledSteps(steps=3), scene, small.nodes)
    every = moved.pull(np.stack([small.upstream, 0 * small.upstream, 2 * small.upstream]))
    first = small.solve(UnrolledSteps(steps=1), scene, small.nodes).pull(small.upstream)
    last = moved.pull(2 * small.upstream)
    np.testing.assert_allclose(every.rest, first.rest + last.rest, atol=1e-6 * np.abs(every.rest).max())


def test_both_agree_on_a_settled_drape(small):
    """The two ways disagree where one of them is wrong: 20 steps at rest give the equilibrium's gradient."""
    rest = small.solve(ImplicitDerivative(tolerance=0.0), small.scene, small.nodes)
    one = small.parameters.pull(small.scene, rest.pull(small.upstream))
    moved = small.solve(UnrolledSteps(steps=20), small.scene, rest.nodes)
    two = small.parameters.pull(small.scene, moved.pull(small.upstream))
    assert one @ two / np.linalg.norm(one) / np.linalg.norm(two) > 0.9999


def test_damped_steps_swing_into_the_gradient_at_rest(small):
    """Breaks where damping is lost on the way back: what undamped steps leave of the difference falls to a tenth."""
    rest = small.solve(ImplicitDerivative(tolerance=0.0), small.scene, small.nodes)
    expected = rest.pull(small.upstream).rest
    off = []
    for damping in (1.0, 0.6):
        moved = small.solve(UnrolledSteps(steps=20, damping=damping), small.scene, rest.nodes)
        off.append(np.linalg.norm(moved.pull(small.upstream).rest - expected) / np.linalg.norm(expected))
    assert off[1] < 0.1 * off[0]
    assert off[1] < 1e-2
