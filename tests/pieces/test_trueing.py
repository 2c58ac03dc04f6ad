"""Lines are smooth where they cross seams, no further from the drawn pattern than is known of it."""

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.garment.curves import edge_points, panel_area, relative_to_chord
from garmentq.core.garment.fairness import MAX_SMOOTH_CORNER_ANGLE, interior_angles, measure_corner
from garmentq.core.garment.outline import arc_handles
from garmentq.core.garment.pattern import Edge, EdgeRef, Panel, Pattern, Seam
from garmentq.core.garment.pieces.make import PieceSettings, make_pieces
from garmentq.core.garment.pieces.trued_joins import find_crossed_joins
from garmentq.core.garment.pieces.trueing import BLENDING_TOLERANCE, describe_trueing, true_pattern
from garmentq.core.garment.seams import seam_lengths
from garmentq.core.garment.symmetry import find_symmetry
from garmentq.core.garment.templates import load_template
from garmentq_pieces import SLIT_CUTS, TEMPLATES

FLAT_HEAD = ("armhole seam", "sleeve seam")
"""A flat sleeve's cap is its armhole's own curve: under the arm it cannot be smooth."""

RADIUS = 0.15


def half_disc(name, turn=0.0):
    """Return a half disc below its seam along x, of two quarter arcs, each end at the seam turned by an angle [rad]."""
    points = np.array([[RADIUS, 0.0], [-RADIUS, 0.0], [0.0, -RADIUS]])
    edges = [Edge(label="seam")]
    for start, end in ((points[1], points[2]), (points[2], points[0])):
        handles = np.array(arc_handles(tuple(start), tuple(end), np.pi / 2))
        at, corner = (0, start) if start[1] == 0.0 else (1, end)
        angle = turn if at == 0 else -turn
        spin = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        handles[at] = corner + spin @ (handles[at] - corner)
        edges.append(Edge("cubic", relative_to_chord(handles, start, end), contour="hem"))
    return Panel(name, points, tuple(edges))


def disc(turn):
    seam = Seam(EdgeRef("one", 0), EdgeRef("other", 0))
    return Pattern("disc", (half_disc("one", turn), half_disc("other", turn)), (seam,), symmetric=False)


def misfit(pattern):
    """Return the largest distance of a disc's rim from the circle around the middle of its seams [m]."""
    rims = []
    for panel in pattern.panels:
        middle = panel.points[:2].mean(axis=0)
        rims += [np.linalg.norm(edge_points(panel, i, 64) - middle, axis=1) - RADIUS for i in (1, 2)]
    return np.abs(rims).max()


def test_two_halves_of_a_circle_are_true():
    """Broken where what is smooth already is moved."""
    trueing = true_pattern(disc(0.0))
    assert len(find_crossed_joins(disc(0.0))) == 2
    assert trueing.lines == () and trueing.pattern.points.tolist() == disc(0.0).points.tolist()


@pytest.mark.parametrize("degrees", [-8.0, 3.0, 8.0])
def test_a_bent_rim_becomes_the_circle_again(degrees):
    """Broken where the two halves do not meet at 180 degrees, or the line found is not near the circle."""
    bent = disc(np.radians(degrees))
    trued = true_pattern(bent).pattern
    assert all(abs(measure_corner(bent, join)) == pytest.approx(np.radians(2 * abs(degrees))) for join in joins(bent))
    assert all(abs(measure_corner(trued, join)) < 1e-4 for join in joins(trued))
    assert misfit(trued) < 0.8 * misfit(bent)
    assert np.ptp(seam_lengths(trued)) < 1e-6


def joins(pattern):
    return find_crossed_joins(pattern)


