"""Metrics of the flat pattern against drawings whose answer is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from garmentq.cli.bench.pattern_match import (
    is_same_cut,
    measure_panels,
    measure_pattern,
    polygon_width,
    unmatched_panels,
)
from garmentq.cli.bench.truth import measure_fabric
from garmentq.core.cloth.fabric import Fabric
from garmentq.core.garment.pattern import Edge, EdgeRef, Panel, Pattern, Seam
from garmentq.core.judge.matching import match_panels
from garmentq.core.judge.outlines import fit_outline
from garmentq.core.judge.patterns import measure_seams
from garmentq.core.judge.true_pattern import TruePanel, TruePattern, TrueSeam
from garmentq.core.judge.turning_distance import turning_distance

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
TRAPEZOID = np.array([[0.0, 0.0], [0.5, 0.0], [0.4, 0.6], [0.1, 0.5]])


def turned(points: np.ndarray, angle: float) -> np.ndarray:
    """Turn flat points."""
    c, s = np.cos(angle), np.sin(angle)
    return points @ np.array([[c, s], [-s, c]])


def piece(name: str, points: np.ndarray) -> Panel:
    """Return a panel of straight edges."""
    return Panel(name, points, tuple(Edge() for _ in points))


def as_truth(panel: Panel) -> TruePanel:
    """Return the same panel as an author would draw it, densely, as target packs do."""
    ends = np.roll(panel.points, -1, axis=0)
    share = np.linspace(0.0, 1.0, 9)[:, None]
    edges = tuple(a + share * (b - a) for a, b in zip(panel.points, ends, strict=True))
    return TruePanel(panel.name, np.concatenate([line[:-1] for line in edges]), edges)


def test_turning_ignores_motion_size_and_start_point() -> None:
    """Fails if start point, place, heading or scale mattered."""
    for angle, scale, start in ((0.7, 3.0, 1), (3.0, 0.2, 2), (-2.0, 1.0, 3)):
        other = np.roll(turned(TRAPEZOID, angle) * scale + [4.0, -1.0], start, axis=0)
        assert turning_distance(TRAPEZOID, other) == pytest.approx(0.0, abs=1e-6)


def test_turning_ignores_vertices_on_straight_sides() -> None:
    """Fails if a polygon with more vertices on the same outline were another shape."""
    dense = as_truth(piece("a", TRAPEZOID)).outline
    assert turning_distance(TRAPEZOID, dense) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("ratio", [1.1, 2.0, 5.0])
def test_turning_of_square_and_rectangle(ratio: float) -> None:
    """Fails if the rotation or start were not optimal: the closed form is pi/2 sqrt(2 d - 4 d^2), d = |p - 1/4|."""
    rectangle = SQUARE * [ratio, 1.0]
    shift = abs(ratio / (2.0 * (ratio + 1.0)) - 0.25)
    expected = np.pi / 2.0 * np.sqrt(2.0 * shift - 4.0 * shift**2)
    assert turning_distance(SQUARE, rectangle) == pytest.approx(expected, rel=1e-9)
    assert turning_distance(rectangle, SQUARE) == pytest.approx(expected, rel=1e-9)


def test_turning_is_the_least_over_all_starts_and_turns() -> None:
    """Fails if trying corner pairs missed the minimum: a fine search over start points finds nothing smaller."""
    generator = np.random.default_rng(5)
    for _ in range(3):
        angle = np.sort(generator.random((2, 7)), axis=1) * 2.0 * np.pi
        first, second = (
            np.stack([np.cos(a), 0.6 * np.sin(a)], axis=1) * (1 + 0.2 * np.cos(3 * a))[:, None] for a in angle
        )
        exact = turning_distance(first, second)
        assert exact == pytest.approx(_search(first, second), rel=0.02, abs=2e-3)
        assert turning_distance(second, first) == pytest.approx(exact, abs=1e-9)


def _search(first: np.ndarray, second: np.ndarray) -> float:
    """Minimise the turning distance by brute force: 2000 samples, every start point."""
    count = 2000
    functions = []
    for polygon in (first, second):
        side = np.roll(polygon, -1, axis=0) - polygon
        arc = np.cumsum(np.linalg.norm(side, axis=1))
        heading = np.unwrap(np.arctan2(side[:, 1], side[:, 0]))
        functions.append(heading[np.searchsorted(arc, (np.arange(count) + 0.5) / count * arc[-1])])
    twice = np.concatenate([functions[0], functions[0] + 2.0 * np.pi])
    return min(float(np.std(twice[t : t + count] - functions[1])) for t in range(count))


def test_the_same_pattern_has_no_error() -> None:
    """Fails if a panel that lies elsewhere, turned, counted as an error."""
    pattern = Pattern("p", (piece("a", turned(TRAPEZOID, 0.4) + 2.0), piece("b", SQUARE)), ())
    truth = TruePattern((as_truth(piece("b", SQUARE)), as_truth(piece("a", TRAPEZOID))))
    found = measure_pattern(pattern, truth)
    assert found["panel_area_error"] == pytest.approx(0.0, abs=1e-12)
    assert found["panel_outline_mm"] == pytest.approx(0.0, abs=1e-9)
    assert found["panel_turning"] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("is_turned_over", [False, True])
def test_a_clockwise_panel_is_mirrored_on_both_sides(is_turned_over: bool) -> None:
    """Fails if a back panel drawn from the inside met its own mirror image, or its edges in the wrong order."""
    clockwise = TRAPEZOID[::-1]
    drawn = as_truth(piece("back", clockwise))
    if is_turned_over:  # read as drawn, then run the other way round: edge i is the author's n - 1 - i
        ours = piece("back", np.roll(clockwise[::-1], 1, axis=0))
    else:
        ours = replace(piece("back", clockwise * [-1.0, 1.0]), mirrored=True)
    found = measure_pattern(Pattern("p", (ours,), ()), TruePattern((drawn,)))
    assert found["panel_outline_mm"] == pytest.approx(0.0, abs=1e-9)
    assert found["panel_turning"] == pytest.approx(0.0, abs=1e-6)
    wrong = measure_pattern(Pattern("p", (piece("back", clockwise * [-1.0, 1.0]),), ()), TruePattern((drawn,)))
    assert wrong["panel_outline_mm"] > 10.0


def test_errors_of_a_widened_panel() -> None:
    """Fails if area or outline were normalised otherwise: 10 % wider has 10 % more area and a known outline RMS."""
    truth = as_truth(piece("a", SQUARE))
    found = measure_pattern(Pattern("p", (piece("a", SQUARE * [1.1, 1.0]),), ()), TruePattern((truth,)))
    assert found["panel_area_error"] == pytest.approx(0.1, rel=1e-9)
    # Off by 0.1 (x - 1/2): the sides by 50 mm, bottom and top by 100 mm times a uniform spread.
    spread = np.linspace(-0.5, 0.5, 50)
    assert found["panel_outline_mm"] == pytest.approx(100.0 * np.sqrt(0.5 * (0.25 + np.mean(spread**2))), rel=1e-6)


def edge_rms_of_longer_band() -> float:
    """Return the RMS of a band of 0.8 m by 5 cm against one 20 % longer: off by 0.2 (x - 0.4) along it [m]."""
    spread = np.linspace(-0.4, 0.4, 50)
    return float(0.2 * np.sqrt(0.5 * (0.4**2 + np.mean(spread**2))))


def test_bands_count_only_in_the_error_over_all_panels() -> None:
    """Fails if a waistband, whose stretch nobody can see, spoilt the error of the panels that matter."""
    band = SQUARE * [0.8, 0.05]
    pattern = Pattern("p", (piece("a", SQUARE), piece("band", band * [1.2, 1.0])), ())
    found = measure_pattern(pattern, TruePattern((as_truth(piece("a", SQUARE)), as_truth(piece("band", band)))))
    assert found["panel_area_error"] == pytest.approx(0.0, abs=1e-12)
    assert found["panel_area_error_all"] == pytest.approx(0.1)
    assert found["panel_area_error_narrow"] == pytest.approx(0.2)
    assert found["panel_outline_narrow_mm"] == pytest.approx(1e3 * edge_rms_of_longer_band(), rel=1e-6)
    assert found["panel_outline_mm"] == pytest.approx(0.0, abs=1e-9)


def test_a_panel_without_counterpart_counts_one() -> None:
    """Fails if a lost or an invented panel were passed over."""
    pattern = Pattern("p", (piece("a", SQUARE), piece("new", 1.5 * SQUARE)), ())
    truth = TruePattern((as_truth(piece("a", SQUARE)), as_truth(piece("lost", SQUARE))))
    assert unmatched_panels(pattern, truth) == ("lost", "new")
    found = measure_pattern(pattern, truth)
    assert found["panel_area_error"] == pytest.approx(2.0 / 3.0)
    assert found["panels_unmatched"] == 2.0


@pytest.mark.parametrize("is_turned_over", [False, True])
def test_panels_of_other_names_are_matched_by_shape(is_turned_over: bool) -> None:
    """Fails if matching took the order, met a mirror image as another piece, or a rigid motion as an error."""
    long = TRAPEZOID * [1.0, 1.6]
    mirror = np.array([-1.0, 1.0])
    first = (1.05 * long * mirror)[::-1] if is_turned_over else 1.05 * long
    pattern = Pattern("p", (piece("x", turned(first, 1.0)), piece("y", SQUARE * 0.6 + 3.0)), ())
    truth = TruePattern((as_truth(piece("square", 0.6 * SQUARE)), as_truth(piece("long", long))))
    pairs = match_panels(pattern, truth)
    assert [(pair.truth.name, pair.ours.name, pair.by_name) for pair in pairs] == [
        ("square", "y", False),
        ("long", "x", False),
    ]
    assert is_same_cut(pattern, truth)
    assert unmatched_panels(pattern, truth) == ()
    found = measure_panels(pattern, truth)
    assert set(found["long"]) == {"area_error", "outline_mm", "turning"}
    assert found["long"]["area_error"] == pytest.approx(1.05**2 - 1.0, rel=1e-6)
    assert found["square"]["outline_mm"] < 0.1
    assert max(panel["turning"] for panel in found.values()) < 1e-6


def test_a_name_beats_a_shape() -> None:
    """Fails if two panels of one name were torn apart because others look more alike."""
    pattern = Pattern("p", (piece("a", TRAPEZOID), piece("b", SQUARE)), ())
    truth = TruePattern((as_truth(piece("a", SQUARE)), as_truth(piece("c", TRAPEZOID * 1.1))))
    pairs = {pair.truth.name: (pair.ours.name, pair.by_name) for pair in match_panels(pattern, truth)}
    assert pairs["a"] == ("a", True)
    assert "c" not in pairs  # a square metre is no counterpart of a quarter


def test_another_cut_is_not_compared() -> None:
    """Fails if a front in one piece were held against one half of it, or a band's absence counted as another cut."""
    halves = tuple(piece(name, SQUARE * [0.5, 1.0]) for name in ("left", "right"))
    whole, band = piece("front", SQUARE), piece("band", SQUARE * [0.8, 0.05])
    assert not is_same_cut(Pattern("p", halves, ()), TruePattern((as_truth(whole),)))
    assert is_same_cut(Pattern("p", (piece("body", SQUARE), band), ()), TruePattern((as_truth(whole),)))


