"""Intervals of seams and edges have the share of lines that they claim, and say where nothing shows a line."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.garment.garment import Garment
from garmentq.core.garment.pattern import EdgeRef
from garmentq.core.garment.pieces.pattern_lines import PatternLine
from garmentq.core.garment.templates import load_draped_template
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.judge.edge_lengths import find_length_differences
from garmentq.core.judge.line_intervals import (
    INTERVAL_COVERAGE,
    MIN_LINE_COUNT,
    Evidence,
    LineInterval,
    describe_margins,
    find_margins,
    group_errors,
    load_errors,
    measure_intervals,
)
from garmentq.core.recover.line_evidence import find_line_evidence
from garmentq.core.scan.contours.contours import name_contours
from garmentq.core.scan.contours.target import Target

BODY = builtin_body("builtin:female,height=1.70")


@pytest.fixture(scope="module")
def shirt() -> Garment:
    """Return a T-shirt as it hangs on the built-in body."""
    garment = load_draped_template("tshirt")
    if garment is None:
        pytest.skip("no drape is shipped for this machine's triangulation")
    return garment


@pytest.mark.parametrize("count", [MIN_LINE_COUNT, 30, 200])
def test_as_many_further_lines_lie_within_as_claimed(count: int) -> None:
    """Breaks where the quantile is that of the known lines, and not the one that covers further lines too."""
    rng = np.random.default_rng(5)
    covered = []
    for _ in range(300):
        places, lengths = rng.lognormal(-4.0, 0.7, count), rng.lognormal(-3.0, 0.5, count)
        known = group_errors([("hem", Evidence.EDGE)] * count, places, lengths)
        place, length = find_margins("hem", Evidence.EDGE, known)
        assert place is not None and length is not None
        covered.append(
            ((rng.lognormal(-4.0, 0.7, 500) <= place).mean(), (rng.lognormal(-3.0, 0.5, 500) <= length).mean())
        )
    assert np.mean(covered, axis=0) == pytest.approx([INTERVAL_COVERAGE, INTERVAL_COVERAGE], abs=0.03)
    assert np.mean(covered) > INTERVAL_COVERAGE - 0.01


def test_a_kind_that_is_hardly_known_has_the_interval_of_all() -> None:
    """Breaks where three known lines of a kind pass for what is known of it."""
    kinds = [("hem", Evidence.EDGE)] * MIN_LINE_COUNT + [("neckline", Evidence.EDGE)] * (MIN_LINE_COUNT - 1)
    places = np.concatenate([np.full(MIN_LINE_COUNT, 0.001), np.full(MIN_LINE_COUNT - 1, 0.009)])
    known = group_errors(kinds, places, places)
    assert find_margins("hem", Evidence.EDGE, known)[0] == 0.001
    assert find_margins("neckline", Evidence.EDGE, known)[0] == 0.009 == find_margins("cuff", Evidence.EDGE, known)[0]
    far = group_errors([*kinds, ("cuff", Evidence.EDGE)], np.append(places, 0.05), np.append(places, 0.05))
    assert find_margins("cuff", Evidence.EDGE, far) == (0.05, 0.05), "one cuff was 5 cm off"
    assert find_margins("hem", Evidence.HIDDEN, known) == (None, None)
    assert find_margins("hem", Evidence.COLOUR, known) == (None, None)


def test_what_shows_a_line_is_found(shirt: Garment) -> None:
    """Breaks where an end that may be damage, or a seam in cloth that was not scanned, counts as shown."""
    contours, _ = name_contours(shirt.nodes, shirt.faces, BODY)
    target = Target(shirt.nodes, shirt.faces, vertex_normals(shirt.nodes, shirt.faces), contours, (), "tshirt")
    everything = np.ones(len(shirt.faces), dtype=bool)
    found = {(line.name, line.side): word for line, word in find_line_evidence(shirt, target, BODY, everything)}
    assert {found["hem", ""], found["neckline", ""], found["sleeve hem", "left"]} == {Evidence.EDGE}
    assert {found["shoulder seam", "left"], found["side seam", "right"]} == {Evidence.PROPORTION}
    torn = replace(target, contours=tuple(replace(one, trusted=one.name != "hem") for one in contours))
    right = everything & (shirt.nodes[shirt.faces].mean(axis=1)[:, 0] > BODY.joint("neck")[0] - 0.05)
    found = {(line.name, line.side): word for line, word in find_line_evidence(shirt, torn, BODY, right)}
    assert found["hem", ""] is Evidence.HIDDEN and found["neckline", ""] is Evidence.EDGE
    assert found["side seam", "right"] is Evidence.HIDDEN and found["side seam", "left"] is Evidence.PROPORTION


def test_a_recovered_pattern_gets_intervals_that_grow_with_its_lines(shirt: Garment) -> None:
    """Breaks where the margin of a length is that of another line, or hidden lines get numbers."""
    lines = find_line_evidence(
        shirt,
        Target(shirt.nodes, shirt.faces, vertex_normals(shirt.nodes, shirt.faces), shirt.contours, (), "tshirt"),
        BODY,
        np.ones(len(shirt.faces), dtype=bool),
    )
    found = measure_intervals(shirt.pattern, lines)
    assert len(found) == len(lines) > 8
    for one in found:
        place, ratio = find_margins(one.line.name, one.evidence, load_errors())
        assert one.place_margin == place and ratio is not None
        assert one.length_margin == pytest.approx(one.length * np.expm1(ratio))
        assert one.length == pytest.approx(one.line.measure_length(shirt.pattern))


def test_words_of_a_line() -> None:
    """Breaks where a place that is not visible is printed as if it were, or a hidden one gets a number."""
    line = PatternLine("armhole seam", "left", (EdgeRef("front", 1),), (EdgeRef("sleeve", 0),))
    wide = LineInterval(line, Evidence.PROPORTION, 0.452, 0.02, 0.011)
    words = ("armhole seam left", "45.2 cm +-1.1", "place not visible, +-20 mm")
    assert describe_margins(wide.describe()) == words
    near = replace(wide, place_margin=0.004, evidence=Evidence.COLOUR)
    assert describe_margins(near.describe())[2] == "+-4 mm"
    hidden = replace(wide, place_margin=None, length_margin=None, evidence=Evidence.HIDDEN)
    assert describe_margins(hidden.describe())[1:] == ("45.2 cm", "not scanned: the base pattern's")


def test_an_edge_that_is_longer_on_the_scan_than_its_pattern_hangs_is_told(shirt: Garment) -> None:
    """Breaks where a hem of another length passes, or one that is only stretched by its own weight is told."""
    target = Target(shirt.nodes, shirt.faces, vertex_normals(shirt.nodes, shirt.faces), shirt.contours, (), "tshirt")
    every = find_line_evidence(shirt, target, BODY, np.ones(len(shirt.faces), dtype=bool))
    lines = tuple(LineInterval(line, word, 1.0, 0.01, 0.02) for line, word in every)  # each length within 2 %
    assert find_length_differences(shirt, shirt.nodes, target, lines) == ()
    hem = next(one.vertices for one in shirt.contours if one.name == "hem")
    wide = np.array(shirt.nodes)
    wide[hem] += 0.1 * (wide[hem] - wide[hem].mean(axis=0))
    (told,) = find_length_differences(shirt, shirt.nodes, replace(target, vertices=wide), lines)
    assert told.startswith("the hem is ")
    torn = replace(target, vertices=wide, contours=tuple(replace(one, trusted=False) for one in shirt.contours))
    assert find_length_differences(shirt, shirt.nodes, torn, lines) == ()
