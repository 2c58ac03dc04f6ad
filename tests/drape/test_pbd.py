"""Position-based steps: what they must conserve, reach and keep out of."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.garment.garment import Garment
from garmentq.core.garment.pattern import Edge, Panel, Pattern
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.recover.drape.pbd import PbdSettings, PbdState, build_distance_constraints, simulate_pbd


def sheet(width: float = 0.3, height: float = 0.3, edge: float = 0.03) -> Garment:
    """Mesh one rectangular panel, unsewn."""
    points = np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])
    return mesh_pattern(Pattern("sheet", (Panel("sheet", points, (Edge(),) * 4),), ()), edge_length=edge)


class Sphere:
    """A sphere of 10 cm about (0.15, -0.12, 0.15)."""

    def measure(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return distances [m] and gradients."""
        offset = points - np.array([0.15, -0.12, 0.15])
        length = np.linalg.norm(offset, axis=1)
        return length - 0.1, offset / length[:, None]


def test_rest_lengths_are_those_of_the_flat_panel() -> None:
    """Breaks if threads take their lengths from the placed mesh, or if a hinge's pair is measured folded."""
    garment = sheet()
    threads = build_distance_constraints(garment)
    flat = np.zeros((len(garment.nodes), 3))
    flat[garment.uv_node, :2] = garment.uv
    found = np.linalg.norm(flat[threads.ends[:, 0]] - flat[threads.ends[:, 1]], axis=1)
    assert found == pytest.approx(threads.lengths, abs=1e-12)


def test_flat_sheet_without_weight_stays_where_it_is() -> None:
    """Breaks if the constraints create motion of their own."""
    garment = sheet()
    state = simulate_pbd(build_distance_constraints(garment), PbdState.at_rest(garment.nodes), None, 10)
    assert np.abs(state.nodes - garment.nodes).max() < 1e-9
    assert np.abs(state.velocities).max() < 1e-6


def test_stretched_sheet_returns_to_its_size() -> None:
    """Breaks if the sweeps do not converge on the edge lengths."""
    garment = sheet()
    threads = build_distance_constraints(garment)
    nodes = simulate_pbd(threads, PbdState.at_rest(garment.nodes * 1.3), None, 60).nodes
    edges = threads.stiffness == 1.0
    found = np.linalg.norm(nodes[threads.ends[edges, 0]] - nodes[threads.ends[edges, 1]], axis=1)
    assert np.abs(found / threads.lengths[edges] - 1.0).max() < 0.01


def test_sheet_falls_on_a_sphere_and_stays_outside() -> None:
    """Breaks if contact is lost between steps, or if friction pulls cloth through the surface."""
    garment = sheet()
    nodes = garment.nodes[:, [0, 2, 1]] * np.array([1.0, 1.0, 1.0])
    settings = PbdSettings()
    start = PbdState.at_rest(nodes)
    nodes = simulate_pbd(
        build_distance_constraints(garment), start, Sphere(), 120, settings=settings, gravity=9.81
    ).nodes
    distance, _ = Sphere().measure(nodes)
    assert distance.min() > settings.thickness - 1e-3
    assert nodes[:, 1].min() < -0.1, "the rim hangs down"


def test_held_nodes_do_not_move() -> None:
    """Breaks if a held node takes part in a projection."""
    garment = sheet()
    held = np.array([0, 3, 5])
    start = PbdState.at_rest(garment.nodes)
    nodes = simulate_pbd(build_distance_constraints(garment), start, None, 20, gravity=9.81, pins=held).nodes
    assert np.array_equal(nodes[held], garment.nodes[held])
    assert nodes[:, 1].min() < garment.nodes[:, 1].min() - 0.05


def test_same_input_gives_the_same_bits() -> None:
    """Breaks if anything in the steps depends on memory or order of execution."""
    garment = sheet()
    start = PbdState.at_rest(garment.nodes * 1.1)
    runs = [
        simulate_pbd(build_distance_constraints(garment), start, Sphere(), 15, gravity=9.81).nodes for _ in range(2)
    ]
    assert np.array_equal(runs[0], runs[1])
