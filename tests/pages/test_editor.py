"""The editor, by mouse and by keyboard, on the stored result of a T-shirt: each feature fails without what makes it."""

from __future__ import annotations

import json

import numpy as np
import pytest
from editor_page import Editor, lengths, moved
from garmentq.core.garment.garmentcode import read_pattern
from garmentq.core.garment.seams import seam_mismatch
from garmentq.core.garment.symmetry import find_symmetry
from garmentq.core.garment.templates import load_template

MM = 1e-3


@pytest.fixture(scope="module")
def opened(open_window, shirt):
    """Open the editor once; no test leaves the page."""
    with open_window() as context:
        page = context.new_page()
        page.goto(f"/results/{shirt}/edit")
        page.locator("#said", has_text="Ready.").wait_for()
        yield page


@pytest.fixture
def editor(opened):
    """Return the editor as it opens, whatever the test before did."""
    opened.evaluate(
        """async () => {
            const { session } = document.querySelector('#editor');
            session.start(session.opened ??= session.original);
            for (const box of document.querySelectorAll('input[type=checkbox][data-option]')) {
                if (box.checked !== box.defaultChecked) box.click();
            }
            for (const box of document.querySelectorAll('input[type=number][data-option]')) {
                if (box.value === box.defaultValue) continue;
                box.value = box.defaultValue;
                box.dispatchEvent(new Event('change'));
            }
            document.querySelector('[data-tool=select]').click();
            session.tell('fit');
            await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
        }"""
    )
    return Editor(opened)


def test_a_template_is_opened_changed_and_saved(editor, site):
    """E1. Broken by a template that does not open, or is saved as what core does not read or as what it was before."""
    page = editor.page.context.new_page()
    page.goto("/templates/skirt/edit")
    page.locator("#said", has_text="Ready.").wait_for()
    page.locator("#board").focus()
    page.keyboard.press("n")
    page.keyboard.press("Shift+ArrowDown")
    with page.expect_download() as downloaded:
        page.click("#download")
    page.fill("#template-name", "longer")
    page.click("#save-template")
    page.wait_for_selector("#saved a[href='/templates/longer/edit']")
    saved = read_pattern(page.request.get("/v1/templates/longer").body())
    first = saved.panels[0].name
    assert saved.panel(first).points[0, 1] == pytest.approx(load_template("skirt").panel(first).points[0, 1] - 10 * MM)
    file = read_pattern(downloaded.value.path().read_bytes())
    assert moved(saved, file) == {} and downloaded.value.suggested_filename == "skirt.json"
    page.close()


def test_panels_are_moved_and_turned_on_the_board_alone(editor):
    """E3. Broken by a move or turn of a panel that changes a number of its geometry, or that undo leaves traces of."""
    before, text = editor.file(), editor.text()
    x, y = (np.array(editor.place("front", 0)) + editor.place("front", 8)) / 2 + [0.0, -60.0]
    old = editor.place("front", 0)
    editor.drag((x, y), (40, 25))
    assert np.subtract(editor.place("front", 0), old) == pytest.approx([40, 25], abs=0.1)
    editor.press("]", "ArrowLeft")
    after = editor.file()
    assert after["pattern"] == before["pattern"]
    place = after["properties"]["garmentq"].pop("layout")["front"]
    assert place["turn"] == pytest.approx(-np.pi / 36) and after["properties"] == before["properties"]
    editor.press("Control+z", "Control+z", "Control+z")
    assert editor.text() == text


def test_points_are_selected_by_click_shift_box_and_keys(editor):
    """E4. Broken by Shift that does not add or take away, by a box that misses, or by dead keys."""
    editor.choose("front", 4)
    assert editor.selection() == [{"panel": "front", "point": 4}]
    editor.choose("front", 4, 2, 6, 2)
    assert editor.selection() == [{"panel": "front", "point": 4}, {"panel": "front", "point": 6}]
    (left, _), (right, low) = editor.place("front", 8), editor.place("front", 0)
    editor.drag((min(left, right) - 6, low + 8), (abs(right - left) + 12, -16))
    assert sorted(item["point"] for item in editor.selection() if item["panel"] == "front") == [0, 8]
    editor.press("Escape", "n", "n", "Shift+n")
    assert editor.selection() == [{"panel": "back", "point": 1}, {"panel": "back", "point": 2}]
    editor.press("d", "h")
    assert editor.selection() == [{"panel": "back", "edge": 2, "handle": 0}]


