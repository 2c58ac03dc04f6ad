"""Cloth at rest against formulas of mechanics, and the ways in which the search for rest may end."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.cloth.dynamics import take_time_steps
from garmentq.core.cloth.energy import Energy
from garmentq.core.cloth.outcome import Outcome
from garmentq.core.cloth.pins import Pins, PinsBad
from garmentq.core.cloth.scene import Scene
from garmentq.core.cloth.settings import MAX_REST_RESIDUAL, ContactSettings, SettingsBad, SolveSettings
from garmentq.core.cloth.statics import NodesBad, equilibrium
from garmentq.core.cloth.topology import Topology
from garmentq.core.run.errors import Cancelled
from garmentq.core.run.hooks import Hooks
from scipy.integrate import solve_bvp
from scipy.optimize import brentq

EXACT = SolveSettings(tolerance=1e-6, rest_motion=0.0, max_iterations=300)


def test_hanging_strip_stretches_as_computed(sheet, cloth):
    """A wrong membrane force or weight breaks this: lambda H' (lambda^2 - 1) / 2 = rho g (L - s), integrated."""
    length = 1.0
    flat, faces = sheet(5, 81, 0.05, length)
    topology = Topology.from_mesh(faces, flat[faces])
    nodes = np.column_stack([flat[:, 0], flat[:, 1], np.zeros(len(flat))])
    top = np.flatnonzero(flat[:, 1] > length - 1e-9)
    drape = equilibrium(Scene(topology, cloth, pins=Pins(top, nodes[top])), nodes, settings=EXACT)
    assert drape.converged
    stiffness = cloth.H11 - cloth.H01**2 / cloth.H00  # the width is free to shrink
    below = (np.arange(400) + 0.5) / 400 * length
    stretch = [brentq(lambda x, w=w: x * stiffness * (x * x - 1) / 2 - cloth.density * 9.81 * w, 1, 2) for w in below]
    expected = float(np.mean(stretch)) * length
    reached = nodes[top, 1].max() - drape.nodes[:, 1].min()
    assert reached - length == pytest.approx(expected - length, rel=0.01)


def elastica_angle(load: float) -> float:
    """Chord angle of a clamped heavy elastica, theta'' = -load (1 - s) cos theta, load = rho g l^3 / B."""

    def slope(s, y):
        return np.vstack([y[1], -load * (1 - s) * np.cos(y[0])])

    s = np.linspace(0, 1, 200)
    guess = np.vstack([0.5 * s, 0.5 * (1 - s)])
    theta = solve_bvp(slope, lambda a, b: np.array([a[0], b[1]]), s, guess).sol(s)[0]
    return float(np.arctan2(np.trapezoid(np.sin(theta), s), np.trapezoid(np.cos(theta), s)))


@pytest.mark.parametrize("angle", [20.0, 41.5])
def test_cantilever_droops_as_peirce_says(sheet, cloth, angle):
    """A bending stiffness off by a factor breaks this: B = k / 2 = rho g l^3 cos(theta / 2) / (8 tan theta).

    The diagonals are mirrored about the strip's middle, so that the mesh does not couple bending with twist.
    """
    theta = np.deg2rad(angle)
    rigidity = cloth.k / 2
    overhang = (rigidity / (cloth.density * 9.81) * 8 * np.tan(theta) / np.cos(theta / 2)) ** (1 / 3)
    step = overhang / 30.5  # the hinge at the last held column belongs half to the free part
    half, faces = sheet(33, 2, 32 * step, step)
    mirrored = np.arange(66).reshape(33, 2) + 66
    mirrored[:, 0] = np.arange(66).reshape(33, 2)[:, 0]  # the middle line is shared
    flat = np.concatenate([half, half * [1.0, -1.0]])
    faces = np.concatenate([faces, mirrored.ravel()[faces][:, [0, 2, 1]]])
    used, faces = np.unique(faces, return_inverse=True)
    flat, faces = flat[used], faces.reshape(-1, 3)
    topology = Topology.from_mesh(faces, flat[faces])
    nodes = np.column_stack([flat[:, 0] - 2 * step, np.zeros(len(flat)), -flat[:, 1]])
    clamp = np.flatnonzero(nodes[:, 0] < 1e-9)
    pins = Pins(clamp, nodes[clamp])
    scene = Scene(topology, cloth, pins=pins)
    moving = take_time_steps(scene, nodes, steps=10, dt=0.02)
    drape = equilibrium(scene, moving.nodes, settings=EXACT)
    assert drape.converged
    tip = drape.nodes[nodes[:, 0] > nodes[:, 0].max() - 1e-9].mean(0) + [step / 2, 0.0, 0.0]
    measured = np.arctan2(-tip[1], tip[0])
    load = cloth.density * 9.81 * overhang**3
    assert measured == pytest.approx(elastica_angle(load / rigidity), rel=0.015)
    # Peirce's formula itself is 1.2 % off the elastica at 20 degrees and 5.4 % at 41.5
    assert load * np.cos(measured / 2) / (8 * np.tan(measured)) == pytest.approx(rigidity, rel=0.07)