def test_errors_of_the_cloth_are_logarithms() -> None:
    """Fails if an error of the fabric were turned round, or the ratio to the weight forgot the weight's own error."""
    cloth = Fabric("c", 500.0, 100.0, 400.0, 50.0, 2e-5, 0.2)
    found = measure_fabric(cloth, {"k": 1e-5, "density": 0.1})
    assert found == {
        "material_log_error.k": pytest.approx(np.log(2.0)),
        "material_log_error.density": pytest.approx(np.log(2.0)),
        "material_log_error.k_by_density": pytest.approx(0.0, abs=1e-12),
    }
    assert measure_fabric(cloth, {}) == {}


def test_other_edge_counts_fall_back_to_closest_points() -> None:
    """Fails if a panel with one more corner could not be compared, or compared without the rigid fit."""
    split = np.insert(TRAPEZOID, 1, 0.5 * (TRAPEZOID[0] + TRAPEZOID[1]), axis=0)
    pattern = Pattern("p", (piece("a", turned(split, 2.0)),), ())
    found = measure_pattern(pattern, TruePattern((as_truth(piece("a", TRAPEZOID)),)))
    assert found["panel_outline_mm"] < 0.5
    assert fit_outline(SQUARE, 1.02 * SQUARE).rms == pytest.approx(0.01, rel=0.1)


