"""Internal friction of bending, and membranes that are too stiff for their mesh."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.cloth.bending_friction import MAX_HELD_SLIP_RATIO, BendingFriction, measure_angles
from garmentq.core.cloth.energy import Energy
from garmentq.core.cloth.fabrics import get_fabric, load_fabrics
from garmentq.core.cloth.locking import MAX_COARSE_MESH_STRAIN, reduce_membrane_stiffness
from garmentq.core.cloth.pins import Pins
from garmentq.core.cloth.scene import Scene
from garmentq.core.cloth.settings import SolveSettings
from garmentq.core.cloth.statics import equilibrium
from garmentq.core.cloth.topology import Topology


@pytest.fixture(scope="module")
def strip(sheet):
    """A strip of 4 cm that sticks out level, its first two rows held: topology, nodes, hold, density."""
    flat, faces = sheet(11, 3, 0.05, 0.01)
    nodes = np.column_stack([flat[:, 0], np.zeros(len(flat)), -flat[:, 1]])
    held = np.flatnonzero(flat[:, 0] < 0.0101)
    return Topology.from_mesh(faces, flat[faces]), nodes, Pins(held, nodes[held])


def droop(strip, cloth, moment: float) -> float:
    """Return by how much the free end sinks [m]."""
    topology, nodes, pins = strip
    limp = replace(cloth, k=1e-7)
    folds = BendingFriction.at(topology, nodes, moment) if moment else None
    fine = SolveSettings(max_iterations=300)
    drape = equilibrium(Scene(topology, limp, pins=pins, bending_friction=folds), nodes, settings=fine)
    assert drape.converged
    return float(-drape.nodes[:, 1].min())


def test_a_moment_that_friction_holds_bends_nothing(strip, cloth):
    """Breaks if the friction of folds is too weak or too strong: the moment at the clamp is rho g l^2 / 2 per width."""
    moment = 0.5 * cloth.density * 9.81 * 0.04**2
    assert droop(strip, cloth, 0.0) > 0.03  # so limp, it hangs straight down
    assert droop(strip, cloth, 3.0 * moment) < 2e-3
    assert droop(strip, cloth, 0.2 * moment) > 0.02


def test_folds_that_stay_cost_nothing(crumpled, cloth):
    """Breaks if angles are measured with another sign or edge than the kernel's: their own folds would push."""
    topology, nodes, _ = crumpled
    folds = BendingFriction.at(topology, nodes, 1.0)
    bare, held = (Energy(Scene(topology, cloth, bending_friction=each)) for each in (None, folds))
    assert held.value(nodes) == pytest.approx(bare.value(nodes), abs=1e-15)
    np.testing.assert_allclose(held.gradient(nodes)[1], bare.gradient(nodes)[1], atol=1e-12)
    moved = nodes + np.random.default_rng(3).normal(0, 1e-3, nodes.shape)
    assert held.value(moved) > bare.value(moved)
    turned = np.abs(measure_angles(topology, moved) - measure_angles(topology, nodes)).max()
    assert 0.01 < turned < np.pi


@pytest.mark.parametrize("middle", [0.0, 0.9 * np.pi])
def test_bending_to_and_fro_spends_what_a_bending_tester_measures(middle):
    """Breaks if folds never follow, follow at once, or jump where an angle goes past pi: the loop's area is known.

    The moment rises to 2 / sqrt 5 of M within `MAX_HELD_SLIP_RATIO` = 2 slips and stays: between -a and a the loop has
    the area 2 (2 / sqrt 5) M (2 a - 4 slips).
    """
    moment, reach = 3e-6, 0.5
    folds = BendingFriction(np.array([middle]), np.array([moment]))
    way = np.concatenate(
        [np.linspace(0, reach, 2001), np.linspace(reach, -reach, 4001), np.linspace(-reach, reach, 4001)]
    )
    spent, before = [], middle
    for angle in middle + way:
        bent = np.remainder(angle - folds.angles + np.pi, 2 * np.pi) - np.pi
        force = moment * bent / np.hypot(bent, folds.slip)
        spent.append(float(force[0] * (angle - before)))
        folds, before = (
            replace(folds, angles=folds.slide(np.remainder(np.array([angle]) + np.pi, 2 * np.pi) - np.pi)),
            angle,
        )
    area = 2.0 * (2.0 / np.sqrt(5.0)) * moment * (2.0 * reach - 2.0 * MAX_HELD_SLIP_RATIO * folds.slip)
    assert sum(spent[2001:]) == pytest.approx(area, rel=2e-3)


def test_a_soft_membrane_can_fold(sheet):
    """Breaks if softening is too little: on folds of 10 cm radius the locked membrane costs more than the bending."""
    flat, faces = sheet(21, 6, 0.4, 0.1)
    topology = Topology.from_mesh(faces, flat[faces])
    poplin, radius = get_fabric("cotton_poplin"), 0.1
    nodes = np.column_stack([radius * np.sin(flat[:, 0] / radius), flat[:, 1], radius * np.cos(flat[:, 0] / radius)])

    def cost(**parts: float) -> float:
        return Energy(Scene(topology, replace(poplin, **parts), gravity=(0.0, 0.0, 0.0))).value(nodes)

    none = {"H00": 0.0, "H01": 0.0, "H11": 0.0, "H22": 0.0}
    soft = reduce_membrane_stiffness(poplin)
    locked, bent = cost(k=0.0), cost(**none)
    assert locked > 1.5 * bent
    assert cost(k=0.0, H00=soft.H00, H01=soft.H01, H11=soft.H11, H22=soft.H22) < 0.5 * bent


def test_softened_cloth_keeps_its_length_and_its_nature():
    """Breaks if cloth is softened until it sags visibly, its anisotropy or bending is lost, or soft cloth changed."""
    for fabric in load_fabrics():
        soft = reduce_membrane_stiffness(fabric)
        sag = fabric.density * 9.81 / max(soft.H00, soft.H11)
        assert soft == fabric or sag == pytest.approx(MAX_COARSE_MESH_STRAIN)
        assert soft.H00 / soft.H11 == pytest.approx(fabric.H00 / fabric.H11)
        assert soft.H22 / soft.H11 == pytest.approx(fabric.H22 / fabric.H11)
        assert (soft.k, soft.density, soft.friction) == (fabric.k, fabric.density, fabric.friction)
        assert reduce_membrane_stiffness(soft).H11 == pytest.approx(soft.H11)
