"""`garmentq match`: two patterns compared without a page."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner
from garmentq.cli.match import command
from garmentq.core.garment.garmentcode_writer import write_pattern
from garmentq.core.garment.templates import load_template


def test_a_known_change_gives_its_number_and_equal_panels_give_nothing(tmp_path: Path) -> None:
    """Broken where a file, a template or the pairs of a user are not read, or the table has other numbers."""
    skirt = load_template("skirt")
    front, back = skirt.panels
    larger = replace(skirt, panels=(replace(front, name="fore", points=1.1 * front.points), back))
    seams = tuple(replace(seam, **{side: _renamed(getattr(seam, side)) for side in ("a", "b")}) for seam in skirt.seams)
    (tmp_path / "larger.json").write_text(json.dumps(write_pattern(replace(larger, seams=seams))))
    (tmp_path / "pairs.csv").write_text("fore,front\n")
    asked = [str(tmp_path / "larger.json"), "skirt", "--pairs", str(tmp_path / "pairs.csv"), "--csv"]
    answer = CliRunner().invoke(command, [*asked, "--home", str(tmp_path / "home")])
    assert answer.exit_code == 0, answer.output
    changed, same = csv.DictReader(io.StringIO(answer.output))
    assert [changed[key] for key in ("first", "second", "paired by")] == ["fore", "front", "given"]
    assert float(changed["area %"]) == pytest.approx(21.0, abs=1e-6)
    assert float(changed["turning rad"]) == pytest.approx(0.0, abs=1e-6) and float(changed["outline mm"]) > 10.0
    assert [same[key] for key in ("first", "second", "paired by")] == ["back", "back", "name"]
    assert [float(same[key]) for key in ("turning rad", "area %", "outline mm")] == pytest.approx([0.0] * 3, abs=1e-6)


def _renamed(edge):
    """Return a side of a seam with the new name of its panel."""
    return replace(edge, panel="fore") if edge.panel == "front" else edge
