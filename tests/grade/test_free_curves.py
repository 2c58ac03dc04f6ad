"""Free curves: a drape of the library's T-shirt tells how its armholes are cut to a base pattern with other ones."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.body.body import Body
from garmentq.core.body.builtin import builtin_body
from garmentq.core.garment.control import update_flat_mesh
from garmentq.core.garment.curves import edge_points
from garmentq.core.garment.garment import Garment
from garmentq.core.garment.handles import handles_of, list_curves, with_handles
from garmentq.core.garment.pattern import EdgeRef, Pattern
from garmentq.core.garment.seams import equalise_seams, seam_lengths, seam_mismatch
from garmentq.core.garment.templates import load_draped_template, load_template
from garmentq.core.recover.grade import pattern_parameters
from garmentq.core.recover.grade.pattern_parameters import PatternParameters
from garmentq.core.recover.grade.proportion import find_proportions
from garmentq.core.recover.grade.sliding import SlideSettings, slide_seams
from garmentq.core.scan.contours.target import Target


@pytest.fixture(scope="module")
def worn() -> Garment:
    """Return the T-shirt as it hangs on the built-in body."""
    found = load_draped_template("tshirt")
    assert found is not None
    return found


@pytest.fixture(scope="module")
def body() -> Body:
    """Return its wearer."""
    return builtin_body("builtin:female")


def armhole_edges(pattern: Pattern) -> list[EdgeRef]:
    """Return the curves that join a sleeve to front or back, on both sides of the seam."""
    sleeve = {panel.name for panel in pattern.panels if panel.name.startswith("sleeve")}
    return [
        ref
        for seam in pattern.seams
        for ref in (seam.a, seam.b)
        if (seam.a.panel in sleeve) != (seam.b.panel in sleeve)
    ]


def cut_otherwise(pattern: Pattern) -> Pattern:
    """Return the pattern with armholes and caps a third as far from their chords."""
    handles = handles_of(pattern).copy()
    for ref, edge, own in list_curves(pattern):
        if ref in armhole_edges(pattern):
            handles[own] = edge.handles * [1.0, 1.0 / 3.0]
    return equalise_seams(with_handles(pattern, handles))


def depth(pattern: Pattern) -> float:
    """Return how far the curves of armholes and caps lie from their chords, root mean square [m]."""
    found = []
    for ref in armhole_edges(pattern):
        points = edge_points(pattern.panel(ref.panel), ref.edge, 40)
        along = (points[-1] - points[0]) / np.linalg.norm(points[-1] - points[0])
        found.append((points - points[0]) @ [-along[1], along[0]])
    return float(np.sqrt(np.mean(np.square(found))))


def test_the_cloth_tells_how_an_armhole_is_cut(worn, body, monkeypatch):
    """Broken where handles are not fitted, or by the wrong rates: a third of the depth stays then."""
    monkeypatch.setattr(pattern_parameters, "CURVE_HANDLE_STD", 1.0)  # the base pattern is known to be another maker's
    target = Target(worn.nodes, worn.faces, np.zeros_like(worn.nodes), worn.contours, (), "tshirt")
    other = cut_otherwise(worn.pattern)
    start = update_flat_mesh(worn, other)
    true, flat = depth(worn.pattern), depth(other)
    assert flat < 0.5 * true
    kept, freed = (
        slide_seams(start, target, body, other, settings=settings).pattern
        for settings in (SlideSettings(), SlideSettings().by_newton(curves=True))
    )
    assert depth(kept) < 0.4 * true
    assert depth(freed) > 0.55 * true
    assert seam_mismatch(freed) < 1e-5


def test_rates_are_those_of_the_drawing():
    """Broken where a rule or a seam forgets that curves change lengths, areas and corners."""
    base = load_template("tshirt")
    free, proportions = PatternParameters.of(base, curves=True), find_proportions(base)
    change = 1e-4 * np.random.default_rng(0).normal(size=free.points.shape[1] + free.handles.shape[1])
    forwards, backwards = free.move(base, change), free.move(base, -change)

    def gaps(pattern: Pattern) -> np.ndarray:
        lengths = seam_lengths(pattern)
        return (lengths[:, 0] - lengths[:, 1])[~pattern.gathered]

    np.testing.assert_allclose(free.seam_rows(base) @ change, (gaps(forwards) - gaps(backwards)) / 2.0, atol=1e-9)
    missing, rates = free.shape_rules(base)
    ends = [free.shape_rules(one)[0] for one in (forwards, backwards)]
    np.testing.assert_allclose(missing, 0.0, atol=1e-9)
    np.testing.assert_allclose(rates @ change, (ends[1] - ends[0]) / 2.0, atol=1e-6)
    missing, by_points = proportions.linearise(base)
    found = free.combine(by_points, proportions.curve_rates(base)) @ change
    ends = [proportions.linearise(one)[0] for one in (forwards, backwards)]
    np.testing.assert_allclose(found, (ends[1] - ends[0]) / 2.0, atol=1e-4)
    again = free.move(base, free.difference(forwards, base))
    np.testing.assert_allclose(again.points, forwards.points, atol=1e-9)
    np.testing.assert_allclose(handles_of(again), handles_of(forwards), atol=1e-9)


def test_side_seams_keep_their_curves():
    """Broken where a side seam bends with the strain that a missing dart leaves."""
    skirt, shirt = load_template("pencil_skirt"), load_template("tshirt")
    sides = {
        ref for seam in skirt.seams for ref in (seam.a, seam.b) if {seam.a.panel, seam.b.panel} == {"front", "back"}
    }
    curved = {ref for ref, _, _ in list_curves(skirt)}
    assert sides & curved and not sides & moved_curves(skirt)
    assert set(armhole_edges(shirt)) <= moved_curves(shirt)


def moved_curves(base: Pattern) -> set[EdgeRef]:
    """Return the curves that change where every parameter does."""
    free = PatternParameters.of(base, curves=True)
    moved = free.move(base, np.full(free.points.shape[1] + free.handles.shape[1], 0.01))
    return {ref for ref, _, _ in list_curves(base) if not np.allclose(*_both(ref, base, moved), atol=1e-9)}


def _both(ref: EdgeRef, *patterns: Pattern) -> list[np.ndarray]:
    return [pattern.panel(ref.panel).edges[ref.edge].handles for pattern in patterns]


def test_curves_stay_where_they_are_not_free():
    """Broken where a maker's own curves are redrawn."""
    base = load_template("tshirt")
    free = PatternParameters.of(base, curves=False)
    moved = free.move(base, np.full(free.points.shape[1], 0.01))
    assert not free.has_curves
    np.testing.assert_array_equal(handles_of(moved), handles_of(base))