def test_a_point_moves_by_exactly_what_is_asked_and_others_follow(editor):
    """E5. Broken by a point beside its place by 1e-9 m, an image that stays, or seams unequal by more than 1e-6 m."""
    before = editor.pattern()
    text = editor.text()
    start, scale = editor.place("front", 2), editor.scale()
    editor.drag(start, (12, -9), keys="Alt")
    after = editor.pattern()
    ways = moved(before, after)
    step = np.array([12, 9]) * scale * MM
    assert ways["front", 2] == pytest.approx(step, abs=1e-9)
    assert ways["front", 6] == pytest.approx(step * [-1, 1], abs=1e-9)
    assert {"back", "sleeve_front_left", "sleeve_front_right"} <= {panel for panel, _ in ways}
    assert seam_mismatch(after) < 1e-6
    editor.press("Control+z")
    assert editor.text() == text
    editor.choose("front", 2)
    editor.page.fill("[data-option=step]", "2.5")
    editor.press("ArrowUp", "Shift+ArrowRight")
    assert moved(before, editor.pattern())["front", 2] == pytest.approx([25 * MM, 2.5 * MM], abs=1e-9)
    assert seam_mismatch(editor.pattern()) < 1e-6
    editor.page.uncheck("[data-option=symmetric]")
    editor.page.uncheck("[data-option=sewn]")
    x, y = editor.place("front", 2)
    editor.page.mouse.move(x, y)
    editor.page.mouse.down()
    editor.page.mouse.move(x + 20, y - 20)
    editor.page.locator("#seams-summary.bad").wait_for()  # while the point is still held
    worst = max(map(float, editor.page.eval_on_selector_all("#seams tr", "rows => rows.map(r => r.dataset.mismatch)")))
    editor.page.mouse.up()
    assert seam_mismatch(editor.pattern()) == pytest.approx(worst, abs=1e-9) and worst > 1 * MM
    assert editor.page.locator("#seams tr.apart").count() > 0


def test_what_lies_between_two_points_is_straightened(editor):
    """E6. Broken where an edge between the points stays a curve, or where a point between them leaves the line."""
    editor.choose("front", 1, 2)
    editor.command("straighten")
    kinds = [edge.kind for edge in editor.pattern().panel("front").edges]
    assert kinds[1] == "line" and kinds[6] == "line" and kinds[3] == "cubic"
    editor.choose("front", 3, 5)
    editor.press("s")
    panel = editor.pattern().panel("front")
    assert [edge.kind for edge in panel.edges[3:5]] == ["line", "line"]
    assert panel.points[4, 1] == pytest.approx(panel.points[3, 1], abs=1e-9)
    assert seam_mismatch(editor.pattern()) < 1e-6


def test_a_corner_becomes_a_curve_and_a_corner_again(editor):
    """Broken where the outline still turns at a smooth point, or where the way back leaves curves of straight edges."""
    turn = "turnAt(session.present.panels.find(({ name }) => name === 'front'), 0)"
    assert editor.module("curve_operations", turn) == pytest.approx(np.pi / 2)
    editor.choose("front", 0)
    editor.command("smooth")
    assert editor.module("curve_operations", turn) < 1e-9
    editor.press("k")
    assert editor.module("curve_operations", turn) > 1.0
    assert [editor.pattern().panel("front").edges[k].kind for k in (0, 8)] == ["line", "line"]


def test_control_points_are_added_and_removed_in_the_layer_of_possible_ones(editor):
    """E7. Broken by a length that changes by 1e-6 m, by a partner or image that is not cut, or by no way back."""
    before = editor.pattern()
    editor.page.check("[data-option=possible]")
    editor.settle()
    spot = editor.page.evaluate(
        """() => {
            const dot = document.querySelector('[data-panel="front"] .possible[data-edge="1"]');
            const at = new DOMPoint(...dot.getAttribute('d').split('M')[4].match(/-?[0-9.]+/g).map(Number).slice(0, 2));
            const seen = at.matrixTransform(dot.getScreenCTM());
            return [seen.x, seen.y];
        }"""
    )
    editor.page.mouse.click(*spot)
    added = editor.pattern()
    assert [len(panel.points) for panel in added.panels] == [9, 11, 4, 4, 5, 5]
    assert lengths(added) == pytest.approx(lengths(before), abs=1e-6)
    assert seam_mismatch(added) < 1e-6 and editor.selection() == [{"panel": "front", "point": 2}]
    editor.press("Delete")
    again = editor.pattern()
    assert moved(before, again) == {} and len(again.seams) == len(before.seams)
    assert lengths(again) == pytest.approx(lengths(before), abs=1e-9)
    editor.choose("front", 0)
    editor.press("Delete")
    assert "seams begin or end" in editor.page.inner_text("#said.bad")


