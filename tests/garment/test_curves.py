"""Edges: lengths and points against formulas, parts against the whole."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.garment.curves import (
    edge_length,
    edge_points,
    mirror_edge,
    place_on_chord,
    relative_to_chord,
    reverse_edge,
    split_edge,
)
from garmentq.core.garment.pattern import Edge, Panel
from hypothesis import given, settings
from hypothesis import strategies as st

SQUARE = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]])

KINDS = [
    Edge("line"),
    Edge("quadratic", np.array([[0.3, 0.4]])),
    Edge("cubic", np.array([[0.1, 0.5], [0.9, -0.3]])),
    Edge("arc", np.array([[0.5, 0.2]])),
    Edge("arc", np.array([[0.5, -0.9]])),
]


def _panel(edge: Edge) -> Panel:
    return Panel("p", SQUARE, (edge, Edge(), Edge(), Edge()))


@pytest.mark.parametrize("height", [0.5, -0.5, 0.1, 2.0])
def test_arc_length_is_radius_times_angle(height):
    """Breaks where an arc is approximated, or takes the short way round for the long one."""
    radius = (0.25 + height**2) / (2 * abs(height))
    small = 2 * np.arcsin(min(0.5 / radius, 1.0))
    angle = small if abs(height) <= 0.5 else 2 * np.pi - small
    panel = _panel(Edge("arc", np.array([[0.5, height]])))
    assert edge_length(panel, 0) == pytest.approx(2.0 * radius * angle, rel=1e-12)
    points = edge_points(panel, 0, 8)
    assert points[4] == pytest.approx([1.0, 2.0 * height], abs=1e-12)


def test_quadratic_length_matches_parabola():
    """Breaks where the length integral is off: y = x^2 on [-1, 1] has length sqrt(5) + asinh(2)/2."""
    panel = Panel(
        "p",
        np.array([[-1.0, 1.0], [1.0, 1.0], [0.0, 3.0]]),
        (Edge("quadratic", np.array([[0.5, -1.0]])), Edge(), Edge()),
    )
    assert edge_length(panel, 0) == pytest.approx(np.sqrt(5.0) + np.arcsinh(2.0) / 2.0, rel=1e-10)
    points = edge_points(panel, 0, 10)
    assert points[:, 1] == pytest.approx(points[:, 0] ** 2, abs=1e-12)


@pytest.mark.parametrize("edge", KINDS)
def test_points_are_uniform_and_meet_the_ends(edge):
    """Breaks where samples are uniform in the parameter and not in arc length."""
    panel = _panel(edge)
    fine = edge_points(panel, 0, 4000)
    assert np.array_equal(fine[0], SQUARE[0]) and np.array_equal(fine[-1], SQUARE[1])
    steps = np.linalg.norm(np.diff(fine, axis=0), axis=1)
    assert steps.max() / steps.min() < 1.001
    assert steps.sum() == pytest.approx(edge_length(panel, 0), rel=1e-6)


@pytest.mark.parametrize("edge", KINDS)
@pytest.mark.parametrize("fraction", [0.2, 0.5, 0.85])
def test_split_parts_draw_the_whole(edge, fraction):
    """Breaks where a part bends to the wrong side or its handles stay in the old chord."""
    whole = _panel(edge)
    cut, first, second = split_edge(edge, fraction)
    middle = place_on_chord(cut[None], SQUARE[0], SQUARE[1])
    points = np.concatenate([SQUARE[:1], middle, SQUARE[1:]])
    parts = Panel("p", points, (first, second, Edge(), Edge(), Edge()))
    lengths = edge_length(parts, 0), edge_length(parts, 1)
    assert lengths[0] == pytest.approx(fraction * edge_length(whole, 0), rel=1e-9)
    assert sum(lengths) == pytest.approx(edge_length(whole, 0), rel=1e-9)
    assert edge_points(parts, 0, 10)[5] == pytest.approx(edge_points(whole, 0, 40 * 50)[int(1000 * fraction)], abs=1e-8)


@pytest.mark.parametrize("edge", KINDS)
def test_reversed_and_mirrored_edges(edge):
    """Breaks where reversing forgets to swap sides or mirroring forgets to keep the direction."""
    forward = edge_points(_panel(edge), 0, 12)
    back = Panel("p", SQUARE[[1, 0, 3, 2]], (reverse_edge(edge), Edge(), Edge(), Edge()))
    assert edge_points(back, 0, 12)[::-1] == pytest.approx(forward, abs=1e-9)
    image = Panel("p", SQUARE * [-1, 1], (mirror_edge(edge), Edge(), Edge(), Edge()))
    assert edge_points(image, 0, 12) * [-1, 1] == pytest.approx(forward, abs=1e-9)


@settings(max_examples=30, deadline=None)
@given(st.floats(-3, 3), st.floats(0.1, 5), st.floats(-2, 2), st.floats(-2, 2), st.integers(0, len(KINDS) - 1))
def test_a_curve_follows_its_chord_by_a_similarity(angle, scale, x, y, kind):
    """Breaks where handles are absolute: turning, scaling and moving both ends must do the same to the curve."""
    turn = scale * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    panel = _panel(KINDS[kind])
    moved = Panel("p", SQUARE @ turn.T + [x, y], panel.edges)
    assert edge_points(moved, 0, 7) == pytest.approx(edge_points(panel, 0, 7) @ turn.T + [x, y], abs=1e-9)
    relative = relative_to_chord(edge_points(moved, 0, 7), moved.points[0], moved.points[1])
    assert relative == pytest.approx(relative_to_chord(edge_points(panel, 0, 7), SQUARE[0], SQUARE[1]), abs=1e-9)
