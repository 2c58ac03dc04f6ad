"""The labels of a person's scan in a real browser: looked at, painted, filled, a ring moved, and run again with."""

from __future__ import annotations

import io
import re
import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.deliver.export.person import write_person
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.people.colours import COLOURS
from garmentq.core.people.part import PARTS, Part
from garmentq.core.people.person_input import PersonFiles, read_person_input
from garmentq.core.people.separate import expand_to_file
from garmentq.core.people.separation import LabelledPerson
from garmentq.core.scan.load_raw import load_raw
from garmentq.core.scan.raw import RawScan
from garmentq.service.jobs import claim, find_job
from garmentq.service.kinds import read_request
from garmentq.service.kinds.person import Person
from garmentq.service.kinds.person_found import PersonFound
from garmentq.service.kinds.person_request import PersonRequest
from garmentq.service.results import list_files, report_jobs, store_result
from garmentq.service.submission import Order, submit
from person_jobs import EXTRA, keep_person
from scipy.spatial import cKDTree
from shells import dress_in_shells, separate_by_truth

ROOT = "document.querySelector('#labels')"
KEYS = {part: str(n + 1) for n, part in enumerate(PARTS)}


@pytest.fixture(scope="module")
def shells():
    """Return a dressed person of 7000 points."""
    return dress_in_shells(0)


@pytest.fixture(scope="module")
def person(site, shells, tmp_path_factory) -> str:
    """Return the job that took it apart."""
    return keep_person(site.services, tmp_path_factory.mktemp("person") / "anna", shells)


@pytest.fixture(scope="module")
def window(open_window):
    """Open one window for the tests of this file."""
    with open_window() as opened:
        yield opened.new_page()


@pytest.fixture
def labels(window, person):
    """Return the page as it came: what the last test changed is taken back."""
    if not window.url.endswith(f"/results/{person}/labels"):
        open_labels(window, person)
    while window.locator("#undo").is_enabled():
        window.locator("#undo").click()
    return window


def open_labels(page, job: str) -> None:
    """Open the page and wait for the scan."""
    page.goto(f"/results/{job}/labels")
    page.wait_for_selector("#labels[data-ready]")


def read_labels(page) -> np.ndarray:
    """Return the label of each point as the page has it."""
    return np.array(page.evaluate(f"[...{ROOT}.painting.label]"))


def find_front(shells, part: Part, height: float) -> int:
    """Return the point of a part that lies nearest to a height in the middle of the front."""
    own = (shells.label == part) & (vertex_normals(shells.points, shells.faces)[:, 2] > 0.6)
    off = np.hypot(shells.points[:, 0], shells.points[:, 1] - height) + np.where(own, 0.0, 9.0)
    return int(off.argmin())


def where(page, point) -> tuple[float, float]:
    """Return where a point is on the screen [px]."""
    page.locator("#scene").scroll_into_view_if_needed()
    return tuple(page.evaluate(f"p => {ROOT}.view.viewer.project(p)", list(map(float, point))))


def press(page, *keys: str) -> None:
    """Press keys on the view."""
    page.locator("#scene canvas").focus()
    for key in keys:
        page.keyboard.press(key)


def test_parts_and_confidence_are_shown(labels, shells):
    """Broken where a point has another part's colour, counts are wrong, or confidence looks the same everywhere."""
    assert np.array_equal(read_labels(labels), shells.label)
    for part in (Part.SKIN, Part.UPPER, Part.HAIR):
        shown = labels.locator(f'[data-count="{int(part)}"]').inner_text()
        assert int(shown.replace(",", "")) == int((shells.label == part).sum())
    colour = np.array(labels.evaluate(COLOURS_OF)).reshape(-1, 3)
    for part in (Part.SKIN, Part.UPPER, Part.LOWER):
        srgb = np.array(COLOURS[part])
        light = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
        assert np.allclose(colour[shells.label == part], light, atol=1e-4)
    labels.get_by_label("confidence", exact=True).check()
    labels.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    colour = np.array(labels.evaluate(COLOURS_OF)).reshape(-1, 3)
    sure = np.abs(np.sin(8.0 * shells.points[:, 1]))
    assert np.corrcoef(colour[:, 1], sure)[0, 1] > 0.9
    labels.get_by_label("parts", exact=True).check()


