"""How sure the lines of a recovered pattern are is printed with its instructions."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from garmentq.core.deliver.formats.cover_page import instruction_contents, list_notes
from garmentq.core.deliver.formats.production import read_margins
from garmentq.core.garment.pieces.make import Style, make_pieces
from garmentq.core.garment.templates import load_template

LINE = {
    "name": "armhole seam", "side": "left", "evidence": "proportion", "visible": False, "place_margin_mm": 20.4,
    "length_mm": 452.0, "length_margin_mm": 11.0,
}  # fmt: skip


def test_margins_of_a_manifest_are_printed(tmp_path: Path) -> None:
    """Breaks where a sheet gives the lengths of a result without how sure they are."""
    (tmp_path / "manifest.json").write_text(json.dumps({"lines": [LINE]}))
    (text,) = read_margins(tmp_path)
    assert text == "armhole seam left, 45.2 cm +-1.1, place not visible, +-20 mm"
    pieces = make_pieces(load_template("tshirt"), style=Style(margins=(text,)))
    assert list_notes(pieces)[-2:] == ["How sure", f"- {text}"]
    assert any("place not visible" in page for page in instruction_contents(pieces, 210.0, 297.0))
    assert "How sure" not in list_notes(make_pieces(load_template("tshirt")))


@pytest.mark.parametrize("text", ["", "{", "[]", '{"lines": 3}', '{"lines": [4]}', '{"lines": [{"length_mm": "x"}]}'])
def test_a_damaged_manifest_gives_no_margins(text: str, tmp_path: Path) -> None:
    """Breaks where an export fails on what a stored file lacks."""
    assert read_margins(tmp_path) == ()
    (tmp_path / "manifest.json").write_text(text)
    assert read_margins(tmp_path) == ()
