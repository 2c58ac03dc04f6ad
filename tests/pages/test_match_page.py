"""The matcher in a real browser: two rows, pairs by hand and by proposal, numbers, moved and turned pieces, colours."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.garment.garmentcode_writer import save_pattern
from garmentq.core.garment.templates import load_template
from garmentq.core.judge.comparison import compare_patterns


@pytest.fixture(scope="module")
def changed(tmp_path_factory):
    """Return the file of a skirt whose front is 10 % larger, that is 21 % by area."""
    skirt = load_template("skirt")
    front = replace(skirt.panels[0], points=1.1 * skirt.panels[0].points)
    file = tmp_path_factory.mktemp("patterns") / "larger.json"
    save_pattern(replace(skirt, panels=(front, *skirt.panels[1:])), file)
    return file


@pytest.fixture(scope="module")
def window(open_window):
    """Open one window for the tests of this file."""
    with open_window() as opened:
        yield opened.new_page()


@pytest.fixture
def matcher(window):
    """Return the page with a skirt beside itself, as it was proposed; it is loaded where the last test left it."""
    if "a=skirt&b=skirt" not in window.url:
        open_match(window, "skirt", "skirt")
    elif read_pairs(window) != PROPOSED:
        window.locator("#propose").click()
        window.locator('#pairs tr[data-first="back"][data-second="back"]').wait_for()
    window.locator("#reset").click()
    return window


PROPOSED = [["front", "front", "name", "0.0000", "0.00", "0.00"], ["back", "back", "name", "0.0000", "0.00", "0.00"]]


def open_match(page, first: str, second: str) -> None:
    """Open the page and wait for its pieces."""
    page.goto(f"/match?a={first}&b={second}")
    page.wait_for_selector("#match[data-ready]")


def read_pairs(page) -> list[list[str]]:
    """Return first, second, and the four cells of each pair."""
    return page.eval_on_selector_all(
        "#pairs tbody tr",
        "rows => rows.filter(r => r.dataset.second).map(r => [r.dataset.first, r.dataset.second,"
        " ...[...r.cells].slice(3, 7).map(c => c.textContent)])",
    )


def piece(page, row: int, name: str):
    """Return a piece."""
    return page.locator(f'.piece[data-row="{row}"][data-name="{name}"]')


def place_of(page, row: int, name: str) -> tuple[float, float, float]:
    """Return where a piece lies and how it is turned [mm, degrees]."""
    found = piece(page, row, name)
    x, y = found.get_attribute("transform")[len("translate(") : -1].split()
    return float(x), float(y), float(found.get_attribute("data-turn"))


def press(page, row: int, name: str, *keys: str) -> None:
    """Press keys on a piece."""
    piece(page, row, name).focus()
    for key in keys:
        page.keyboard.press(key)


def pair_row(page, first: str, second: str):
    """Wait for the row of a pair."""
    page.locator(f'#pairs tr[data-first="{first}"][data-second="{second}"]').wait_for()


def test_m1_two_rows_of_equal_patterns_differ_by_nothing(matcher):
    """Broken where a pattern's pieces are missing, rows overlap, or equal patterns differ."""
    names = matcher.eval_on_selector_all(".piece", "all => all.map(e => e.dataset.row + e.dataset.name)")
    assert sorted(names) == ["0back", "0front", "1back", "1front"]
    boxes = [[piece(matcher, row, name).bounding_box() for name in ("front", "back")] for row in (0, 1)]
    assert max(box["y"] + box["height"] for box in boxes[0]) < min(box["y"] for box in boxes[1])
    assert read_pairs(matcher) == PROPOSED
    assert "2 pairs, mean turning distance 0.0000 rad" in matcher.locator("#summary").inner_text()


def test_m2_pieces_are_paired_by_hand(matcher):
    """Broken where mouse or keyboard pairs other pieces than the chosen ones, or an old pair stays beside a new one."""
    piece(matcher, 0, "front").click()
    piece(matcher, 1, "back").click()
    matcher.locator("#pair").click()
    pair_row(matcher, "front", "back")
    assert [row[:3] for row in read_pairs(matcher)] == [["front", "back", "given"]]
    assert "Only in the first: back" in matcher.locator("#summary").inner_text()
    assert matcher.url.endswith("pair=front%3Aback")
    press(matcher, 0, "front", "u")
    assert read_pairs(matcher) == []
    press(matcher, 0, "front", "Escape", "Enter")
    press(matcher, 1, "back", "Enter", "p")
    pair_row(matcher, "front", "back")
    matcher.get_by_label("Counterpart of back").focus()
    matcher.keyboard.press("f")
    pair_row(matcher, "back", "front")
    assert [row[:3] for row in read_pairs(matcher)] == [["back", "front", "given"], ["front", "back", "given"]]
    press(matcher, 0, "front", "Escape")


@pytest.mark.nightly
def test_pairs_stay_in_the_address(page, site):
    """Broken where a page that is loaded again, or sent to somebody, shows other pairs."""
    open_match(page, "skirt", "skirt&pair=front:back")
    assert {(row[0], row[1]): row[2] for row in read_pairs(page)}["front", "back"] == "given"