COLOURS_OF = f"[...{ROOT}.view.object.geometry.attributes.color.array]"


def test_sides_are_shown_and_keys_work_without_the_view(labels):
    """Broken where a button shows another side of the wearer, whose left is +x, or a key needs the view's focus."""
    for place in (None, "#undo", "#part input", "#radius", "summary", "[data-view]"):
        labels.evaluate("place => place ? document.querySelector(place).focus() : document.activeElement.blur()", place)
        for key, tool in (("f", "fill"), ("o", "lasso"), ("b", "brush"), ("r", "ring"), ("f", "fill")):
            labels.keyboard.press(key)
            assert labels.locator(f'input[name="tool"][value="{tool}"]').is_checked(), (place, key)
        for part in (Part.UPPER, Part.SKIN):
            labels.keyboard.press(KEYS[part])
            assert labels.locator(f'input[name="part"][value="{int(part)}"]').is_checked(), (place, part)
    labels.keyboard.press("l")
    assert labels.locator("#unsure").inner_text().endswith("have a confidence of 0.5 or less.")
    offset = f"{ROOT}.view.viewer.camera.position.clone().sub({ROOT}.view.viewer.controls.target).normalize().toArray()"
    for name, way in (("Left", (1, 0, 0)), ("Back", (0, 0, -1)), ("Right", (-1, 0, 0)), ("Front", (0, 0, 1))):
        labels.get_by_role("group", name="View from").get_by_role("button", name=name).click()
        np.testing.assert_allclose(labels.evaluate(offset), way, atol=1e-6)


def test_a_brush_paints_what_it_reaches(labels, shells):
    """Broken where the brush paints another place, the back too, or more than its radius; or undo leaves a point."""
    vertex = find_front(shells, Part.UPPER, 1.25)
    press(labels, "b", KEYS[Part.LOWER])
    labels.locator("#radius").fill("60")
    x, y = where(labels, shells.points[vertex])
    labels.mouse.move(x, y)
    labels.mouse.down()
    labels.mouse.up()
    found = np.flatnonzero(read_labels(labels) != shells.label)
    away = np.linalg.norm(shells.points - shells.points[vertex], axis=1)
    facing = vertex_normals(shells.points, shells.faces) @ vertex_normals(shells.points, shells.faces)[vertex] > 0.0
    sure = np.flatnonzero((away < 0.05) & facing & (shells.label == Part.UPPER))
    assert set(sure) <= set(found) and away[found].max() < 0.07 and facing[found].all() and len(sure) >= 5
    labels.mouse.move(x, y)
    labels.mouse.down()
    labels.mouse.move(x + 30, y, steps=3)
    labels.mouse.up()
    assert (read_labels(labels) != shells.label).sum() > len(found)
    assert "points are changed" in labels.locator("#changed").inner_text()
    press(labels, "Control+z")
    assert np.array_equal(np.flatnonzero(read_labels(labels) != shells.label), found)
    press(labels, "Control+z")
    assert np.array_equal(read_labels(labels), shells.label)
    press(labels, "Control+y")
    assert np.array_equal(np.flatnonzero(read_labels(labels) != shells.label), found)


def test_a_fill_takes_what_hangs_together(labels, shells):
    """Broken where a fill runs over the border of a part, or leaves some of it; by keyboard, at the cross."""
    vertex = find_front(shells, Part.UPPER, 1.25)
    press(labels, "f", KEYS[Part.ONE_PIECE])
    labels.mouse.click(*where(labels, shells.points[vertex]))
    wanted = np.where(shells.label == Part.UPPER, Part.ONE_PIECE, shells.label)
    assert np.array_equal(read_labels(labels), wanted)
    assert "The filled points were upper and are now one-piece" in labels.locator("#said").inner_text()
    labels.locator("#undo").click()
    assert np.array_equal(read_labels(labels), shells.label)
    before = labels.evaluate(f"{ROOT}.view.pick({ROOT}.view.middle).vertex")
    press(labels, KEYS[Part.HAIR], "Space")
    assert read_labels(labels)[before] == Part.HAIR
    press(labels, "Control+z", "l")


