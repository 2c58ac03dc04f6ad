"""The way to rest that derivatives are taken at: what one step foresees, what it costs, and where it must not stop."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.cloth.energy import Energy, Inertia
from garmentq.core.cloth.pins import Pins
from garmentq.core.cloth.rest import NotAtRest, RestSettings, find_rest
from garmentq.core.cloth.scene import Scene
from garmentq.core.cloth.solver import make_solver
from garmentq.core.cloth.topology import Topology


class Counting:
    """Count the matrices that a solver is asked to factor."""

    def __init__(self, topology: Topology) -> None:
        self.solver, self.factors = make_solver(topology.pattern), 0
        self.solve, self.is_positive_definite = self.solver.solve, self.solver.is_positive_definite

    def factor(self, data: np.ndarray) -> bool:
        """Factor and count."""
        self.factors += 1
        return self.solver.factor(data)


@pytest.fixture(scope="module")
def strip(sheet, cloth):
    """A strip that lies flat between two held ends."""
    flat, faces = sheet(25, 6, 0.24, 0.05)
    topology = Topology.from_mesh(faces, flat[faces])
    nodes = np.column_stack([flat[:, 0], np.zeros(len(flat)), flat[:, 1]])
    held = np.flatnonzero((flat[:, 0] < 1e-9) | (flat[:, 0] > 0.24 - 1e-9))
    return Scene(topology, cloth, pins=Pins(held, nodes[held])), nodes


def test_foreseen_stress_is_linear_in_the_step(crumpled, cloth):
    """A wrong term of the strain's derivative breaks this: no step gives the stress at hand, a long one no square."""
    topology, nodes, _ = crumpled
    energy = Energy(Scene(topology, cloth))
    step = np.random.default_rng(1).normal(0, 2e-3, nodes.shape)
    here = energy.predict_stress(nodes, 0 * step)
    blocks = energy.hessian(nodes)[2]
    np.testing.assert_allclose(energy.hessian(nodes, stress=here)[2], blocks, atol=1e-12 * np.abs(blocks).max())
    small = 1e-5
    slope = (
        energy.predict_stress(nodes + small * step, 0 * step) - energy.predict_stress(nodes - small * step, 0 * step)
    ) / (2 * small)
    np.testing.assert_allclose(energy.predict_stress(nodes, step), here + slope, atol=1e-7 * np.abs(slope).max())
    assert np.abs(energy.hessian(nodes, stress=here + slope)[2] - blocks).max() > 1e-3 * np.abs(blocks).max()


def test_a_swing_takes_few_factors(strip):
    """Where steps may not climb, or Hessians hold the stretch of a straight step, this swing of 2 cm takes 5."""
    scene, flat = strip
    nodes = np.column_stack([flat[:, 1], -flat[:, 0], flat[:, 2]])
    top = np.flatnonzero(flat[:, 0] < 1e-9)
    hanging = replace(scene, pins=Pins(top, nodes[top]))
    start = find_rest(Energy(hanging), nodes, make_solver(scene.topology.pattern), RestSettings(1e-6, 100))
    blown = Energy(replace(hanging, gravity=(10.0, -9.81, 0.0)), inertia=Inertia(start, 400.0))
    solver = Counting(scene.topology)
    moved = find_rest(blown, start, solver, RestSettings(1e-6, 100))
    assert hanging.relative_residual(blown.gradient(moved)[1]) <= 1e-6
    assert np.abs(moved - start).max() > 0.02
    assert solver.factors <= 4


def test_pressed_cloth_buckles(strip):
    """Stopping at the saddle breaks this: pressed by a tenth a strip balances flat, but for a thousandth of a mm."""
    scene, nodes = strip
    pins = replace(scene.pins, points=scene.pins.points * [0.9, 1, 1])
    pressed = Energy(replace(scene, gravity=(0.0, 0.0, 0.0), pins=pins))
    start = nodes * [0.9, 1.0, 1.0]
    start[:, 1] = 1e-6 * np.sin(np.pi * start[:, 0] / 0.216)
    start[scene.fixed, 1] = 0.0
    solver = make_solver(scene.topology.pattern)
    rest = find_rest(pressed, start, solver, RestSettings(1e-6, 200))
    assert scene.relative_residual(pressed.gradient(rest)[1]) <= 1e-6
    assert rest[:, 1].max() > 0.01
    assert pressed.value(rest) < 0.1 * pressed.value(start)
    assert solver.factor(scene.topology.assemble(pressed.hessian(rest)[2], scene.fixed))


def test_gives_up_in_time(strip):
    """A limit that counts only some of the factors breaks this."""
    scene, nodes = strip
    pins = replace(scene.pins, points=scene.pins.points * [0.9, 1, 1])
    pressed = Energy(replace(scene, pins=pins))
    solver = Counting(scene.topology)
    with pytest.raises(NotAtRest):
        find_rest(pressed, nodes * [0.9, 1.0, 1.0], solver, RestSettings(0.0, 4))
    assert solver.factors <= 4
