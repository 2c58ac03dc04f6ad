"""Parts of a garment that are graded as one, and what a kink between them costs, on two tubes sewn together."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.garment.curves import panel_area
from garmentq.core.garment.garment import Garment
from garmentq.core.garment.handles import handles_of, list_curves, with_handles
from garmentq.core.garment.pattern import Edge, EdgeRef, Panel, Pattern, Seam
from garmentq.core.garment.seams import equalise_seams, seam_mismatch
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.garment.templates import load_template
from garmentq.core.recover.fit.shape import seam_null_space
from garmentq.core.recover.grade.compared_area import ComparedArea
from garmentq.core.recover.grade.flattening import fit_control_points
from garmentq.core.recover.grade.parts import find_armhole_pairs, find_parts
from garmentq.core.recover.grade.proportion import area_growth, find_proportions
from garmentq.core.recover.grade.registration import bending_operators

SIDE = 0.3
"""Side of each square panel [m]."""


@pytest.fixture(scope="module")
def garment() -> Garment:
    """Sew two tubes of two squares each, one below the other."""
    points = SIDE * np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    names = ("upper_front", "upper_back", "lower_front", "lower_back")
    seams = []
    for tube in ("upper", "lower"):
        for a, b in ((1, 3), (3, 1)):
            seams.append(Seam(EdgeRef(f"{tube}_front", a), EdgeRef(f"{tube}_back", b)))
    for side in ("front", "back"):
        seams.append(Seam(EdgeRef(f"upper_{side}", 0), EdgeRef(f"lower_{side}", 2)))
    panels = tuple(Panel(name, points, (Edge(),) * 4) for name in names)
    return mesh_pattern(Pattern("tubes", panels, tuple(seams)), 400)


def cost(garment: Garment, values: np.ndarray, across: float) -> float:
    """Return the bending energy of a displacement told at the uv vertices."""
    on_nodes = np.zeros(len(garment.nodes))
    on_nodes[garment.uv_node] = values
    return float(on_nodes @ bending_operators(garment, across)[0] @ on_nodes)


def test_a_front_and_its_back_are_one_part(garment):
    """Broken where one seam joins two parts, or two do not."""
    part = find_parts(garment.pattern)
    assert part[0] == part[1] != part[2] == part[3]


@pytest.fixture(scope="module")
def darted() -> Pattern:
    """Sew a tube with a dart and an edge of 1 mm in the waist seam of front and back to a plain one below it."""
    top = np.array(
        [[0.0, 0.0], [0.12, 0.0], [0.15, 0.1], [0.18, 0.0], [0.181, 0.0], [0.3, 0.0], [0.3, 0.3], [0.0, 0.3]]
    )
    skirt = np.array([[0.0, 0.0], [0.239, 0.0], [0.239, 0.4], [0.12, 0.4], [0.0, 0.4]])
    panels, seams = [], []
    for side in ("front", "back"):
        panels += [Panel(f"top_{side}", top, (Edge(),) * 8), Panel(f"skirt_{side}", skirt, (Edge(),) * 5)]
        seams.append(Seam(EdgeRef(f"top_{side}", 1), EdgeRef(f"top_{side}", 2)))
        seams += [Seam(EdgeRef(f"top_{side}", n), EdgeRef(f"skirt_{side}", m)) for n, m in ((0, 3), (4, 2))]
    for part, right, left in (("top", 5, 7), ("skirt", 1, 4)):
        for n, m in ((right, left), (left, right)):
            seams.append(Seam(EdgeRef(f"{part}_front", n), EdgeRef(f"{part}_back", m)))
    return Pattern("dress", tuple(panels), tuple(seams))


def test_a_seam_that_darts_cut_into_edges_is_one(darted):
    """Broken where edges are counted and not seams: top and skirt are then one part, and kept in proportion."""
    part = find_parts(darted)
    assert part[0] == part[2] != part[1] == part[3]


def test_grading_keeps_darts_and_short_edges(darted):
    """Broken where they are graded like cloth: they turn over on other garments, and nothing can be graded."""
    garment = mesh_pattern(darted, 500)
    points = fit_control_points(garment, np.tile(1.3 * np.eye(2), (len(garment.faces), 1, 1)))
    graded = darted.with_points(points)
    before, after = darted.panel("top_front").points, graded.panel("top_front").points
    assert np.linalg.norm(after[4] - after[3]) == pytest.approx(1e-3, abs=5e-5)
    assert np.linalg.norm(after[3] - after[1]) == pytest.approx(0.06, rel=0.1)
    assert np.linalg.norm(after[6] - after[7]) == pytest.approx(1.3 * np.linalg.norm(before[6] - before[7]), rel=0.05)
    missing, rates = find_proportions(darted).linearise(graded)
    assert missing.shape == rates.shape[:1] and np.abs(find_proportions(darted).linearise(darted)[0]).max() < 1e-9


def test_a_kink_is_free_between_parts_only(garment):
    """Broken where panels of one part may kink, or parts are held together by more than their share."""
    lower = garment.panel_of_uv >= 2
    below = np.where(lower, SIDE - garment.uv[:, 1], 0.0)
    round_ = np.where(garment.panel_of_uv % 2 == 0, garment.uv[:, 0], SIDE - garment.uv[:, 0])
    whole = cost(garment, below, 1.0)
    assert whole > 0.1
    assert cost(garment, below, 0.0) < 1e-9 * whole
    assert cost(garment, below, 0.01) == pytest.approx(0.01 * whole)
    assert cost(garment, round_, 0.0) > 0.1


def test_armholes_are_found_and_waists_are_not(darted):
    """Broken where a waist that darts divide, or a trouser's crotch, is taken for a pair of armholes, or none is."""
    for name in ("skirt", "pencil_skirt", "trousers", "shorts", "tank", "dress", "jumpsuit"):
        assert not find_armhole_pairs(load_template(name))
    assert not find_armhole_pairs(darted)
    shirt = load_template("tshirt")
    across = find_armhole_pairs(shirt)
    assert len(across) == 2  # front and back
    for shoulders, chest in across:
        height = [shirt.points[list(pair), 1] for pair in (shoulders, chest)]
        assert np.ptp(height[0]) < 1e-9 > np.ptp(height[1])
        assert height[0][0] > height[1][0] + 0.1


