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
    Evidence,
    LineInterval,
    describe_margins,
    find_margins,
    fit_margins,
    load_margins,
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


@pytest.mark.parametrize("count", [12, 30, 200])
def test_as_many_further_lines_lie_within_as_claimed(count: int) -> None:
    """Breaks where the quantile is that of the known lines, and not the one that covers further lines too."""
    rng = np.random.default_rng(5)
    covered = []
    for _ in range(300):
        places, lengths = rng.lognormal(-4.0, 0.7, count), rng.lognormal(-3.0, 0.5, count)
        found = find_margins("hem", Evidence.EDGE, fit_margins([("hem", Evidence.EDGE)] * count, places, lengths))
        assert found is not None
        within = rng.lognormal(-4.0, 0.7, 500) <= found.place, rng.lognormal(-3.0, 0.5, 500) <= found.length
        covered.append([one.mean() for one in within])
    assert np.mean(covered, axis=0) == pytest.approx([INTERVAL_COVERAGE] * 2, abs=0.03)


def test_each_kind_has_the_margin_of_its_own_errors() -> None:
    """Breaks where hems get the margin of armholes, or three known lines of a kind pass for what is known of it."""
    rng = np.random.default_rng(6)
    kinds = [("hem", Evidence.EDGE)] * 40 + [("cuff", Evidence.EDGE)] * 40 + [("leg hem", Evidence.EDGE)]
    places = np.concatenate([0.001 * rng.lognormal(0.0, 0.5, 40), 0.009 * rng.lognormal(0.0, 0.5, 40), [0.3]])
    known = fit_margins(kinds, places, places)
    hem, cuff, leg, new = (find_margins(name, Evidence.EDGE, known) for name in ("hem", "cuff", "leg hem", "waist"))
    assert hem and cuff and leg and new
    assert 0.0015 < hem.place < 0.003 < new.place < 0.012 < cuff.place < 0.022
    assert new.place < leg.place < 0.3, "one leg hem was 30 cm off"
    assert find_margins("hem", Evidence.HIDDEN, known) is None
    assert find_margins("hem", Evidence.COLOUR, known) is None
    drafted = {("hem", Evidence.PROPORTION): hem, ("", Evidence.PROPORTION): cuff}
    assert (
        find_margins("hem", Evidence.COLOUR, drafted) is hem and find_margins("neck", Evidence.STRIPES, drafted) is cuff
    )


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
        known = find_margins(one.line.name, one.evidence, load_margins())
        assert known is not None and one.place_margin == known.place
        assert one.length_margin == pytest.approx(one.length * np.expm1(known.length))
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