def test_seam_mismatch_and_gathers() -> None:
    """Fails if the mismatch were in metres, a gathered seam counted in it, or the ratio were turned upside down."""
    a, b = piece("a", SQUARE), piece("b", SQUARE * [0.5, 1.002])
    refs = [(EdgeRef("a", 1), EdgeRef("b", 3)), (EdgeRef("a", 2), EdgeRef("b", 0))]
    pattern = Pattern("p", (a, b), (Seam(*refs[0]), Seam(*refs[1], gathered=True)))
    assert measure_seams(pattern)["seam_mismatch_mm"] == pytest.approx(2.0)
    truth = TruePattern((as_truth(a), as_truth(piece("b", SQUARE * [0.4, 1.0]))), (TrueSeam(("b", 0), ("a", 2)),))
    found = measure_pattern(pattern, truth)
    assert found["gather_ratio_error.a:2-b:0"] == pytest.approx(abs(2.0 / 2.5 - 1.0))
    assert measure_seams(Pattern("p", (a,), ())) == {"seam_mismatch_mm": None}


def test_width_is_the_least_in_any_direction() -> None:
    """Fails if a slanted band were called wide because its bounding box is."""
    assert polygon_width(turned(SQUARE * [1.0, 0.05], 0.8)) == pytest.approx(0.05)