def test_shoulders_keep_their_width_by_the_chest():
    """Broken where the rule has a wrong sign, spread or rate: a wider chest then costs nothing, or widens."""
    shirt = load_template("tshirt")
    rules = find_proportions(shirt)
    (_, chest), _ = find_armhole_pairs(shirt)
    points = shirt.points.copy()
    points[list(chest), 0] *= 1.04
    wider = shirt.with_points(points)
    at = len(rules.areas) + len(rules.lengths)
    missing, rates = rules.linearise(wider)
    assert missing[at] == pytest.approx(-np.log(1 / 1.04) / 0.04)
    step = 1e-6 * np.sin(np.arange(points.size))
    ends = [rules.linearise(wider.with_points(points + s * step.reshape(-1, 2)))[0][at] for s in (1, -1)]
    assert rates[at] @ step == pytest.approx(-(ends[0] - ends[1]) / 2, rel=1e-6)


def test_area_growth_is_the_derivative_of_ln_of_all_panels_area():
    """Broken where a curve beside its chord, a panel or the division by the whole is left out."""
    shirt = load_template("tshirt")
    step = 1e-6 * np.sin(np.arange(shirt.points.size)).reshape(-1, 2)
    ends = [sum(panel_area(panel) for panel in shirt.with_points(shirt.points + s * step).panels) for s in (1, -1)]
    assert float((area_growth(shirt) * step).sum()) == pytest.approx(np.log(ends[0] / ends[1]) / 2, rel=1e-6)


def test_a_point_within_a_seam_keeps_its_share_of_it():
    """Broken where the notch of a smooth side seam is free, counts twice, or the rate has a wrong sign or spread."""
    skirt = load_template("skirt")
    rules = find_proportions(skirt)
    assert len(rules.notched) == 2 and len({ref for pair in rules.notched for ref in pair}) == 4  # both sides, once
    edge, after = rules.notched[0]
    points = skirt.points.copy()
    start, notch, end = skirt.ends_of(edge)[0], skirt.ends_of(edge)[1], skirt.ends_of(after)[1]
    points[notch] += 0.1 * (points[end] - points[start])
    at = len(rules.areas) + len(rules.lengths) + len(rules.widths)
    moved = skirt.with_points(points)
    missing, rates = rules.linearise(moved)
    assert missing[at] < -1.0
    step = 1e-6 * np.sin(np.arange(points.size))
    ends = [rules.linearise(moved.with_points(points + s * step.reshape(-1, 2)))[0][at] for s in (1, -1)]
    assert rates[at] @ step == pytest.approx(-(ends[0] - ends[1]) / 2, rel=1e-3)


def test_a_side_seam_does_not_wander_to_the_front_and_back():
    """Broken where a front that narrows at the waist by what its back widens costs nothing: areas do not change."""
    dress = load_template("dress")
    rules = find_proportions(dress)
    assert len(rules.widths) == 2  # at the waist and at the hip
    first = len(rules.areas) + len(rules.lengths)
    for n, ((a, b), (back_a, back_b)) in enumerate(rules.widths):
        points = dress.points.copy()
        middle = points[[a, b], 0].mean()
        points[[a, b], 0] = middle + 0.8 * (points[[a, b], 0] - middle)
        missing, _ = rules.linearise(dress.with_points(points))
        assert missing[first + n] == pytest.approx(-np.log(0.8) / 0.04)
        assert dress.points[a, 1] == pytest.approx(dress.points[b, 1])
        assert dress.points[back_a, 1] == pytest.approx(dress.points[back_b, 1])


