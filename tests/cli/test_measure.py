"""`garmentq measure`: of a body, of a pattern and of a job, as table, CSV, JSON and figure."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from click.testing import CliRunner
from garmentq.cli.main import group
from garmentq.core.garment.garmentcode_writer import save_pattern
from garmentq.core.garment.templates import load_template
from garmentq.core.run.errors import GarmentqError

ROOT = Path(__file__).parents[2]


def measure(*words: str) -> str:
    """Return what the command prints."""
    answer = CliRunner().invoke(group, ["measure", *words], catch_exceptions=False)
    assert answer.exit_code == 0, answer.output
    return answer.stdout


def test_a_body_is_measured_and_drawn(tmp_path):
    """Broken where a measure of a body is missing from rows or figure."""
    rows = [json.loads(line) for line in measure("builtin:female,height=1.7", "--json").splitlines()]
    assert len(rows) == 26 and rows[0] == {
        "of": "body", "measure": "height", "value": 170.0, "unit": "cm", "how": "from the soles to the crown",
    }  # fmt: skip
    figure = tmp_path / "m" / "body.svg"
    lines = measure(str(ROOT / "examples" / "data" / "body.ply"), "--csv", "--out", str(figure.parent)).splitlines()
    assert (figure.parent / "measures.csv").read_text().splitlines() == lines
    assert len(lines) == 27 and lines[1].startswith("body,height,")
    texts = ["".join(each.itertext()) for each in ET.parse(figure).iter("{http://www.w3.org/2000/svg}text")]
    assert {"front", "back", "side", "waist", *map(str, range(1, 27))} <= set(texts)


def test_a_pattern_is_measured_and_drawn(tmp_path):
    """Broken where a pattern's file is taken for a body, or its figure lacks a measure."""
    path = save_pattern(load_template("tshirt"), tmp_path / "p.json")
    table = measure(str(path), "--out", str(tmp_path))
    assert "chest" in table and "102" in table and "body" not in table
    texts = [
        "".join(each.itertext()) for each in ET.parse(tmp_path / "garment.svg").iter("{http://www.w3.org/2000/svg}text")
    ]
    assert {"sleeve", "18.8 cm", "1", "9"} <= set(texts)


@pytest.mark.parametrize("word", ["no-such-job", "builtin:female,height=9"])
def test_what_cannot_be_measured_is_refused(word, tmp_path):
    """Broken where an unknown job or body is an error without a code."""
    answer = CliRunner().invoke(group, ["measure", word, "--home", str(tmp_path)])
    assert isinstance(answer.exception, GarmentqError) and answer.exception.code in ("job.unknown", "body.spec_bad")