@pytest.mark.parametrize("name", TEMPLATES + SLIT_CUTS)
def test_each_cut_is_trued(name):
    """Broken where a line of a shipped cut is not smooth to 3 degrees at a seam and nothing says so, both sides of a
    seam differ, or a panel grows."""
    pattern = load_template(name)
    trueing = true_pattern(pattern)
    trued = trueing.pattern
    crossed = joins(pattern)
    left = [join for join in crossed if abs(measure_corner(trued, join)) > np.radians(3.0)]
    assert {(line.line, line.seam) for line in trueing.lines if not line.is_trued} <= {FLAT_HEAD}
    assert len(left) == sum(not line.is_trued for line in trueing.lines)
    assert len(crossed) > 1 and all(line.move < BLENDING_TOLERANCE for line in trueing.lines if line.is_trued)
    apart = (seam_lengths(trued) - seam_lengths(pattern))[~pattern.gathered]
    assert np.abs(apart[:, 0] - apart[:, 1]).max() < 1e-5
    pairs = zip(trued.panels, pattern.panels, strict=True)
    assert all(panel_area(one) == pytest.approx(panel_area(other), rel=0.006) for one, other in pairs)
    assert len(find_symmetry(trued).mirrors) == len(find_symmetry(pattern).mirrors)


@pytest.mark.parametrize("name", TEMPLATES)
def test_a_trued_pattern_stays(name):
    """Broken where each export moves the pattern on."""
    once = true_pattern(load_template(name)).pattern
    again = true_pattern(once)
    assert np.abs(again.pattern.points - once.points).max() < 1e-6
    assert not any(line.is_trued for line in again.lines)


@pytest.mark.parametrize("neckline", ["v", "square"])
def test_corners_of_the_design_stay(neckline):
    """Broken where trueing rounds the point of a V or the corners of a square neckline."""
    pattern = load_template(f"tank+neckline={neckline}")
    trued = true_pattern(pattern).pattern
    before, after = (interior_angles(one.panel("front")) for one in (pattern, trued))
    ends = {index for join in joins(pattern) for name, index in join.corners if name == "front"}
    inner = [i for i in range(len(before)) if i not in ends and abs(before[i] - np.pi) > np.radians(20.0)]
    assert inner and np.abs(after[inner] - before[inner]).max() < MAX_SMOOTH_CORNER_ANGLE


def test_a_recovered_line_moves_within_its_interval_only():
    """Broken where trueing overrules what a scan proves, or says nothing of a corner that it leaves."""
    pattern = load_template("tank")
    sure = true_pattern(pattern, np.full_like(pattern.points, 1e-4))
    assert sure.pattern.points.tolist() == pattern.points.tolist()
    assert sure.lines and not any(line.is_trued for line in sure.lines)
    assert all(line.tolerance < line.move for line in sure.lines)
    assert all("is left" in text for text in describe_trueing(sure.lines))
    unsure = true_pattern(pattern, np.full_like(pattern.points, 0.02))
    assert all(line.is_trued for line in unsure.lines)


def test_lines_of_a_dart_meet_where_it_is_folded():
    """Broken where the seam beside a dart has a corner once the dart is sewn."""
    pattern = load_template("dress+waist=seam,shaping=darts")
    trued = true_pattern(pattern).pattern
    mouths = [join for join in joins(trued) if join.seam and join.seam[0].panel == join.seam[1].panel]
    assert len(mouths) == 8
    assert max(abs(measure_corner(pattern, join)) for join in mouths) > np.radians(5.0)
    assert max(abs(measure_corner(trued, join)) for join in mouths) < np.radians(0.1)


def test_pieces_say_what_was_trued():
    """Broken where a cutter does not see that lines were moved, or that a sleeve's cap was not."""
    made = make_pieces(load_template("tshirt"))
    texts = describe_trueing(made.trued)
    assert len(texts) == len(set(texts)) == 6
    assert "is left" in texts[0] and all("moved" in text for text in texts[1:])
    plain = make_pieces(load_template("tshirt"), replace(PieceSettings(), is_trued=False))
    assert plain.trued == ()
