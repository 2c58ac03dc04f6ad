"""Two patterns side by side: equal ones do not differ, and a known change gives its own number."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from garmentq.core.garment.curves import panel_outline
from garmentq.core.garment.garmentcode_writer import write_pattern
from garmentq.core.garment.pattern import Pattern
from garmentq.core.garment.templates import load_template
from garmentq.core.geometry.curves import Curve
from garmentq.core.judge.comparison import PairsBad, compare_files, compare_patterns
from garmentq.service.matching import PairsUnreadable, read_pairs


@pytest.fixture(scope="module")
def skirt() -> Pattern:
    """Return a pattern of two panels."""
    return load_template("skirt")


@pytest.mark.parametrize("name", ["skirt", "tshirt"])
def test_equal_patterns_do_not_differ(name: str) -> None:
    """Fails if a panel were compared with another one or its mirror image, or rounding counted as a difference."""
    pattern = load_template(name)
    found = compare_patterns(pattern, pattern)
    assert [(pair.first, pair.paired_by) for pair in found.pairs] == [(p.name, "name") for p in pattern.panels]
    assert found.only_first == found.only_second == ()
    for pair in found.pairs:
        assert (pair.turning, pair.area_percent, pair.outline_mm) == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)


def test_a_known_change_gives_its_number(skirt: Pattern) -> None:
    """Fails if areas were compared the wrong way round, or a similar shape counted as another one."""
    front, back = skirt.panels
    larger = replace(skirt, panels=(replace(front, points=1.1 * front.points), back))
    one, other = compare_patterns(larger, skirt).pairs
    assert one.area_percent == pytest.approx(21.0, abs=1e-6) and one.turning == pytest.approx(0.0, abs=1e-6)
    assert one.outline_mm > 5.0
    assert other.area_percent == pytest.approx(0.0, abs=1e-9)


def test_names_shapes_and_hands_pair(skirt: Pattern) -> None:
    """Fails if a renamed panel found no counterpart, or a user's pair were overruled."""
    front, back = skirt.panels
    renamed = replace(skirt, panels=(replace(front, name="vorne"), back), seams=())
    found = {pair.second: (pair.first, pair.paired_by) for pair in compare_patterns(renamed, skirt).pairs}
    assert found == {front.name: ("vorne", "shape"), back.name: (back.name, "name")}
    crossed = compare_patterns(skirt, skirt, {front.name: back.name, back.name: front.name})
    assert [(p.first, p.second, p.paired_by) for p in crossed.pairs] == [
        (back.name, front.name, "given"), (front.name, back.name, "given"),
    ]  # fmt: skip
    alone = compare_patterns(replace(skirt, panels=(front,), seams=()), skirt)
    assert alone.only_first == () and alone.only_second == (back.name,)


def test_pairs_that_are_none_are_refused(skirt: Pattern) -> None:
    """Fails if a misspelt panel were passed over, or one stood for two."""
    front, back = (panel.name for panel in skirt.panels)
    with pytest.raises(PairsBad, match="nosuch"):
        compare_patterns(skirt, skirt, {"nosuch": front})
    with pytest.raises(PairsBad, match="twice"):
        compare_patterns(skirt, skirt, {front: front, back: front})


def test_files_are_compared(skirt: Pattern, tmp_path: Path) -> None:
    """Fails if a stored pattern differed from itself, or the answer were no JSON."""
    file = tmp_path / "skirt.json"
    file.write_text(json.dumps(write_pattern(skirt)))
    found = json.loads(json.dumps(compare_files(str(file), str(file), {})))
    assert [pair["paired_by"] for pair in found["pairs"]] == ["name", "name"]
    assert np.abs([pair["area_percent"] for pair in found["pairs"]]).max() < 1e-6


@pytest.mark.parametrize("text", ['{"a": "b", "c": "d"}', "a,b\nc,d\n", "\ufeffa, b\r\n\r\nc,d"])
def test_pairs_are_read(text: str, tmp_path: Path) -> None:
    """Fails if one of the two forms, a mark at the beginning or an empty line were misread."""
    file = tmp_path / "pairs"
    file.write_bytes(text.encode())
    assert read_pairs(file) == {"a": "b", "c": "d"}


@pytest.mark.parametrize(
    "content", [b'{"a": 1}', b"[1]", b"{", b"a,b,c", b"a,b\na,c", b"\xff\xfe", b"[" * 50_000, b"x" * 200_000]
)
def test_bad_pairs_are_refused(content: bytes, tmp_path: Path) -> None:
    """Fails if a broken file ended in a traceback, or half of it were believed."""
    file = tmp_path / "pairs"
    file.write_bytes(content)
    with pytest.raises(PairsUnreadable):
        read_pairs(file)


def test_the_best_fit_is_told(skirt: Pattern) -> None:
    """Fails if the fit that is drawn were another than the one that is measured, or a mirror image drawn unturned."""
    front, back = skirt.panels
    angle, shift = 0.4, np.array([0.3, -0.1])
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    moved = replace(skirt, panels=(replace(front, points=front.points @ turn.T + shift), back))
    pair = compare_patterns(skirt, moved, {front.name: front.name}, only_given=True).pairs[0]
    assert (pair.angle, *pair.shift) == pytest.approx((angle, *shift), abs=1e-5) and not pair.turned_over
    assert pair.outline_mm == pytest.approx(0.0, abs=1e-2)
    sleeve = load_template("tshirt").panels[-1]
    other = replace(sleeve, points=sleeve.points * [-1.0, 1.0])
    shape = replace(skirt, panels=(sleeve,), seams=())
    found = compare_patterns(shape, replace(shape, panels=(other,))).pairs[0]
    where = panel_outline(sleeve, 24) * ([-1.0, 1.0] if found.turned_over else [1.0, 1.0])
    turn = np.array([[np.cos(found.angle), -np.sin(found.angle)], [np.sin(found.angle), np.cos(found.angle)]])
    away = Curve(panel_outline(other, 24)).distance(where @ turn.T + found.shift)
    assert 1e3 * np.sqrt(np.mean(away**2)) <= 2.0 * found.outline_mm + 0.1


def test_nothing_else_is_paired(skirt: Pattern) -> None:
    """Fails if a single pair were compared together with all others, or outlines were not those of the panels."""
    front = skirt.panels[0].name
    found = compare_patterns(skirt, skirt, {front: front}, only_given=True)
    assert [pair.first for pair in found.pairs] == [front] and len(found.only_first) == len(skirt.panels) - 1
