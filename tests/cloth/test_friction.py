"""Coulomb friction on a slope: what lies below atan(mu) stays, what lies above slides, and how fast."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.cloth.dynamics import take_time_steps
from garmentq.core.cloth.scene import Scene
from garmentq.core.cloth.settings import ContactSettings, SolveSettings
from garmentq.core.cloth.statics import equilibrium
from garmentq.core.cloth.topology import Topology

MU = 0.4  # atan(0.4) = 21.8 degrees


def on_slope(sheet, grid_of, fabric, degrees, size=0.08, count=6):
    """A sheet just touching a slope that falls towards +x: topology, grid, nodes, unit vector down the slope."""
    angle = np.deg2rad(degrees)
    normal = np.array([np.sin(angle), np.cos(angle), 0.0])
    down = np.array([np.cos(angle), -np.sin(angle), 0.0])
    flat, faces = sheet(count, count, size, size)
    topology = Topology.from_mesh(faces, flat[faces])
    side = np.array([0.0, 0.0, -1.0])
    # where contact carries the weight: depth z with k z^2 = rho g cos
    depth = np.sqrt(fabric.density * 9.81 * np.cos(angle) / 1e8)
    nodes = (flat[:, :1] - size / 2) * down + (flat[:, 1:] - size / 2) * side + (4e-3 - depth) * normal
    return topology, grid_of(lambda p: p @ normal), nodes, down


def fabrics(cloth):
    soft = replace(cloth, friction=MU)
    block = replace(cloth, friction=MU, H00=2e4, H11=2e4, H01=0.0, H22=2e4, k=5.0, density=5.0)
    return {"cloth": soft, "block": block}


@pytest.mark.parametrize("kind", ["cloth", "block"])
def test_stays_below_the_friction_angle(sheet, grid_of, cloth, kind):
    """Friction that creeps breaks this: after a second at 18 degrees the sheet is where it was within `slip`."""
    fabric = fabrics(cloth)[kind]
    topology, grid, nodes, down = on_slope(sheet, grid_of, fabric, 18.0)
    scene = Scene(topology, fabric, grid)
    state = take_time_steps(scene, nodes, steps=25, dt=0.04)
    assert np.abs((state.nodes - nodes) @ down).max() < 6e-4
    later = take_time_steps(scene, state.nodes, state.velocities, steps=10, dt=0.04, anchors=state.anchors)
    assert np.abs((later.nodes - state.nodes) @ down).max() < 5e-5
    drape = equilibrium(scene, nodes)
    assert drape.converged
    assert np.abs((drape.nodes - nodes) @ down).max() < 6e-4


@pytest.mark.parametrize("kind", ["cloth", "block"])
def test_slides_above_the_friction_angle(sheet, grid_of, cloth, kind):
    """Friction that sticks, or exceeds mu N, breaks this: s = g (sin - mu cos) t^2 / 2 at 28 degrees."""
    fabric = fabrics(cloth)[kind]
    topology, grid, nodes, down = on_slope(sheet, grid_of, fabric, 28.0)
    settings = SolveSettings(damping=1.0)
    state = take_time_steps(Scene(topology, fabric, grid), nodes, steps=40, dt=0.01, settings=settings)
    angle, time = np.deg2rad(28.0), 0.4
    expected = 9.81 * (np.sin(angle) - MU * np.cos(angle)) * time**2 / 2
    # implicit Euler runs ahead by half a step (2.5 %), the first `slip` is braked less
    assert ((state.nodes - nodes) @ down).mean() == pytest.approx(expected, rel=0.08)


def test_no_friction_slides_at_once(sheet, grid_of, cloth):
    """A switch that does nothing breaks this."""
    fabric = fabrics(cloth)["cloth"]
    topology, grid, nodes, down = on_slope(sheet, grid_of, fabric, 18.0)
    scene = Scene(topology, fabric, grid, contact=ContactSettings(friction=False))
    state = take_time_steps(scene, nodes, steps=10, dt=0.04)
    assert ((state.nodes - nodes) @ down).mean() > 0.05
