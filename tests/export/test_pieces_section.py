"""What a report says of the pieces to cut."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.deliver.export import pieces_section
from garmentq.core.deliver.export.pieces_section import pieces_html
from garmentq.core.garment.pattern import Edge, Panel, Pattern
from garmentq.core.garment.pieces.errors import PieceBad
from garmentq.core.garment.pieces.make import make_pieces
from garmentq.core.garment.pieces.numbers import describe_pieces
from garmentq.core.garment.pieces.trueing import describe_trueing
from garmentq.core.garment.templates import load_template


def test_pieces_sheets_and_cloth_are_told() -> None:
    """Fails if a piece, its number of copies or what is missing were left out, or the cloth were another amount."""
    pattern = load_template("tshirt")
    html = pieces_html(pattern)
    numbers, found = describe_pieces(make_pieces(pattern))
    assert [*re.findall(r"<tr><td>([A-Z_]+)</td>", html)] == [one.name for one in numbers]
    assert "<td>2 (1 pair)</td>" in html  # the sleeve
    assert f"{found['pieces.cloth_length_m']:.2f} m of cloth 140 cm wide" in html
    sheets = int(re.search(r"(\d+) sheets of A4", html).group(1))
    area = sum(one.area for one in numbers)
    assert area / (0.19 * 0.277) < sheets < 4 * area / (0.19 * 0.277)
    made = make_pieces(pattern)
    assert html.count("<li>") == len(made.missing) + len(describe_trueing(made.trued)) > len(made.missing) > 0


def test_hostile_names_stay_text() -> None:
    """Fails if the name of a panel became part of the page."""
    pattern = load_template("skirt")
    front, back = pattern.panels
    hostile = replace(pattern, panels=(replace(front, name="<script>alert(1)</script>"), back), seams=())
    assert "<script" not in pieces_html(hostile)


def test_what_no_cloth_holds_is_said() -> None:
    """Fails if a piece wider than cloth needed an infinite length."""
    square = 30.0 * np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    html = pieces_html(Pattern("x", (Panel("a", square, (Edge(),) * 4),), ()))
    assert "wider than 140 cm" in html and "inf" not in html


def test_a_refusal_leaves_the_report_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fails if a pattern of which no pieces can be cut ended the report."""

    def refuse(pattern: Pattern) -> None:
        raise PieceBad("piece <A> cannot be cut.")

    monkeypatch.setattr(pieces_section, "make_pieces", refuse)
    html = pieces_html(load_template("skirt"))
    assert "None: piece &lt;A&gt; cannot be cut." in html and html.endswith("</section>")
