"""The control map is linear and reproduces what it should; nodes carry over between meshes."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.garment.control import map_controls, mean_value_coordinates
from garmentq.core.garment.curves import edge_points
from garmentq.core.garment.garmentcode import read_pattern
from garmentq.core.garment.pattern import Edge, EdgeRef, Panel, Pattern
from garmentq.core.garment.resampling import resample
from garmentq.core.garment.sewing import mesh_pattern
from hypothesis import given, settings
from hypothesis import strategies as st


def test_identity_and_similarity(tee_file):
    """Breaks where weights do not sum to one or R90 has the wrong sign."""
    garment = mesh_pattern(read_pattern(tee_file), edge_length=0.04)
    controls = map_controls(garment)
    points = garment.pattern.points
    assert controls.apply(points) == pytest.approx(garment.uv, abs=1e-12)
    turn = 1.3 * np.array([[0.8, -0.6], [0.6, 0.8]])
    assert controls.apply(points @ turn.T + [0.2, -0.1]) == pytest.approx(garment.uv @ turn.T + [0.2, -0.1], abs=1e-12)


def test_affine_maps_of_straight_panels():
    """Breaks where mean value coordinates lose linear precision, on a concave panel too."""
    points = np.array([[0.0, 0.0], [0.4, 0.0], [0.4, 0.3], [0.2, 0.1], [0.0, 0.3]])
    garment = mesh_pattern(Pattern("p", (Panel("p", points, (Edge(),) * 5),), ()), edge_length=0.03)
    affine = np.array([[1.2, 0.5], [-0.1, 0.7]])
    moved = map_controls(garment).apply(points @ affine.T + [1, 2])
    assert moved == pytest.approx(garment.uv @ affine.T + [1, 2], abs=1e-12)


def test_boundary_follows_its_curve(tee_file):
    """Breaks where boundary vertices leave the curve when its control points move (thesis eq. 3.1)."""
    garment = mesh_pattern(read_pattern(tee_file), edge_length=0.04)
    shift = np.random.default_rng(1).normal(scale=0.02, size=garment.pattern.points.shape)
    moved = garment.pattern.with_points(garment.pattern.points + shift)
    uv = map_controls(garment).apply(moved.points)
    for ref, along in garment.edge_uv.items():
        assert uv[along] == pytest.approx(edge_points(moved.panel(ref.panel), ref.edge, len(along) - 1), abs=1e-12)


def test_pull_back_is_the_transpose(tee_file):
    """Breaks where the derivative's stacking differs from the map's."""
    garment = mesh_pattern(read_pattern(tee_file), edge_length=0.06)
    controls = map_controls(garment)
    rng = np.random.default_rng(2)
    gradient, step = rng.normal(size=garment.uv.shape), rng.normal(size=garment.pattern.points.shape)
    assert np.sum(gradient * controls.apply(step)) == pytest.approx(np.sum(controls.pull_back(gradient) * step))


@settings(max_examples=40, deadline=None)
@given(st.floats(0.05, 0.95), st.floats(0.05, 0.95))
def test_mean_value_coordinates_reproduce_points(x, y):
    """Breaks where a half-angle tangent has the wrong sign outside the kernel of a concave polygon."""
    polygon = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.5, 0.02], [0.0, 1.0]])
    # Shrink towards the two arms so that every point lies inside.
    point = np.array([[x * 0.3, y * 0.3]]) if x < 0.5 else np.array([[1 - (1 - x) * 0.3, y * 0.3]])
    weight = mean_value_coordinates(polygon, point)
    assert weight.sum() == pytest.approx(1.0)
    assert weight @ polygon == pytest.approx(point, abs=1e-10)


def _bend(garment):
    """Roll a single flat panel around a cylinder."""
    uv = np.zeros((len(garment.nodes), 2))
    uv[garment.uv_node] = garment.uv
    return np.column_stack([0.2 * np.sin(uv[:, 0] / 0.2), uv[:, 1], 0.2 * np.cos(uv[:, 0] / 0.2)])


def test_resample_keeps_the_surface():
    """Breaks where a finer mesh is looked up in the wrong triangle: a cylinder must stay one within its sagitta."""
    points = np.array([[0.0, 0.0], [0.4, 0.0], [0.45, 0.3], [0.0, 0.3]])
    panel = Panel("p", points, (Edge(), Edge("quadratic", np.array([[0.5, 0.2]])), Edge(), Edge()))
    pattern = Pattern("p", (panel,), ())
    coarse, fine = mesh_pattern(pattern, edge_length=0.02), mesh_pattern(pattern, edge_length=0.011)
    found = resample(coarse, _bend(coarse), fine)
    # The sagitta of the longest edges (3 cm) on a radius of 20 cm is 0.6 mm; that of the usual 2 cm is 0.25 mm.
    distance = np.linalg.norm(found - _bend(fine), axis=1)
    assert distance.max() < 8e-4 and np.median(distance) < 2e-4


def test_resample_to_itself_and_to_a_moved_pattern(tee_file):
    """Breaks where seams are torn, or where a longer pattern is looked up at the old place."""
    pattern = read_pattern(tee_file)
    garment = mesh_pattern(pattern, edge_length=0.04)
    assert resample(garment, garment.nodes, garment) == pytest.approx(garment.nodes, abs=1e-9)
    scaled = mesh_pattern(pattern.with_points(1.25 * pattern.points), edge_length=0.05)
    found = resample(garment, garment.nodes, scaled)
    for ref, along in scaled.edge_uv.items():
        ends = garment.nodes[garment.uv_node[garment.edge_uv[ref][[0, -1]]]]
        assert found[scaled.uv_node[along[[0, -1]]]] == pytest.approx(ends, abs=1e-9)
    hem = found[scaled.uv_node[scaled.edge_uv[EdgeRef("front", 0)]]]
    assert hem[:, 1] == pytest.approx(0.8, abs=1e-9)