def test_a_ring_moves_up_and_down(labels, shells):
    """Broken where another border moves, a way up and back changes a label, or a step is not 5 mm along the surface."""
    hem = shells.points[shells.label == Part.LOWER][:, 1].max()
    vertex = find_front(shells, Part.UPPER, hem)
    press(labels, "r")
    labels.mouse.click(*where(labels, shells.points[vertex]))
    assert "border of upper above and lower below" in labels.locator("#said").inner_text()
    for _ in range(4):
        labels.locator("#up").click()
    found = read_labels(labels)
    moved = np.flatnonzero(found != shells.label)
    assert len(moved) > 10 and set(shells.label[moved]) == {Part.UPPER} and set(found[moved]) == {Part.LOWER}
    assert "20 mm above where it was" in labels.locator("#said").inner_text()
    lower = shells.points[shells.label == Part.LOWER]
    nearest = np.linalg.norm(shells.points[moved][:, None] - lower[None], axis=2).min(axis=1)
    edge = np.linalg.norm(np.diff(shells.points[shells.faces[:, :2]], axis=1)[:, 0], axis=1)
    assert nearest.max() < 0.020 + np.quantile(edge, 0.99)
    press(labels, "PageDown", "PageDown", "PageDown", "PageDown")
    assert np.array_equal(read_labels(labels), shells.label)
    press(labels, "PageDown", "PageDown")
    assert set(shells.label[read_labels(labels) != shells.label]) <= {Part.LOWER}
    press(labels, "l")


def draw_outline(page, places) -> None:
    """Draw an outline through places on the screen, back to the first."""
    page.mouse.move(*places[0])
    page.mouse.down()
    for x, y in [*places[1:], places[0]]:
        page.mouse.move(x, y, steps=4)
    page.mouse.up()


def around(x: float, y: float, wide: float, high: float) -> list[tuple[float, float]]:
    """Return the corners of a rectangle around a place [px]."""
    return [(x - wide, y - high), (x + wide, y - high), (x + wide, y + high), (x - wide, y + high)]


def test_a_lasso_paints_what_is_seen_in_it(labels, shells):
    """Broken where a point outside the outline is painted, one inside is left, or one behind the surface is painted."""
    labels.get_by_role("button", name="Front").click()
    labels.evaluate("document.activeElement.blur()")
    for key in ("o", KEYS[Part.HAIR]):
        labels.keyboard.press(key)
    x, y = where(labels, shells.points[find_front(shells, Part.UPPER, 1.2)])
    draw_outline(labels, around(x, y, 25, 40))
    found = np.flatnonzero(read_labels(labels) != shells.label)
    screen = np.array(labels.evaluate(PLACES))
    inside = (np.abs(screen - (x, y)) < (24, 39)).all(axis=1)
    is_front = vertex_normals(shells.points, shells.faces)[:, 2] > 0.3
    outside = (np.abs(screen - (x, y)) > (26, 41)).any(axis=1)
    assert set(read_labels(labels)[found]) == {Part.HAIR} and not outside[found].any()
    assert (inside & ~is_front).sum() > 20, "the back is in the outline too"
    assert is_front[found].all() and len(found) > 20
    assert set(np.flatnonzero(inside & is_front & (shells.points[:, 2] > 0.0))) <= set(found)
    assert f"The {len(found)} visible points of the outline are hair." in labels.locator("#said").inner_text()
    labels.mouse.move(x - 200, y)
    labels.mouse.down()
    labels.mouse.up()
    assert "There is no point in the outline." in labels.locator("#said").inner_text()
    labels.locator("#undo").click()
    assert np.array_equal(read_labels(labels), shells.label)
    press(labels, "Space")
    assert "drawn with the pointer" in labels.locator("#said").inner_text()
    press(labels, "l")


