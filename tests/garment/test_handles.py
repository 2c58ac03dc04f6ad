"""Handles of curves: what follows them, checked by finite differences of the drawing itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.garment.control import update_flat_mesh
from garmentq.core.garment.curves import edge_length, panel_area
from garmentq.core.garment.fairness import find_smooth_joins, measure_corner
from garmentq.core.garment.handles import (
    area_rates,
    corner_rates,
    find_free_handles,
    follow_handles,
    handles_of,
    length_rates,
    list_curves,
    with_handles,
)
from garmentq.core.garment.pattern import EdgeRef, Pattern
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.garment.symmetry import find_symmetry
from garmentq.core.garment.templates import load_template

NAMES = ("tshirt", "trousers", "sleeved_dress+neckline=v")
SMALL = 1e-4


@pytest.fixture(params=NAMES)
def pattern(request) -> Pattern:
    """Return one of three cuts of the library."""
    return load_template(request.param)


@pytest.fixture
def motion(pattern) -> np.ndarray:
    """Return a motion of all handles in chords, the same each time."""
    return np.random.default_rng(0).normal(size=handles_of(pattern).shape)


def both_ways(pattern: Pattern, motion: np.ndarray) -> tuple[Pattern, Pattern]:
    """Return the pattern with its handles moved a little forwards and backwards."""
    handles = handles_of(pattern)
    return with_handles(pattern, handles + SMALL * motion), with_handles(pattern, handles - SMALL * motion)


def test_handles_come_back_as_they_were_set(pattern, motion):
    """Broken where two curves are taken for each other, or a line or an arc is given handles."""
    moved = with_handles(pattern, handles_of(pattern) + motion)
    np.testing.assert_array_equal(handles_of(moved), handles_of(pattern) + motion)
    for panel, other in zip(pattern.panels, moved.panels, strict=True):
        np.testing.assert_array_equal(panel.points, other.points)
        for edge, drawn in zip(panel.edges, other.edges, strict=True):
            assert edge.kind in ("quadratic", "cubic") or np.array_equal(edge.handles, drawn.handles)


def test_a_mesh_follows_its_handles(pattern, motion):
    """Broken where a rate is of another vertex, or inner vertices do not follow the outline."""
    garment = mesh_pattern(pattern, 400)
    forwards, backwards = (update_flat_mesh(garment, one).uv for one in both_ways(pattern, motion))
    rates = follow_handles(garment) @ motion.ravel()
    np.testing.assert_allclose(rates, (forwards - backwards) / (2.0 * SMALL), atol=1e-5)
    assert np.abs(rates).max() > 0.01


def test_lengths_and_areas_follow_handles(pattern, motion):
    """Broken where a chord's length or its square is forgotten, or an area's sign is turned."""
    forwards, backwards = both_ways(pattern, motion)
    for ref, _, _ in list_curves(pattern):
        ends = [edge_length(one.panel(ref.panel), ref.edge) for one in (forwards, backwards)]
        rate = float(length_rates(pattern, {ref: 1.0}) @ motion.ravel())
        assert rate == pytest.approx((ends[0] - ends[1]) / (2.0 * SMALL), abs=1e-5)
    for panel in pattern.panels:
        ends = [panel_area(one.panel(panel.name)) for one in (forwards, backwards)]
        edges = dict.fromkeys((EdgeRef(panel.name, index) for index in range(len(panel.edges))), 1.0)
        rate = float(area_rates(pattern, edges) @ motion.ravel())
        assert rate == pytest.approx((ends[0] - ends[1]) / (2.0 * SMALL), abs=1e-5)


def test_corners_follow_points_and_handles(pattern, motion):
    """Broken where the edge that arrives is taken for the one that departs, or the wrong end's handle turns."""
    points = np.random.default_rng(1).normal(size=pattern.points.shape)
    forwards, backwards = (
        one.with_points(one.points + sign * SMALL * points)
        for one, sign in zip(both_ways(pattern, motion), (1.0, -1.0), strict=True)
    )
    joins = find_smooth_joins(pattern)
    assert joins
    for join in joins:
        by_points, by_handles = corner_rates(pattern, join)
        rate = float(np.sum(by_points * points) + np.sum(by_handles * motion))
        turned = measure_corner(forwards, join) - measure_corner(backwards, join)
        assert rate == pytest.approx(turned / (2.0 * SMALL), rel=1e-3, abs=1e-3)


def test_free_handles_keep_mirror_images_and_what_is_held(pattern):
    """Broken where left and right come apart, or a held curve bends."""
    curves = [ref for ref, _, _ in list_curves(pattern)]
    held = {curves[0]}
    free = find_free_handles(pattern, held)
    change = free @ np.random.default_rng(2).normal(size=free.shape[1])
    moved = with_handles(pattern, handles_of(pattern) + 0.05 * change.reshape(-1, 2))
    assert len(find_symmetry(moved).mirrors) == len(find_symmetry(pattern).mirrors) > 0
    assert 0 < free.shape[1] < len(free)
    edges = [one.panel(curves[0].panel).edges[curves[0].edge].handles for one in (pattern, moved)]
    np.testing.assert_allclose(edges[0], edges[1], atol=1e-12)


def test_a_pattern_of_lines_has_no_handles():
    """Broken where an empty list cannot be stacked."""
    pattern = load_template("tshirt")
    straight = replace(
        pattern,
        panels=tuple(
            replace(panel, edges=tuple(replace(edge, kind="line", handles=np.zeros((0, 2))) for edge in panel.edges))
            for panel in pattern.panels
        ),
    )
    assert handles_of(straight).shape == (0, 2) and find_free_handles(straight).shape == (0, 0)
    assert follow_handles(mesh_pattern(straight, 200)).shape[1:] == (2, 0)
    assert length_rates(straight, {EdgeRef("front", 0): 1.0}).shape == (0,)