@pytest.fixture(scope="module")
def on_sphere(sheet, cloth, grid_of):
    flat, faces = sheet(21, 21, 0.3, 0.3)
    topology = Topology.from_mesh(faces, flat[faces])
    grid = grid_of(lambda p: np.linalg.norm(p, axis=-1) - 0.1, -0.25, 0.25)
    nodes = np.column_stack([flat[:, 0] - 0.15, np.full(len(flat), 0.105), 0.15 - flat[:, 1]])
    nodes[:, 1] += np.random.default_rng(0).normal(0, 1e-4, len(nodes))
    scene = Scene(topology, cloth, grid)
    return scene, take_time_steps(scene, nodes, steps=15, dt=0.04)


def test_sheet_rests_on_sphere(on_sphere, cloth):
    """Cloth that falls through, sinks in or never comes to rest breaks this."""
    scene, state = on_sphere
    drape = equilibrium(scene, state.nodes, anchors=state.anchors)
    assert drape.converged, drape.outcome.advice
    assert np.isfinite(drape.nodes).all()
    distance = np.linalg.norm(drape.nodes, axis=1) - 0.1
    centres = np.linalg.norm(drape.nodes[scene.topology.faces].mean(1), axis=1) - 0.1
    assert distance.min() > 0.002
    assert centres.min() > 0.0
    assert drape.nodes[:, 1].max() == pytest.approx(0.1 + 0.004, abs=1e-3)


def test_cloth_that_stops_under_a_force_is_not_at_rest(on_sphere, cloth):
    """A search that nothing moves in any more, and that passes for rest whatever force is left, breaks this."""
    scene, state = on_sphere
    rest = equilibrium(scene, state.nodes, anchors=state.anchors)
    assert rest.at_rest and rest.advice == rest.outcome.advice
    assert 0.0 < rest.residual_rms <= rest.residual <= MAX_REST_RESIDUAL
    crumpled = state.nodes + np.random.default_rng(1).normal(0, 2e-3, state.nodes.shape)
    blind = SolveSettings(rest_motion=1.0, steps_per_factor=1, max_step=1e-6)  # a motion of less than a metre is none
    stuck = equilibrium(scene, crumpled, settings=blind)
    assert (stuck.outcome, stuck.converged, stuck.at_rest) == (Outcome.STILL, True, False)
    assert stuck.residual > MAX_REST_RESIDUAL and stuck.advice.startswith("not at rest: nothing moves any more")


def test_forces_on_fixed_nodes_are_no_residual(sheet, cloth):
    """A root mean square that counts nodes which a pin holds, and so halves itself, breaks this."""
    flat, faces = sheet(2, 9, 0.05, 0.4)
    topology = Topology.from_mesh(faces, flat[faces])
    nodes = np.column_stack([flat[:, 0], 1.05 * flat[:, 1], np.zeros(len(flat))])
    top = np.flatnonzero(flat[:, 1] > 0.2)
    scene = Scene(topology, cloth, pins=Pins(top, nodes[top]))
    drape = equilibrium(scene, nodes, settings=SolveSettings(max_iterations=1, steps_per_factor=1, max_step=1e-9))
    force = np.linalg.norm(Energy(scene).gradient(drape.nodes)[1], axis=1) / scene.mean_weight
    assert (force[top] == 0.0).all()
    free = np.setdiff1d(np.arange(len(nodes)), top)
    assert drape.residual_rms == pytest.approx(np.sqrt((force[free] ** 2).mean()), rel=1e-9)


def test_same_input_same_drape(on_sphere, cloth):
    """Anything random or dependent on time or order breaks this."""
    scene, state = on_sphere
    settings = SolveSettings(max_iterations=5)
    one, two = (equilibrium(scene, state.nodes, settings=settings) for _ in range(2))
    assert np.array_equal(one.nodes, two.nodes)
    assert one.residual == two.residual


