"""Cloth that touches itself at rest and in motion: folds, ropes, stacks and the derivative through contact."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.cloth.collision.self_contact import SelfContact
from garmentq.core.cloth.derivative import ImplicitDerivative
from garmentq.core.cloth.dynamics import ClothState, continue_time_steps, take_time_steps
from garmentq.core.cloth.pins import Pins
from garmentq.core.cloth.scene import Scene
from garmentq.core.cloth.sensitivity import FABRIC_PARAMETERS
from garmentq.core.cloth.settings import SelfContactSettings, SolveSettings
from garmentq.core.cloth.solver import make_solver
from garmentq.core.cloth.statics import equilibrium
from garmentq.core.cloth.topology import Topology
from garmentq.core.geometry.intersections import self_intersections


def test_a_folded_sheet_lies_at_the_thickness(sheet, cloth, grid_of):
    """A law whose pressure per area depends on the mesh, or whose force is no gradient of it, breaks this."""
    flat, faces = sheet(25, 9, 0.24, 0.08)
    topology = Topology.from_mesh(faces, flat[faces])
    radius = 4e-3
    half = 0.12 - 0.5 * np.pi * radius
    along = flat[:, 0]
    angle = np.clip((along - half) / radius, 0.0, np.pi)
    x = np.where(along < half, along, half + radius * np.sin(angle))
    x = np.where(angle >= np.pi, half - (along - half - np.pi * radius), x) - 0.06
    nodes = np.column_stack([x, 4e-3 + radius * (1.0 - np.cos(angle)), 0.04 - flat[:, 1]])
    table = grid_of(lambda p: p[..., 1], -0.15, 0.15)
    soft = replace(cloth, k=1e-6)
    scene = Scene(topology, soft, table, self_contact=SelfContact.of(topology))
    state = take_time_steps(scene, nodes, steps=20, dt=0.02)
    rest = equilibrium(scene, state.nodes, anchors=state.anchors)
    assert rest.converged and len(self_intersections(rest.nodes, faces)) == 0
    over = along > 0.24 - 0.06
    gap = rest.nodes[over, 1] - np.interp(rest.nodes[over, 0], *_profile(rest.nodes[along < 0.1]))
    thickness = scene.self_contact.settings.thickness
    assert 0.85 * thickness < np.median(gap) < thickness


def _profile(nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return heights over x, both [m], of the rows of a sheet, ascending."""
    x = np.round(nodes[:, 0], 3)
    columns = np.unique(x)
    return columns, np.array([nodes[x == c, 1].mean() for c in columns])


def twist(sheet, cloth, size: tuple[float, float], turns: float, steps: int) -> tuple[list[int], float]:
    """Twist a strip of some width and length [m] about its length, the ends drawn in as they turn.

    Returns the crossings after each step, and how far the ends are from where they are to be at last [m].
    """
    width, length = size
    flat, faces = sheet(5, round(4.0 * length / width) + 1, width, length)
    topology = Topology.from_mesh(faces, flat[faces])
    nodes = np.column_stack([flat[:, 0] - 0.5 * width, flat[:, 1], np.zeros(len(flat))])
    ends = np.flatnonzero((flat[:, 1] == 0.0) | (flat[:, 1] == flat[:, 1].max()))
    start, upper = nodes[ends], nodes[ends, 1] > 0.5 * length
    scene = Scene(topology, cloth, gravity=(0.0, 0.0, 0.0), self_contact=SelfContact.of(topology))
    state, crossed, solver = ClothState(nodes, np.zeros_like(nodes), nodes), [], make_solver(topology.pattern)
    for n in range(1, steps + 1):
        angle = np.where(upper, 1.0, -1.0) * np.pi * turns * n / steps
        turned = np.column_stack([
            np.cos(angle) * start[:, 0],
            start[:, 1] - np.where(upper, 0.5 * length * min(0.8, 0.05 * turns) * n / steps, 0.0),
            np.sin(angle) * start[:, 0],
        ])  # fmt: skip
        state = continue_time_steps(replace(scene, pins=Pins(ends, turned)), state, steps=1, dt=0.02, solver=solver)
        crossed.append(len(self_intersections(state.nodes, faces)))
    return crossed, float(np.abs(state.nodes[ends] - turned).max())


def test_a_rope_of_one_turn_crosses_nowhere(sheet, cloth):
    """A pair that is not found while cloth winds up, or a pinned node that is moved through cloth, breaks this."""
    crossed, left = twist(sheet, cloth, (0.04, 0.2), 1.0, 20)
    assert max(crossed) == 0 and left < 1e-12


@pytest.mark.nightly
def test_a_rope_of_ten_turns_crosses_nowhere(sheet, cloth):
    """The same wound up until cloth lies on cloth on cloth."""
    crossed, left = twist(sheet, cloth, (0.025, 0.45), 10.0, 200)
    assert max(crossed) == 0 and left < 1e-12


@pytest.mark.nightly
def test_a_rope_that_cannot_turn_on_stays_where_it_is(sheet, cloth):
    """Pins that go on where cloth has no way to give, until no distance is left and it passes through, break this."""
    crossed, left = twist(sheet, cloth, (0.04, 0.2), 10.0, 200)
    assert max(crossed) == 0 and left > 1e-3


