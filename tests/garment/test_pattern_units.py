"""Patterns from elsewhere whose numbers are of another unit than their file claims."""

import json

import pytest
from click.testing import CliRunner
from garmentq.cli import templates as commands
from garmentq.core.garment.errors import PatternUnitsUnclear
from garmentq.core.garment.garmentcode import read_pattern
from garmentq.core.garment.garmentcode_writer import write_pattern
from garmentq.core.garment.pattern_units import set_units
from garmentq.core.garment.templates import load_template


def document(units_in_meter, is_own=False):
    """Return a T-shirt's file in centimetres that claims another unit; not of this program's own writing."""
    found = json.loads(json.dumps(write_pattern(load_template("tshirt"))))
    if not is_own:
        del found["properties"]["garmentq"]
    found["properties"]["units_in_meter"] *= units_in_meter / 100.0
    return found


@pytest.mark.parametrize(("units", "answer"), [(1000, "cm"), (10, "cm")])
def test_a_garment_of_another_size_is_asked_about(units, answer):
    """Broken where a T-shirt of 6 cm, or of 6 m, is imported without a word."""
    with pytest.raises(PatternUnitsUnclear, match=f"--units {answer}") as caught:
        read_pattern(document(units))
    assert caught.value.code == "pattern.units_unclear"


def test_the_answer_is_taken():
    """Broken where the unit that was said is asked about again, or scales something else."""
    wide = max(float(panel.points[:, 0].max()) for panel in load_template("tshirt").panels)
    found = read_pattern(set_units(document(1000), "cm"))
    assert max(float(panel.points[:, 0].max()) for panel in found.panels) == pytest.approx(wide, rel=1e-6)
    small = read_pattern(set_units(document(1000), "mm"))
    assert max(float(panel.points[:, 0].max()) for panel in small.panels) == pytest.approx(wide / 10.0, rel=1e-6)
    assert read_pattern(write_pattern(small)).panels


def test_a_usual_garment_is_not_asked_about():
    """Broken where a file in centimetres or millimetres that is right has to be confirmed."""
    read_pattern(document(100))
    read_pattern(document(1000, is_own=True))


def test_the_command_takes_the_unit(tmp_path, monkeypatch):
    """Broken where `--units` does not reach the library, or changes the user's file."""
    file = tmp_path / "tee.json"
    file.write_text(json.dumps(document(1000)), encoding="utf-8")
    before, seen = file.read_bytes(), []

    class Library:
        def import_template(self, name, path):
            seen.append((name, path.name, read_pattern(path.read_bytes())))
            raise SystemExit(0)

    monkeypatch.setattr(commands, "_open", lambda home: Library())
    CliRunner().invoke(commands.command, ["import", str(file), "--name", "tee", "--units", "cm"])
    ((name, path, pattern),) = seen
    assert (name, path, len(pattern.panels)) == ("tee", "tee.json", 6) and file.read_bytes() == before