def test_m3_a_known_change_gives_its_number(context, page, site, changed):
    """Broken where numbers are other ones than the library's, or a file cannot be chosen for a pattern."""
    page.goto("/match?b=skirt")
    page.locator('#b option[value="skirt"]').wait_for(state="attached")
    page.locator("#a-file").set_input_files(changed)
    page.get_by_role("option", name="larger.json").wait_for(state="attached")
    page.get_by_role("button", name="Compare").click()
    page.wait_for_selector("#match[data-ready]")
    front, back = read_pairs(page)
    assert front[3:5] == ["0.0000", "21.00"] and back[3:] == ["0.0000", "0.00", "0.00"]
    skirt = load_template("skirt")
    larger = replace(skirt, panels=(replace(skirt.panels[0], points=1.1 * skirt.panels[0].points), skirt.panels[1]))
    wanted = compare_patterns(larger, skirt).pairs[0]
    assert float(front[5]) == pytest.approx(wanted.outline_mm, abs=0.006)
    assert "21.00 % larger" in page.locator("#overlay").inner_text()
    texts = {}
    for kind in ("csv", "json", "pairs"):
        with page.expect_download() as saved:
            page.locator(f"#save-{kind}").click()
        texts[kind] = saved.value.path().read_text()
    rows = list(csv.DictReader(io.StringIO(texts["csv"])))
    assert [float(row["area %"]) for row in rows] == pytest.approx([21.0, 0.0], abs=1e-6)
    found = json.loads(texts["json"])
    assert found["pairs"][0]["outline_mm"] == pytest.approx(wanted.outline_mm) and found["only_second"] == []
    assert json.loads(texts["pairs"]) == {"front": "front", "back": "back"}


def test_m4_pieces_are_moved_and_turned(matcher):
    """Broken where a piece goes elsewhere than the pointer, a key moves it by another length, or it cannot go back."""
    start = place_of(matcher, 0, "back")
    scale = matcher.evaluate("document.querySelector('svg.pieces').getScreenCTM().a")
    box = piece(matcher, 0, "back").locator("path").bounding_box()
    drag(matcher, (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2), (40, 25))
    moved = place_of(matcher, 0, "back")
    assert np.subtract(moved, start) == pytest.approx((40 / scale, 25 / scale, 0.0), abs=0.1)
    assert piece(matcher, 0, "back").get_attribute("aria-pressed") == "false"
    for key in ("Enter", "ArrowRight", "Shift+ArrowUp", ".", ".", "Shift+<"):
        matcher.keyboard.press(key)
    turned = place_of(matcher, 0, "back")
    assert np.subtract(turned, moved) == pytest.approx((10.0, -1.0, 9.0), abs=0.02)
    handle = matcher.locator(".handle circle").bounding_box()
    middle = (handle["x"] + handle["width"] / 2, handle["y"] + handle["height"] / 2)
    shown = matcher.evaluate(
        "([x, y]) => { const p = new DOMPoint(x, y).matrixTransform(document.querySelector('svg.pieces')"
        ".getScreenCTM()); return [p.x, p.y]; }",
        [turned[0] + 300, turned[1]],
    )
    drag(matcher, middle, np.subtract(shown, middle).tolist())
    assert place_of(matcher, 0, "back")[2] == pytest.approx(90.0, abs=1.0)
    matcher.locator("#reset").click()
    assert place_of(matcher, 0, "back") == start
    assert read_pairs(matcher) == PROPOSED
    press(matcher, 0, "back", "Escape")


def drag(page, start, by) -> None:
    """Drag by mouse [px]."""
    page.mouse.move(*start)
    page.mouse.down()
    page.mouse.move(start[0] + by[0], start[1] + by[1], steps=4)
    page.mouse.up()


def test_m5_colours_show_the_pairs(matcher):
    """Broken where both pieces of a pair differ in colour or number, two pairs share one, or a lone piece has one."""
    read = "e => [getComputedStyle(e.querySelector('path')).stroke, e.querySelector('.number').textContent]"
    shown = {(row, n): piece(matcher, row, n).evaluate(read) for row in (0, 1) for n in ("front", "back")}
    assert shown[0, "front"] == shown[1, "front"] != shown[0, "back"] == shown[1, "back"]
    assert [shown[0, name][1] for name in ("front", "back")] == ["1", "2"]
    overlay = matcher.locator("#overlay .over").evaluate("e => getComputedStyle(e).stroke")
    assert overlay in (shown[0, "front"][0], shown[0, "back"][0])
    matcher.get_by_label("Counterpart of back").select_option("")
    assert piece(matcher, 0, "back").evaluate(read)[1] == piece(matcher, 1, "back").evaluate(read)[1] == ""
    assert piece(matcher, 0, "back").evaluate(read)[0] != shown[0, "back"][0]


@pytest.mark.nightly
def test_axe_finds_nothing_serious(matcher, find_barriers):
    """Broken where a piece has no name, or a text too little contrast."""
    assert find_barriers(matcher) == []


@pytest.mark.nightly
def test_two_jobs_are_compared(page, site):
    """Broken where a job's pattern is not found, or is not offered."""
    open_match(page, site.result, site.result)
    assert read_pairs(page) == PROPOSED
    assert page.locator(f'#a option[value="{site.result}"]').inner_text().startswith("tube (")


def test_what_cannot_be_compared_is_said(page, context):
    """Broken where a wrong address shows an empty page, or a name in it becomes a tag."""
    page.goto("/match?a=%3Cb%3Enosuch&b=skirt")
    page.wait_for_selector("#problem .error")
    assert "<b>nosuch" in page.locator("#problem").inner_text()
    context.faults.clear()  # the browser itself reports the answer 404