PLACES = f"""(() => {{ const {{ positions }} = {ROOT}.painting.scan, found = [];
for (let n = 0; n < positions.length; n += 3) found.push({ROOT}.view.viewer.project([...positions.subarray(n, n + 3)]));
return found; }})()"""


def test_a_lasso_works_by_touch(open_window, person, shells):
    """Broken where a finger turns the view instead of drawing, or a second finger closes the outline."""
    with open_window(has_touch=True, is_mobile=True, viewport={"width": 390, "height": 844}) as opened:
        page = opened.new_page()
        open_labels(page, person)
        assert page.evaluate("document.documentElement.scrollWidth") <= 390
        page.locator('input[value="lasso"]').check()
        page.locator(f'input[name="part"][value="{int(Part.HAIR)}"]').check()
        x, y = where(page, shells.points[find_front(shells, Part.UPPER, 1.2)])
        fingers, places = opened.new_cdp_session(page), around(x, y, 15, 25)

        def touch(kind: str, *at: tuple[float, float]) -> None:
            points = [{"x": x, "y": y, "id": n} for n, (x, y) in enumerate(at)]
            fingers.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

        touch("touchStart", places[0])
        touch("touchMove", places[1])
        touch("touchStart", places[1], (x, y + 90))
        touch("touchEnd")
        assert np.array_equal(read_labels(page), shells.label)
        touch("touchStart", places[0])
        for place in (*places[1:], places[0]):
            touch("touchMove", place)
        touch("touchEnd")
        found = read_labels(page)
        assert (found != shells.label).sum() > 10 and set(found[found != shells.label]) == {Part.HAIR}


def test_labels_are_copied_to_the_other_side(labels, shells):
    """Broken where the copy is of another place than the mirrored one, the source changes, or undo leaves a point."""
    points, joints = shells.points, shells.body.joint
    left, right = (
        np.mean([joints(f"{side}_{at}") for at in ("hip", "shoulder")], axis=0) for side in ("left", "right")
    )
    normal = (left - right) / np.linalg.norm(left - right)
    away = (points - (left + right) / 2.0) @ normal
    nearest = cKDTree(points).query(points - 2.0 * away[:, None] * normal)[1]
    assert labels.locator("#mirror-last").is_disabled()
    press(labels, "b", KEYS[Part.HAIR])
    labels.locator("#radius").fill("50")
    aim = (shells.label == Part.UPPER) & (away > 0.06) & (vertex_normals(points, shells.faces)[:, 2] > 0.8)
    labels.mouse.click(*where(labels, points[np.flatnonzero(aim)[np.abs(points[aim][:, 1] - 1.2).argmin()]]))
    painted = read_labels(labels)
    own = painted != shells.label
    assert own.sum() >= 8 and (away[own] > 0.0).all()
    labels.locator("#mirror-last").click()
    found = read_labels(labels)
    copied = (found != shells.label) & ~own
    assert np.array_equal(found[own], painted[own]) and (away[copied] < 0.0).all()
    expected = own[nearest] & ~own & (shells.label != Part.HAIR)
    assert (copied == expected).mean() > 0.999 and copied.sum() >= 8
    labels.locator("#undo").click()
    assert np.array_equal(read_labels(labels), painted)
    labels.locator("#mirror-left").click()
    found = read_labels(labels)
    assert np.array_equal(found[away > 0.0], painted[away > 0.0])
    assert (found == painted[nearest])[away < -0.02].mean() > 0.99
    assert "points on the other side are changed" in labels.locator("#said").inner_text()
    labels.locator("#undo").click()
    labels.locator("#mirror-right").click()
    found = read_labels(labels)
    assert np.array_equal(found[away < 0.0], painted[away < 0.0]) and not (found[own] == Part.HAIR).any()
    press(labels, "Control+z", "Control+z", "l")
    assert np.array_equal(read_labels(labels), shells.label) and labels.locator("#mirror-last").is_disabled()