def test_every_outcome_carries_its_advice():
    """An outcome without a word on what to do, or one that is read back as another, breaks this."""
    for outcome in Outcome:
        assert Outcome(str(outcome)) is outcome
        assert outcome.advice.startswith("at rest" if outcome.converged else "not at rest")
    assert [outcome for outcome in Outcome if outcome.converged] == [Outcome.CONVERGED, Outcome.STILL]


def test_outcomes_carry_advice(on_sphere, cloth):
    """A search that ends early without saying what to do breaks this."""
    scene, state = on_sphere
    few = SolveSettings(max_iterations=1, rest_motion=0.0, tolerance=1e-12)
    drape = equilibrium(scene, state.nodes, settings=few)
    assert (drape.outcome, drape.converged) == (Outcome.ITERATIONS, False)
    assert "max_iterations" in drape.outcome.advice
    hurried = replace(few, max_iterations=50, max_cpu_seconds=0.0)
    assert equilibrium(scene, state.nodes, settings=hurried).outcome is Outcome.TIME
    stopped = equilibrium(scene, state.nodes, stop=lambda legs, nodes: legs == 2)
    assert (stopped.outcome, stopped.converged) == (Outcome.STOPPED, False)


def test_equilibrium_can_be_cancelled(on_sphere, cloth):
    """A cancelled job that runs to its end breaks this."""
    scene, state = on_sphere
    with pytest.raises(Cancelled):
        equilibrium(scene, state.nodes, hooks=Hooks(is_cancelled=lambda: True))


def test_bad_input_is_refused(on_sphere, cloth):
    """NaN, a wrong count of nodes or a negative setting has to end in one clear error."""
    scene, state = on_sphere
    broken = state.nodes.copy()
    broken[3, 1] = np.nan
    for nodes in (broken, state.nodes[:-1]):
        with pytest.raises(NodesBad):
            equilibrium(scene, nodes)
    with pytest.raises(SettingsBad):
        ContactSettings(thickness=-1.0)
    with pytest.raises(SettingsBad):
        SolveSettings(max_iterations=0)
    with pytest.raises(PinsBad):
        Pins(np.array([0]), np.zeros((1, 3)), None, (0.0, 1.0, 0.0))


def test_collapsed_start_gives_no_nan(sheet, cloth):
    """All nodes in one point, where normals and strains have no direction: the result must stay finite."""
    flat, faces = sheet(5, 5, 0.1, 0.1)
    topology = Topology.from_mesh(faces, flat[faces])
    start = np.zeros((25, 3))
    pins = Pins(np.array([0, 4]), np.array([[0, 0, 0], [0, 0, 0.1]]))
    scene = Scene(topology, cloth, pins=pins)
    drape = equilibrium(scene, start, settings=SolveSettings(max_iterations=20))
    assert np.isfinite(drape.nodes).all()
    state = take_time_steps(scene, start, steps=3)
    assert np.isfinite(state.nodes).all()


def test_fixed_nodes_go_where_they_are_pinned(sheet, cloth):
    """Pins that jump (and tears the cloth), or never arrive, break this."""
    flat, faces = sheet(6, 6, 0.1, 0.1)
    topology = Topology.from_mesh(faces, flat[faces])
    nodes = np.column_stack([flat[:, 0], np.zeros(36), -flat[:, 1]])
    pins = Pins(np.arange(6), nodes[:6] + [0.0, 0.12, 0.0])
    scene = Scene(topology, cloth, pins=pins)
    first = take_time_steps(scene, nodes, steps=1)
    assert np.abs(first.nodes[:6, 1] - 0.05).max() < 1e-12  # at most max_step at once
    drape = equilibrium(scene, nodes)
    assert np.array_equal(drape.nodes[:6], pins.points)


def test_springs_hold_one_direction(sheet, cloth):
    """A waistband held in height must stay free to the side."""
    flat, faces = sheet(6, 6, 0.1, 0.1)
    topology = Topology.from_mesh(faces, flat[faces])
    nodes = np.column_stack([flat[:, 0], flat[:, 1], np.zeros(36)])
    top = np.flatnonzero(flat[:, 1] > 0.099)
    pins = Pins(top, nodes[top] + [0.5, 0.0, 0.0], 50.0, (0.0, 1.0, 0.0))
    state = take_time_steps(Scene(topology, cloth, pins=pins), nodes, steps=10)
    weight = cloth.density * 0.01 * 9.81
    assert np.abs(state.nodes[top, 0] - nodes[top, 0]).max() < 1e-3
    sag = (nodes[top, 1] - state.nodes[top, 1]).mean()
    assert sag == pytest.approx(weight / (50.0 * len(top)), rel=0.1)