def test_colours_are_those_of_the_symmetry_that_core_finds(editor):
    """E8, E9. Broken where panels or points of one colour are no images of each other, or the reverse."""
    editor.page.check("[data-option=between]")
    editor.page.check("[data-option=within]")
    editor.settle()
    colours, images = editor.page.evaluate(
        """() => {
            const panel = (element) => element.parentNode.dataset.panel, look = (element) => getComputedStyle(element);
            const cloths = [...document.querySelectorAll('.cloth[data-mirror]')];
            const dots = [...document.querySelectorAll('[data-image]')];
            return [
                cloths.map((path) => [panel(path), path.dataset.mirror, look(path).fill]),
                dots.map((dot) => [panel(dot), Number(dot.dataset.point), Number(dot.dataset.image), look(dot).stroke]),
            ];
        }"""
    )
    pattern = editor.pattern()
    names = [panel.name for panel in pattern.panels]
    mirrors = find_symmetry(pattern).mirrors
    pairs = {(names[m.source], names[m.target]) for m in mirrors if m.source != m.target}
    assert {(a, b) for a, b, _ in colours} == pairs | {(b, a) for a, b in pairs}
    fills = {panel: fill for panel, _, fill in colours}
    assert all(fills[a] == fills[b] for a, b in pairs) and len(set(fills.values())) == len(pairs)
    own = {(names[m.source], j, int(i)) for m in mirrors if m.source == m.target for j, i in enumerate(m.order)}
    assert {(panel, point, image) for panel, point, image, _ in images} == own
    strokes = {(panel, point): stroke for panel, point, _, stroke in images}
    assert all(strokes[panel, j] == strokes[panel, i] for panel, j, i in own)
    assert len({strokes["front", k] for k in range(5)}) == 5
    editor.page.uncheck("[data-option=within]")
    editor.settle()
    assert editor.page.locator("[data-image]").count() == 0


def test_a_panel_is_cut_along_a_line_and_joined_again(editor):
    """E10. Broken by halves that do not make up the panel, by no seam between them, or by another outline after it."""
    before = editor.pattern()
    (x, _), (_, neck) = editor.place("front", 4), editor.place("front", 3)
    bottom = editor.place("front", 0)[1]
    editor.page.click("[data-tool=cut]")
    editor.drag((x, neck - 10), (0.0, bottom - neck + 20))
    cut = editor.pattern()
    assert len(cut.panels) == 7 and len(cut.seams) == len(before.seams) + 1 and seam_mismatch(cut) < 1e-6
    assert lengths(cut)[1] == pytest.approx(lengths(cut)[2], abs=1e-9)  # cut in the middle
    mirrors = find_symmetry(cut).mirrors
    assert ("front_1", "front_2") in {(cut.panels[m.source].name, cut.panels[m.target].name) for m in mirrors}
    seam = cut.seams[-1].a
    side = json.dumps({"panel": seam.panel, "edge": seam.edge})
    editor.page.evaluate(f"document.querySelector('#editor').session.select([{side}])")
    editor.command("join")
    joined = editor.pattern()
    assert len(joined.panels) == 6 and len(joined.seams) == len(before.seams)
    assert lengths(joined)[1] == pytest.approx(lengths(before)[1], abs=1e-9)
    editor.press("Control+z", "Control+z")
    editor.page.click("[data-tool=select]")
    editor.choose("front", 1, 7)
    editor.press("x")
    assert len(editor.pattern().panels) == 7


def test_snapping_ruler_allowance_and_difference(editor):
    """Broken by a point off the grid, a wrong distance, an allowance of another width, or no difference."""
    page = editor.page
    page.fill("[data-option=grid]", "5")
    page.press("[data-option=grid]", "Tab")
    start = editor.place("front", 2)
    editor.drag(start, (17, 31))
    x, y = editor.pattern().panel("front").points[2] / MM
    others = np.delete(editor.pattern().panel("front").points, 2, axis=0) / MM
    for value, axis in ((x, 0), (y, 1)):
        assert min(abs(value - 5 * round(value / 5)), np.abs(others[:, axis] - value).min()) < 1e-6
    page.fill("[data-option=allowance]", "12")
    page.press("[data-option=allowance]", "Tab")
    page.check("[data-option=difference]")
    editor.settle()
    assert page.locator('[data-panel="front"] .allowance').get_attribute("stroke-width") == "24"
    assert page.locator('[data-panel="front"] .before').count() == 1
    assert "front: up to" in page.inner_text("#differences")
    page.click("[data-tool=ruler]")
    ends = np.array([editor.place("front", 0), editor.place("front", 8)])
    page.mouse.move(*ends[0])
    page.mouse.down()
    page.mouse.move(*ends[1])
    editor.settle()
    told = float(page.inner_text("#said").split()[0])
    page.mouse.up()
    width = np.ptp(editor.pattern().panel("front").points[[0, 8], 0]) / MM
    assert told == pytest.approx(width, abs=2 * editor.scale())