def test_unsure_points_are_counted_by_part(labels, shells):
    """Broken where a part's number is another one's, or painted points still count as unsure."""
    unsure = separate_by_truth(shells, EXTRA)[1].confidence[EXTRA:] <= 0.5
    shown = lambda part: labels.locator(f'[data-unsure="{int(part)}"]').inner_text().replace(",", "")  # noqa: E731
    for part in (Part.SKIN, Part.UPPER):
        assert shown(part) == f"{(unsure & (shells.label == part)).sum()} unsure"
    press(labels, "f", KEYS[Part.ONE_PIECE])
    labels.mouse.click(*where(labels, shells.points[find_front(shells, Part.UPPER, 1.25)]))
    assert shown(Part.UPPER) == shown(Part.ONE_PIECE) == ""
    rest = int((unsure & (shells.label != Part.UPPER)).sum())
    assert labels.locator("#unsure").inner_text().startswith(f"{rest:,} points")
    press(labels, "Control+z", "l")


def test_it_runs_again_as_a_new_job(labels, site, person, shells):
    """Broken where the old job's files change, the new one reads another scan or other labels, or points shift."""
    services = site.services
    kept = {file.name: file.sha256 for file in list_files(services.database, person)}
    press(labels, "f", KEYS[Part.ONE_PIECE])
    labels.mouse.click(*where(labels, shells.points[find_front(shells, Part.UPPER, 1.25)]))
    labels.get_by_role("button", name="Run again").click()
    link = labels.locator("#made a")
    link.wait_for()
    made = find_job(services.database, link.inner_text())
    old = find_job(services.database, person)
    assert (made.kind, made.state, made.scan, made.name) == ("person", "queued", old.scan, "anna") and made.id != person
    assert report_jobs(services.database, [made], services.settings)[0].tags == ["spring"]
    request, before = read_request(PersonRequest, made.request), read_request(PersonRequest, old.request)
    assert request == replace(before, labels=request.labels, given_as="person")
    with np.load(io.BytesIO(services.store.get_bytes(request.labels.sha256))) as arrays:
        given = arrays["label"]
        assert [str(arrays["names"][value]) for value in (0, 10, 12)] == ["skin", "upper", "one-piece"]
    assert set(given[:EXTRA]) == {Part.OTHER}
    assert np.array_equal(given[EXTRA:], np.where(shells.label == Part.UPPER, Part.ONE_PIECE, shells.label))
    assert {file.name: file.sha256 for file in list_files(services.database, person)} == kept
    labels.get_by_role("button", name="Run again").click()
    labels.get_by_text("There is a job with these labels").wait_for()
    assert labels.locator("#made a").inner_text() == made.id


@dataclass(frozen=True)
class Demo:
    """Describe the example's person, as `make demo` gives it, with labels by colour alone.

    Attributes:
        job: The job that took it apart.
        scan: The file.
        raw: What was read of it.
        label: What each of its points is shown as.
    """

    job: str
    scan: Path
    raw: RawScan
    label: np.ndarray


@pytest.fixture(scope="module")
def demo(site, tmp_path_factory) -> Demo:
    """Keep the shipped example as a person's job; its labels are right enough to be mended."""
    folder, examples = tmp_path_factory.mktemp("demo"), Path(__file__).parents[2] / "examples"
    scan, out = folder / "person.ply", folder / "out"
    subprocess.run(
        [sys.executable, examples / "remove_labels.py", examples / "data" / "person.ply", scan],
        check=True, capture_output=True,
    )  # fmt: skip
    raw = load_raw(scan)
    red, _, blue = raw.colours.T
    label, sure = expand_to_file(raw, np.where(blue > red, int(Part.UPPER), int(Part.SKIN)), np.ones(len(raw.points)))
    body = builtin_body("builtin:female,height=1.70")
    job = submit(site.services.database, site.services.store, Order(scan, None, given_as="person")).job
    out.mkdir()
    write_person(raw, LabelledPerson(body, label, sure, (), ()), out)
    (out / "person.json").write_text('{"garments": []}')
    held = claim(site.services.database, job, "test", 600.0)
    found = PersonFound(body, {"garments": [], "outfits": [], "parts": {}})
    store_result(site.services.database, site.services.store, held, Person(), found, out)
    return Demo(job, scan, raw, label[raw.origin])


