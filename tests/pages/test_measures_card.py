"""The measures on the page of a result, and in its report."""

from __future__ import annotations

from types import SimpleNamespace

from garmentq.core.body.body_tape import tabulate_body
from garmentq.core.body.builtin import builtin_body
from garmentq.core.deliver.export.measures_section import finished_html, wearer_html
from garmentq.core.garment.pieces.make import make_pieces
from garmentq.core.garment.pieces.numbers import describe_pieces
from garmentq.core.garment.templates import load_template
from garmentq.service.pages.measures_card import draw_measures


def test_a_result_shows_the_measures_of_garment_and_wearer():
    """Broken where metrics get other names than the page and the report look for, or another unit."""
    pieces = make_pieces(load_template("tshirt"))
    wearer = tabulate_body(builtin_body("builtin:female,height=1.70"))
    metrics = describe_pieces(pieces)[1] | wearer
    shown = str(draw_measures(SimpleNamespace(id="3685ecfd4f81", metrics=metrics))).replace("\u00a0", " ")
    assert shown.count('scope="row"') == len(pieces.finished_measures) + 26
    assert (
        "102.0 cm" in shown and "170.0 cm" in shown and "around, 2.5 cm below the armhole" in shown and "47°" in shown
    )
    report = finished_html(load_template("tshirt"), pieces.finished_measures) + wearer_html(metrics)
    assert "102.0 cm" in report and "170.0 cm" in report and "data:image/svg+xml" in report


def test_what_was_not_measured_is_left_out():
    """Broken where a result of an earlier version, without measures, has an empty card or section."""
    job = SimpleNamespace(id="3685ecfd4f81", metrics={"surface_rms_mm.t2s": 3.0, "wearer.wrist_mm": None})
    assert str(draw_measures(job)) == "" and wearer_html(job.metrics) == ""
    assert finished_html(load_template("tshirt"), ()) == ""
