"""The thesis' linearised steps: the form that their adjoint differentiates, and the adjoint against differences."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.cloth.contact import contact_forces
from garmentq.core.cloth.derivative import ImplicitDerivative, matrix_of
from garmentq.core.cloth.energy import Energy, Inertia
from garmentq.core.cloth.hessian_form import pull_form
from garmentq.core.cloth.linearised import LinearisedSteps
from garmentq.core.cloth.parameters import Parameters
from garmentq.core.cloth.pins import Pins
from garmentq.core.cloth.sensitivity import FABRIC_PARAMETERS
from garmentq.core.cloth.solver import make_solver
from garmentq.core.cloth.unrolled import UnrolledSteps
from scipy.sparse import csr_matrix

STEPS = 4


@pytest.fixture(scope="module")
def loose(everything, crumpled):
    """The same without inertia, which the steps bring themselves; loosely held, so that the rest can move."""
    nodes = crumpled[1]
    limits = np.where(np.arange(len(nodes)) % 3 > 0, 0.01, 0.0)
    friction = everything.friction._replace(limits=limits)
    pins = replace(everything.scene.pins, points=nodes[[0, 3]] + 0.002)
    return replace(everything.scene, pins=pins), friction, nodes


def test_form_is_the_kernels_matrix(loose):
    """A part of the PSD Hessian that the form leaves out, or writes down otherwise, breaks this."""
    scene, friction, nodes = loose
    energy = Energy(replace(scene, pins=None), friction, Inertia(nodes + 0.001, 400.0))
    rng = np.random.default_rng(2)
    one, other = rng.normal(size=nodes.shape), rng.normal(size=nodes.shape)
    data = scene.topology.assemble(energy.hessian(nodes, exact=False)[2], np.zeros(len(nodes), dtype=bool))
    expected = float(one.ravel() @ matrix_of(scene.topology, data) @ other.ravel())
    assert contact_forces(scene, nodes)[0].max() > 0
    assert pull_form(energy, nodes, one, other)[0] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("held", ["springs", "fixed"])
def test_adjoint_against_central_differences(loose, held):
    """A lost third derivative, of any part of the energy and by any parameter, breaks this: steps are not solved.

    The error of the quotients falls with the square of the step down to 1e-7 m of the pattern and 1e-8 m of the nodes.
    """
    scene, friction, nodes = loose
    if held == "fixed":
        scene = replace(scene, pins=Pins(scene.pins.nodes, scene.pins.points))
    topology = scene.topology
    rng = np.random.default_rng(3)
    fields = rng.normal(size=(3, *topology.rest.corners.shape)) * 0.05
    parameters = Parameters(csr_matrix(fields.reshape(3, -1).T), FABRIC_PARAMETERS)
    linearised = LinearisedSteps(STEPS)
    solver = make_solver(topology.pattern)
    upstream = np.sin(9 * nodes[:, [1, 2, 0]] + [0.3, 0.5, 0.7])
    velocities = 0.05 * np.sin(7 * nodes)

    def move(scene, start):
        return linearised.solve(scene, start, solver, friction=friction, velocities=velocities)

    def loss(scene, start):
        return float((upstream * move(scene, start).nodes).sum())

    moved = move(scene, nodes)
    assert np.abs(moved.nodes - nodes).max() > 2e-3
    found = moved.pull(upstream)
    by_parameters = parameters.pull(scene, found)
    for n, step in enumerate([1e-7] * 3 + [1e-5] * len(FABRIC_PARAMETERS)):
        way = step * np.eye(parameters.count)[n]
        ends = [loss(parameters.move(scene, s * way), nodes) for s in (1, -1)]
        assert by_parameters[n] == pytest.approx((ends[0] - ends[1]) / (2 * step), rel=1e-6, abs=1e-9)
    way = 1e-8 * np.sin(np.arange(nodes.size)).reshape(nodes.shape)
    ends = [loss(scene, nodes + s * way) for s in (1, -1)]
    assert float((found.start * way).sum()) == pytest.approx((ends[0] - ends[1]) / 2, rel=1e-6)
    pull = 1e-8 * np.array([[1.0, 0.3, -0.5], [-0.2, 0.8, 0.4]])
    ends = [loss(replace(scene, pins=replace(scene.pins, points=scene.pins.points + s * pull)), nodes) for s in (1, -1)]
    assert float((found.pins * pull).sum()) == pytest.approx((ends[0] - ends[1]) / 2, rel=1e-6)


def test_gradient_at_rest_is_that_of_solved_steps(loose):
    """At rest a linearised step is the solved one, and so is its adjoint; a matrix that is not the exact one is not."""
    scene, friction, nodes = loose
    rest = ImplicitDerivative(tolerance=0.0).solve(scene, nodes, friction=friction)
    upstream = np.sin(9 * nodes[:, [1, 2, 0]])
    ways = (LinearisedSteps(5), UnrolledSteps(5, tolerance=0.0))
    one, two = (way.solve(scene, rest.nodes, friction=friction).pull(upstream) for way in ways)
    np.testing.assert_allclose(one.rest, two.rest, rtol=0, atol=1e-6 * np.abs(two.rest).max())
    np.testing.assert_allclose(one.fabric, two.fabric, rtol=1e-5)


def test_at_rest_nothing_moves_and_short_steps_are_the_converged_ones(loose):
    """Steps that drift away from rest, or do not approach the solved ones as they get shorter, break this."""
    scene, friction, nodes = loose
    rest = ImplicitDerivative(tolerance=0.0).solve(scene, nodes, friction=friction)
    assert np.abs(LinearisedSteps(3).solve(scene, rest.nodes, friction=friction).nodes - rest.nodes).max() < 1e-9
    off = []
    for dt in (5e-5, 2.5e-5):
        ends = [
            way.solve(scene, nodes, friction=friction).nodes for way in (LinearisedSteps(2, dt), UnrolledSteps(2, dt))
        ]
        off.append(np.abs(ends[0] - ends[1]).max() / np.abs(ends[1] - nodes).max())
    assert off[1] < 0.5 * off[0] < 0.05