@pytest.mark.nightly
def test_a_stack_of_five_sheets_on_a_ball_crosses_nowhere(sheet, grid_of, cloth):
    """Layers that are pushed through each other where several lie on top of each other break this."""
    flat, faces = sheet(15, 15, 0.3, 0.3)
    count = len(flat)
    topology = Topology.from_mesh(
        np.concatenate([faces + k * count for k in range(5)]), np.tile(flat[faces], (5, 1, 1))
    )
    nodes = np.concatenate([
        np.column_stack([flat[:, 0] - 0.15 + 3e-3 * k, np.full(count, 0.103 + 4e-3 * k), 0.15 - 2e-3 * k - flat[:, 1]])
        for k in range(5)
    ])  # fmt: skip
    ball = grid_of(lambda p: np.linalg.norm(p, axis=-1) - 0.1)
    scene = Scene(topology, cloth, ball, self_contact=SelfContact.of(topology))
    state = ClothState(nodes, np.zeros_like(nodes), nodes)
    for _ in range(20):
        state = continue_time_steps(scene, state, steps=1)
        assert len(self_intersections(state.nodes, topology.faces)) == 0
    rest = equilibrium(scene, state.nodes, anchors=state.anchors)
    assert rest.converged and len(self_intersections(rest.nodes, topology.faces)) == 0


def test_momentum_is_kept_where_nothing_acts_from_outside(sheet, cloth):
    """A contact force or friction without its opposite on the other sheet breaks this."""
    flat, faces = sheet(6, 6, 0.08, 0.08)
    count = len(flat)
    topology = Topology.from_mesh(np.concatenate([faces, faces + count]), np.tile(flat[faces], (2, 1, 1)))
    nodes = np.concatenate([np.column_stack([flat[:, 0], np.full(count, h), -flat[:, 1]]) for h in (0.0, 3e-3)])
    nodes[count:] += [0.005, 0.0, 0.003]
    velocities = np.zeros_like(nodes)
    velocities[count:] = [0.1, -0.3, 0.0]
    scene = Scene(topology, cloth, gravity=(0.0, 0.0, 0.0), self_contact=SelfContact.of(topology))
    settings = SolveSettings(damping=1.0, newton_per_step=40, rest_motion=1e-12)
    state = continue_time_steps(scene, ClothState(nodes, velocities, nodes), steps=6, dt=0.01, settings=settings)
    before, after = (scene.masses @ v for v in (velocities, state.velocities))
    assert np.abs(after - before).max() < 1e-3 * np.abs(before).max()
    shares = [scene.masses[:count] @ state.velocities[:count], scene.masses[count:] @ state.velocities[count:]]
    assert shares[0][1] < 0.1 * before[1]  # the lower sheet was pushed down


def test_derivative_at_rest_goes_through_contact(sheet, cloth):
    """A pair without its place in the exact Hessian, or one that it has and the energy has not, breaks this."""
    wide, under = sheet(9, 9, 0.12, 0.12)
    small, over = sheet(6, 6, 0.06, 0.06)
    nodes = np.concatenate([
        np.column_stack([wide[:, 0], np.zeros(len(wide)), -wide[:, 1]]),
        np.column_stack([small[:, 0] + 0.021, np.full(len(small), 1.85e-3), -small[:, 1] - 0.033]),
    ])  # fmt: skip
    topology = Topology.from_mesh(np.concatenate([under, over + len(wide)]), np.concatenate([wide[under], small[over]]))
    border = np.flatnonzero(np.abs(wide - 0.06).max(1) > 0.0599)
    scene = Scene(topology, cloth, pins=Pins(border, nodes[border]), self_contact=SelfContact.of(topology))
    state = take_time_steps(scene, nodes, steps=10, dt=0.05)
    rest = equilibrium(scene, state.nodes, anchors=state.anchors)
    assert rest.converged and rest.rubbing is not None
    way = ImplicitDerivative(tolerance=0.0)
    response = way.solve(scene, rest.nodes, rubbing=rest.rubbing)
    found = response.push(fabric_rates=np.eye(6)[:, [FABRIC_PARAMETERS.index("density")]])[..., 0]
    step = 1e-4 * cloth.density
    ends = [
        way.solve(
            replace(scene, fabric=replace(cloth, density=cloth.density + s)), response.nodes, rubbing=rest.rubbing
        )
        for s in (step, -step)
    ]
    measured = (ends[0].nodes - ends[1].nodes) / (2.0 * step)
    assert np.abs(measured[len(wide) :]).max() > 1e-3
    assert np.abs(found - measured).max() < 1e-3 * np.abs(measured).max()


def test_a_thinner_law_lets_sheets_lie_closer(sheet, cloth):
    """A thickness that is not taken from the settings breaks this."""
    flat, faces = sheet(6, 6, 0.06, 0.06)
    topology = Topology.from_mesh(faces, flat[faces])
    reaches = [SelfContact.of(topology, SelfContactSettings(thickness=t)).reach.max() for t in (1e-3, 2e-3, 1.0)]
    assert reaches[0] == 1e-3 and reaches[1] == 2e-3 and reaches[2] < 6e-3