def test_a_dart_on_a_seam_keeps_its_place_along_it():
    """Broken where edges on both sides of a closed dart are not known to follow each other: the dart then slides."""
    dress = load_template("dress+waist=seam,shaping=darts")
    pairs = {pair for pair in find_proportions(dress).notched if pair[0].edge + 3 == pair[1].edge}
    assert {pair[0].panel for pair in pairs} == {"front", "back"}
    for before, after in pairs:
        ends = dress.ends_of(before)[1], dress.ends_of(after)[0]
        assert 0.0 < np.linalg.norm(dress.points[ends[0]] - dress.points[ends[1]]) < 0.06  # the mouth


@pytest.mark.parametrize("name", ["trousers", "tank", "dress+waist=seam,shaping=darts"])
def test_a_file_that_rounds_is_graded_as_it_is_drawn(name):
    """Broken where what rounding leaves between left and right has to hold by itself.

    Points moved by decimetres then, or the fit through the simulator lost a third of its motions.
    """
    drawn = load_template(name)
    rounded = drawn.with_points(drawn.points + 3e-4 * np.random.default_rng(0).uniform(-1, 1, drawn.points.shape))
    garment = mesh_pattern(rounded, 500)
    points = fit_control_points(garment, np.tile(np.eye(2), (len(garment.faces), 1, 1)))
    assert np.abs(points - rounded.points).max() < 1e-3
    equal = equalise_seams(rounded)
    assert np.abs(equal.points - rounded.points).max() < 1e-3
    assert seam_mismatch(equal) < 1e-5
    assert seam_null_space(rounded, rounded).shape == seam_null_space(drawn, drawn).shape


def test_halves_of_a_circle_are_compared_by_what_their_hems_round():
    """Broken where areas are compared of panels whose corners lie on one line: ln 0, and nothing can be graded."""
    corners = np.array([[0.9, 0.0], [-0.9, 0.0], [-0.1, 0.0], [0.1, 0.0]])
    rim, waist = (Edge("arc", np.array([[0.5, height]])) for height in (-0.5, 0.5))
    halves = tuple(Panel(name, corners, (rim, Edge(), waist, Edge())) for name in ("front", "back"))
    seams = tuple(Seam(EdgeRef("front", n), EdgeRef("back", m)) for n, m in ((1, 3), (3, 1)))
    circle = Pattern("circle", halves, seams)
    rules = find_proportions(circle)
    assert rules.edges and rules.sisters[0][0].measure(circle) == pytest.approx(0.5 * np.pi * 0.9**2, rel=1e-3)
    missing, rates = rules.linearise(circle)
    assert np.isfinite(missing).all() and np.isfinite(rates).all()


def test_two_discs_are_not_compared():
    """Broken where the ratio of two areas is taken that are none, of panels whose every edge is a curved seam."""
    ends = np.array([[-0.2, 0.0], [0.2, 0.0]])
    discs = tuple(Panel(name, ends, (Edge("arc", np.array([[0.5, -0.5]])),) * 2) for name in ("top", "under"))
    seams = tuple(Seam(EdgeRef("top", n), EdgeRef("under", m)) for n, m in ((0, 1), (1, 0)))
    rules = find_proportions(Pattern("bag", discs, seams))
    assert rules.sisters == ()


@pytest.mark.parametrize("name", ["tshirt+neckline=v", "skirt+skirt=full-circle", "dress", "trousers"])
def test_compared_areas_follow_points(name):
    """Broken where the curve of a hem is not carried along with its chord, or another edge's is."""
    drawn, rng = load_template(name), np.random.default_rng(0)
    away = 1e-6 * rng.normal(size=drawn.points.shape)
    for area in (area for pair in find_proportions(drawn).sisters for area in pair):
        ends = [area.measure(drawn.with_points(drawn.points + way * away)) for way in (1.0, -1.0)]
        assert (ends[0] - ends[1]) / 2.0 == pytest.approx(float((area.rates(drawn) * away).sum()), rel=1e-6)


def test_a_hem_with_a_point_in_its_middle_counts_whole():
    """Broken where a rounding below the line between a hem's ends makes a neckline of it, whose curves do not count."""
    points = np.array([[0.0, 0.0], [0.3, 1e-9], [0.6, 0.0], [0.6, 0.5], [0.3, 0.4], [0.0, 0.5]])
    panels = tuple(Panel(name, points, (Edge(),) * 6) for name in ("front", "back"))
    seams = tuple(Seam(EdgeRef("front", n), EdgeRef("back", m)) for n, m in ((2, 5), (5, 2)))
    area = ComparedArea.of(Pattern("skirt", panels, seams), "front")
    assert area.hems == (0, 1)


def test_a_deeper_neckline_is_not_made_up_for():
    """Broken where areas are compared with what curves take: the sides then move when the neckline sinks."""
    shirt = load_template("tshirt")
    rules = find_proportions(shirt)
    curves = [ref for ref, _, _ in list_curves(shirt) if ref.panel == "front"]
    assert curves and rules.sisters
    handles = handles_of(shirt)
    for ref, _, own in list_curves(shirt):
        handles[own, 1] *= 1.5 if ref in curves else 1.0
    before, after = (rules.linearise(one)[0][: len(rules.sisters)] for one in (shirt, with_handles(shirt, handles)))
    np.testing.assert_allclose(before, after, atol=1e-12)
