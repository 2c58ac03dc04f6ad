"""Length, even points and closest points of closed curves and open polylines."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.geometry.curves import Curve, polyline_length, resample_polyline
from hypothesis import given, settings
from hypothesis import strategies as st

SQUARE = np.array([[0.0, 0.0, 0.0], [0.3, 0.0, 0.0], [0.3, 0.1, 0.0], [0.0, 0.1, 0.0]])


def circle(radius: float, count: int) -> Curve:
    """Return a regular polygon in the plane."""
    angle = 2.0 * np.pi * np.arange(count) / count
    return Curve(radius * np.stack([np.cos(angle), np.sin(angle)], axis=1))


def test_length_and_distance_are_those_of_a_circle() -> None:
    """Breaks if the last side is lost: the length is 2 n r sin(pi / n), a point's distance |rho - r|."""
    curve = circle(0.2, 4000)
    assert curve.length == pytest.approx(2 * 4000 * 0.2 * np.sin(np.pi / 4000), rel=1e-12)
    points = np.random.default_rng(0).normal(size=(300, 2))
    rho = np.linalg.norm(points, axis=1)
    np.testing.assert_allclose(curve.distance(points), np.abs(rho - 0.2), atol=1e-7)
    np.testing.assert_allclose(curve.closest(points).foot, 0.2 * points / rho[:, None], atol=1e-3)


@pytest.mark.parametrize("count", [1, 7, 800])
def test_points_are_even_from_the_first_corner(count: int) -> None:
    """Breaks if spacing follows corners, the start moves, or the first point comes again at the end."""
    points = Curve(SQUARE).resample(count)
    np.testing.assert_array_equal(points[0], SQUARE[0])
    at = Curve(SQUARE).locate(np.arange(count) * 0.8 / count)
    np.testing.assert_allclose(at.foot, points, atol=1e-15)
    if count == 800:
        gap = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
        np.testing.assert_allclose(gap, 1e-3, rtol=1e-12)


def test_shares_of_the_length_go_round_and_round() -> None:
    """Breaks if a share below 0 or above 1 is clipped instead of wrapped, or a table of shares loses its shape."""
    curve = Curve(SQUARE)
    np.testing.assert_allclose(curve.at_shares(np.array([0.375, 1.375, -0.625])), np.tile(SQUARE[1], (3, 1)))
    assert curve.at_shares(np.zeros((4, 5))).shape == (4, 5, 3)


def test_closest_points_are_on_the_nearest_side() -> None:
    """Breaks if the side from the last corner to the first is left out, or the parameter runs backwards."""
    found = Curve(SQUARE).closest(np.array([[-0.05, 0.025, 0.2], [0.5, -0.5, 0.0]]))
    np.testing.assert_array_equal(found.segment, [3, 0])
    np.testing.assert_allclose(found.along, [0.75, 1.0])
    np.testing.assert_allclose(found.foot, [[0.0, 0.025, 0.0], [0.3, 0.0, 0.0]])
    np.testing.assert_allclose(Curve(SQUARE).tangents[found.segment[0]], [0.0, -1.0, 0.0])


@given(st.integers(0, 1000), st.integers(2, 3), st.integers(3, 20))
@settings(max_examples=40, deadline=None)
def test_no_point_of_the_curve_is_nearer_than_the_closest(seed: int, dimension: int, count: int) -> None:
    """Breaks if a segment is passed over, also one without length, in the plane or in space."""
    rng = np.random.default_rng(seed)
    corners = rng.normal(size=(count, dimension))
    corners[-1] = corners[0]
    curve, points = Curve(corners), rng.normal(size=(20, dimension))
    samples = curve.resample(500)
    nearest = np.linalg.norm(points[:, None] - samples[None], axis=2).min(axis=1)
    distance = curve.distance(points)
    assert (nearest >= distance - 1e-9).all()
    assert (nearest <= distance + curve.length / 500).all()


def test_an_open_line_keeps_both_ends() -> None:
    """Breaks if a polyline is closed by mistake: an L of 3 and 4 is 7 long and its middle is at 3.5."""
    line = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 4.0]])
    assert polyline_length(line) == 7.0
    np.testing.assert_allclose(resample_polyline(line, 3), [[0.0, 0.0], [3.0, 0.5], [3.0, 4.0]])


def test_an_open_curve_has_no_segment_from_its_last_corner_to_its_first() -> None:
    """Breaks if an open curve is closed by mistake: an L of 3 and 4 whose third side, 5 long, is missing."""
    curve = Curve(np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 4.0]]), is_closed=False)
    assert curve.length == 7.0
    np.testing.assert_allclose(curve.resample(3), [[0.0, 0.0], [3.0, 0.5], [3.0, 4.0]])
    np.testing.assert_allclose(curve.at_shares(np.array([0.0, 3.0 / 7.0, 1.0])), curve.points)
    np.testing.assert_allclose(curve.corner_lengths, [1.5, 3.5, 2.0])
    np.testing.assert_allclose(curve.locate(np.array([0.0, 5.0, 7.0])).foot, [[0.0, 0.0], [3.0, 2.0], [3.0, 4.0]])
    found = curve.closest(np.array([[1.0, 2.0]]))
    np.testing.assert_allclose(found.foot, [[1.0, 0.0]])  # the missing side is 0.4 away, this one 2
    np.testing.assert_array_equal(found.segment, [0])
