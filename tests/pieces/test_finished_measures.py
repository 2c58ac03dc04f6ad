"""Finished measures: lengths of a pattern at the points of the trade, against another library's and by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.garment.measure_change import scale_panels
from garmentq.core.garment.measures import BodyMeasures
from garmentq.core.garment.pattern import Pattern
from garmentq.core.garment.pieces.finished_measures import measure_finished
from garmentq.core.garment.pieces.finished_points import HOW_TAKEN, FinishedPoint, list_finished
from garmentq.core.garment.pieces.flatten import flatten_outline
from garmentq.core.garment.pieces.make import make_pieces
from garmentq.core.garment.pieces.numbers import describe_pieces
from garmentq.core.garment.templates import draft_template, load_template
from shapely import LineString, Polygon


def values_of(pattern: Pattern) -> dict[str, float]:
    """Return the finished measures of a pattern [cm]."""
    return {str(one.point): 100.0 * one.value for one in measure_finished(pattern)}


def test_a_tee_by_hand():
    """Broken where a point is measured somewhere else: each length can be read off the draft's points."""
    found = values_of(load_template("tshirt"))
    assert found["chest"] == pytest.approx(102.0) and found["hem"] == pytest.approx(102.0)
    assert found["length"] == pytest.approx(63.5)  # from (0.09, 0) to the hem at -0.635
    assert found["shoulder"] == pytest.approx(100.0 * np.hypot(0.10, 0.04), abs=0.05)
    assert found["sleeve"] == pytest.approx(19.0, abs=0.05) and found["cuff"] == pytest.approx(35.0, abs=0.05)
    assert set(found) == {"chest", "waist", "hem", "length", "shoulder", "sleeve", "bicep", "cuff", "neck"}


@pytest.mark.parametrize("name", ["tshirt", "dress", "sleeved_jumpsuit", "trousers"])
def test_girths_are_what_another_library_cuts(name):
    """Broken where a chord leaves the panel, or one of two is lost: shapely cuts the same lines."""
    pattern = load_template(name)
    for one in measure_finished(pattern):
        if one.point not in (FinishedPoint.CHEST, FinishedPoint.HIP, FinishedPoint.THIGH, FinishedPoint.BICEP):
            continue
        total = 0.0
        for panel, ends in one.lines:
            polygon = Polygon(flatten_outline(pattern.panel(panel))[0])
            way = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
            middle = ends.mean(axis=0)
            cut = polygon.intersection(LineString([middle - 3.0 * way, middle + 3.0 * way]))
            parts = cut.geoms if cut.geom_type == "MultiLineString" else [cut]
            total += min(part.length for part in parts if part.distance(LineString(ends)) < 1e-9)
        sides = 2.0 if one.point in (FinishedPoint.THIGH, FinishedPoint.BICEP) else 1.0
        assert one.value == pytest.approx(total / sides, abs=1e-6), one.point


@pytest.mark.parametrize("name", ["long_sleeve_tshirt", "trousers", "skirt", "sleeved_dress"])
def test_lines_have_the_length_that_is_given(name):
    """Broken where the figure shows another line than the one that was measured."""
    pattern = load_template(name)
    for one in measure_finished(pattern):
        drawn = sum(float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum()) for _, line in one.lines)
        assert drawn / one.value == pytest.approx(round(drawn / one.value), abs=2e-3), one.point


def test_labels_and_names_do_not_matter():
    """Broken where a point is found by a label, which patterns from elsewhere do not have."""
    for name in ("tshirt", "trousers", "dress"):
        pattern = load_template(name)
        bare = tuple(
            replace(panel, edges=tuple(replace(edge, label="") for edge in panel.edges)) for panel in pattern.panels
        )
        assert values_of(replace(pattern, panels=bare)) == pytest.approx(values_of(pattern))


def test_a_larger_pattern_has_larger_measures():
    """Broken where a measure has a fixed length in it, or a side seam is taken for another."""
    for name in ("trousers", "tshirt"):
        pattern = load_template(name)
        before, after = values_of(pattern), values_of(scale_panels(pattern, 1.1, 1.1))
        assert set(before) <= set(after)
        for point in set(before) - {"chest", "waist", "hip", "bicep", "thigh"}:
            assert after[point] == pytest.approx(1.1 * before[point], rel=1e-3), point


@pytest.mark.parametrize(
    ("name", "points"),
    [
        ("trousers", "waist hip hem rise thigh inseam outseam"),
        ("skirt", "waist hip hem length"),
        ("dress+shaping=princess", "chest waist hip hem length neck"),
        ("jumpsuit", "chest waist hip hem length shoulder neck thigh inseam"),
        ("dress+bodice=strapless", "hem"),
        ("tshirt+sleeve_head=set-in", "chest waist hip hem length shoulder sleeve bicep cuff neck"),
        ("long_sleeve_tshirt+cuff=band", "chest waist hem length shoulder sleeve bicep cuff neck"),
        ("tshirt+hood=two", "chest waist hem length shoulder sleeve bicep cuff neck"),
        ("tshirt+yoke=shoulders", "chest waist hip hem length shoulder sleeve bicep cuff neck"),
    ],
)
def test_each_garment_has_its_points(name, points):
    """Broken where a cut loses a point, or has one that the trade does not take there."""
    assert set(values_of(draft_template(name, BodyMeasures()))) == set(points.split())


def test_finishes_count_where_the_trade_counts_them():
    """Broken where a cuff's band is left out of the sleeve, or a collar, a rib or a hood changes the neckline."""
    plain = values_of(load_template("long_sleeve_tshirt"))
    banded = values_of(draft_template("long_sleeve_tshirt+cuff=band", BodyMeasures()))
    assert banded["sleeve"] == pytest.approx(plain["sleeve"], abs=0.05)
    necks = [
        values_of(draft_template(f"tshirt+{finish}", BodyMeasures()))
        for finish in ("collar=none", "collar=rib", "collar=stand", "hood=two", "front=placket")
    ]
    assert [one["neck"] for one in necks] == pytest.approx(5 * [necks[0]["neck"]], abs=0.1)
    assert [one["length"] for one in necks] == pytest.approx(5 * [necks[0]["length"]], abs=0.1)


def test_a_wrap_is_measured_closed():
    """Broken where the cloth that lies over the other front counts twice, or a neckline without an end has a length."""
    plain = values_of(load_template("dress"))
    wrapped = values_of(draft_template("dress+neckline=v,front=wrap", BodyMeasures()))
    assert [wrapped[point] for point in ("chest", "waist", "hip")] == pytest.approx(
        [plain[point] for point in ("chest", "waist", "hip")], abs=0.1
    )
    assert "neck" not in wrapped


def test_pieces_have_them_as_metrics_and_say_how():
    """Broken where pieces, from which documents are written, lack the measures, or one cannot be explained."""
    pieces = make_pieces(load_template("trousers"))
    _, metrics = describe_pieces(pieces)
    assert metrics["finished.inseam_mm"] == pytest.approx(698.5, abs=1.5)
    lines = list_finished(pieces.finished_measures)
    assert lines[0].startswith("finished [cm]: waist 7") and sum(line.count(",") + 1 for line in lines) == 7
    assert all(one.how == HOW_TAKEN[one.point] for one in pieces.finished_measures)
    assert set(HOW_TAKEN) == set(FinishedPoint)