def test_the_shipped_examples_labels_are_mended(page, site, demo, tmp_path):
    """Broken where a scan of which vertices are split, as nearly every scanner's, cannot be run again, or where the
    reader of the new job takes other labels than were painted."""
    assert len(demo.raw.points) > demo.raw.place.max() + 1, "the example has copies of split vertices"
    open_labels(page, demo.job)
    assert np.array_equal(read_labels(page), demo.label)
    press(page, "b", KEYS[Part.LOWER])
    page.locator("#radius").fill("80")
    box = page.locator("#scene canvas").bounding_box()
    page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    painted = read_labels(page)
    changed = painted != demo.label
    assert changed.sum() > 50
    page.get_by_role("button", name="Run again with these labels").click()
    link = page.locator("#made a")
    link.wait_for()
    made = find_job(site.services.database, link.inner_text())
    request = read_request(PersonRequest, made.request)
    assert (made.state, made.scan) == ("queued", find_job(site.services.database, demo.job).scan)
    labels = tmp_path / "labels.npz"
    labels.write_bytes(site.services.store.get_bytes(request.labels.sha256))
    given = read_person_input(PersonFiles(demo.scan, labels=labels))
    assert np.array_equal(given.label[demo.raw.origin[changed]], painted[changed])
    assert (given.label[demo.raw.origin] == painted).mean() > 0.999
    assert np.array_equal(given.label[demo.raw.place < 0], np.full((demo.raw.place < 0).sum(), int(Part.OTHER)))


@pytest.mark.nightly
def test_axe_finds_nothing_serious(labels, find_barriers):
    """Broken where a tool has no name, or a text too little contrast."""
    assert find_barriers(labels) == []


@pytest.mark.nightly
def test_a_cloud_is_painted_too(page, site, tmp_path):
    """Broken where a scan without faces cannot be picked, filled, or its rings not found."""
    shells = dress_in_shells(0)
    open_labels(page, keep_person(site.services, tmp_path / "cloud", shells, is_cloud=True))
    press(page, "f", KEYS[Part.ONE_PIECE])
    page.mouse.click(*where(page, shells.points[find_front(shells, Part.UPPER, 1.25)]))
    found = read_labels(page)
    assert (found[shells.label == Part.UPPER] == Part.ONE_PIECE).mean() > 0.95
    assert (found[shells.label != Part.UPPER] == shells.label[shells.label != Part.UPPER]).all()


def test_a_garments_job_has_no_labels(page, context, site):
    """Broken where the page of another kind of job is empty instead of saying so."""
    page.goto(f"/results/{site.result}/labels")
    assert "job 'recover'" in page.locator("main").inner_text()
    context.faults.clear()  # the browser itself reports the answer 422


def test_the_jobs_page_leads_there(page, person):
    """Broken where nobody finds the labels of a person."""
    page.goto(f"/jobs/{person}")
    assert page.get_by_role("link", name="Labels").get_attribute("href") == f"/results/{person}/labels"


def test_a_persons_result_shows_its_scan(page, person):
    """Broken where a person's page tells of a fabric that was not asked for, or hides the scan."""
    page.goto(f"/results/{person}")
    assert page.locator("input[data-mesh=scan]").is_checked()
    assert "Fabric" not in page.locator("h2").all_inner_texts()
    assert page.locator("a.button", has_text="Labels").get_attribute("href") == f"/results/{person}/labels"


def test_the_second_reading_is_taken_with_a_click(window, site, person):
    """Broken where the page hides what a person may wear besides, or its button queues another outfit or none."""
    window.goto(f"/jobs/{person}")
    worn = window.locator("#worn")
    assert "upper and lower" in worn.inner_text() and "73 %" in worn.inner_text()
    assert worn.get_by_role("button").count() == 1  # the third reading has less than one in fifty
    worn.get_by_role("button", name="Take it for one-piece (27 %)").click()
    window.wait_for_url(re.compile(f"/jobs/(?!{person})"))
    row = find_job(site.services.database, window.url.rsplit("/", 1)[1])
    assert read_request(PersonRequest, row.request).wearing == "one-piece"