@pytest.mark.nightly
def test_axe_finds_nothing_serious(editor, find_barriers):
    """Broken where a command has no name, or a text too little contrast; with every layer, and something selected."""
    for name in ("possible", "between", "within", "difference"):
        editor.page.check(f"[data-option={name}]")
    editor.press("n")
    editor.page.locator("summary", has_text="Shortcuts").click()
    assert find_barriers(editor.page) == []


@pytest.mark.nightly
def test_fingers_drag_pan_and_zoom_on_a_telephone(open_window, shirt):
    """Broken where a finger scrolls the page instead, moves a point elsewhere, or two fingers do not zoom; or where
    the page is wider than 390 px."""
    screen = {"width": 390, "height": 844}
    with open_window(viewport=screen, has_touch=True, is_mobile=True, device_scale_factor=2) as context:
        page = context.new_page()
        page.goto(f"/results/{shirt}/edit")
        page.locator("#said", has_text="Ready.").wait_for()
        assert page.evaluate("document.documentElement.scrollWidth") <= screen["width"]
        page.uncheck("[data-option=align]")
        editor, touch = Editor(page), context.new_cdp_session(page)
        page.locator("#board").scroll_into_view_if_needed()

        def put(kind: str, *fingers: tuple[float, float]) -> None:
            points = [{"x": x, "y": y, "id": number} for number, (x, y) in enumerate(fingers)]
            touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

        before, scale, (x, y) = editor.pattern(), editor.scale(), editor.place("front", 2)
        top = page.evaluate("scrollY")
        put("touchStart", (x, y))
        for step in (4, 8, 12):
            put("touchMove", (x + step, y - step / 2))
        put("touchEnd")
        editor.settle()
        ways = moved(before, editor.pattern())
        assert ways["front", 2] == pytest.approx(np.array([12, 6]) * scale * MM, abs=0.5 * scale * MM)
        assert seam_mismatch(editor.pattern()) < 1e-6 and page.evaluate("scrollY") == top
        box = page.locator("#board").bounding_box()
        corner, start = np.array([box["x"] + 8, box["y"] + 8]), editor.place("front", 2)
        put("touchStart", tuple(corner))
        put("touchMove", tuple(corner + [20, 30]))
        put("touchMove", tuple(corner + [40, 60]))
        put("touchEnd")
        assert np.subtract(editor.place("front", 2), start) == pytest.approx([40, 60], abs=1.0)
        middle = np.array([box["x"] + box["width"] / 2, box["y"] + box["height"] / 2])
        apart = [(middle - [half, 0], middle + [half, 0]) for half in (30.0, 45.0, 60.0)]
        put("touchStart", tuple(apart[0][0]), tuple(apart[0][1]))
        for fingers in apart[1:]:
            put("touchMove", *map(tuple, fingers))
        put("touchEnd")
        editor.settle()
        assert editor.scale() == pytest.approx(scale / 2, rel=0.02)
        page.locator('[data-command="undo"]').tap()
        page.locator('[data-command="undo"]:disabled').wait_for()  # a tap clicks a moment later
        assert moved(before, editor.pattern()) == {}


def test_keys_alone_do_all_and_undo_gives_the_identical_file(editor):
    """Broken by a command without a key or a name, or by an undo that leaves a trace."""
    text = editor.text()
    editor.press("n", "ArrowUp", "c", "k", "Shift+n", "s", "d", "a", "Delete", "g", "]", "ArrowRight", "e")
    assert editor.text() != text
    editor.press("g", *["n"] * 2, "Shift+n", "Shift+n", "Shift+n", "x")
    while not editor.page.is_disabled("[data-command=undo]"):
        editor.press("Control+z")
        editor.settle()
    assert editor.text() == text
    editor.press("Control+y")
    assert editor.text() != text
    names = "[...document.querySelectorAll('#editor button')].map((button) => button.textContent.trim())"
    assert all(editor.page.evaluate(names))
    shortcuts = editor.page.locator("#shortcuts dt").count()
    assert shortcuts == editor.page.locator("#commands button[data-command]").count() + 1
