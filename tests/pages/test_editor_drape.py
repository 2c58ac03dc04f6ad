"""What is edited is draped: the place in space under the pointer, what cannot be sewn, versions, and a real drape."""

from __future__ import annotations

import json
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest
from garmentq.core.garment.garmentcode import read_pattern
from garmentq.core.garment.seams import seam_mismatch
from garmentq.core.garment.templates import load_draped_template
from garmentq.core.recover.settings import RecoverySettings
from garmentq.service.jobs import find_job
from garmentq.service.keys import create_key, grant_job
from garmentq.service.models import JobRow
from garmentq.service.query import JobQuery, find_jobs
from garmentq.service.results import list_files, report_jobs
from garmentq.service.settings import ServiceSettings
from garmentq.service.submission import Order, submit
from garmentq.service.terms import JobTerms
from garmentq.service.versions import list_versions
from garmentq.workers.recovery import run_job
from quick_edit import drape_at_once

EXAMPLE = Path(__file__).parents[2] / "examples" / "data"


@pytest.fixture
def quick(monkeypatch):
    """Make draping take no time; the post that a tube hangs on has no girths to compare it with."""
    drape_at_once(monkeypatch)
    monkeypatch.setattr("garmentq.core.reuse.edit.redraping.measure_ease", lambda garment, body: ())


@pytest.fixture
def editor(page, shirt):
    """Open the editor of the T-shirt, and wait for its drape."""
    return open_editor(page, shirt)


def open_editor(page, job: str):
    """Open the editor of a result, wait for its drape, and give the page."""
    page.goto(f"/results/{job}/edit")
    page.locator(f"#draped[data-job='{job}']").wait_for()
    return page


def choose(page, *items: dict) -> None:
    """Select without the mouse, which other tests use."""
    page.evaluate("(items) => document.querySelector('#editor').session.select(items)", list(items))


def drape(page, site) -> str:
    """Press the button, work as a worker does, and wait for the version; gives its job."""
    page.click("#drape")
    page.locator("#draping progress").wait_for()
    (job,) = find_waiting(site)
    work(site, job)
    page.locator(f"#draped[data-job='{job}']").wait_for()
    return job


def find_waiting(site) -> list[str]:
    """Return the edits that wait for a worker."""
    found = find_jobs(site.services.database, JobQuery({"state": "queued", "kind": "edit"}).conditions)
    return [job.id for job in found]


def work(site, job: str, settings: ServiceSettings | None = None) -> None:
    """Do a job as a worker does, with the home's settings or others."""
    with site.services.database.write() as session:  # before what other tests have queued here
        session.get(JobRow, job).priority = 1000
    run_job(settings or site.settings, site.services.database, job, lambda: False)
    ended = find_job(site.services.database, job)
    assert ended.state == "succeeded", ended.error_message


def read_file(site, job: str, name: str) -> bytes:
    """Return the bytes of a result's file as they are stored."""
    (file,) = (file for file in list_files(site.services.database, job) if file.name == name)
    return site.services.store.get_bytes(file.sha256)


def test_a_place_on_the_board_is_marked_on_the_cloth(editor):
    """E2. Broken where the mark is further than one edge of the mesh from the cloth's true place, or stays behind."""
    garment = load_draped_template("tshirt")
    panel = [one.name for one in garment.pattern.panels].index("front")
    for seen in ((0.1, -0.3), (-0.15, -0.6)):
        place = editor.evaluate(
            """async ([x, y]) => {
                const { toBoard } = await import('/static/edit/layout.js');
                const [u, v] = toBoard(document.querySelector('#editor').session.placeOf('front'), [x, y]);
                const at = new DOMPoint(u, v).matrixTransform(document.querySelector('#board').getScreenCTM());
                return [at.x, at.y];
            }""",
            seen,
        )
        editor.mouse.move(*place)
        marked = np.array(json.loads(editor.locator("#draped").get_attribute("data-marked")))
        there = np.flatnonzero(garment.panel_of_uv == panel)
        near = there[np.linalg.norm(garment.uv[there] - seen, axis=1).argsort()[:3]]
        edge = np.linalg.norm(garment.uv[near] - seen, axis=1).max() + 0.002
        assert np.linalg.norm(garment.nodes[garment.uv_node[near[0]]] - marked) < 1.1 * edge + 0.002
    editor.mouse.move(5, 5)
    assert editor.locator("#draped").get_attribute("data-marked") == ""


def test_meshes_that_are_too_large_for_the_view_are_left_out(page, shirt, faults, monkeypatch):
    """Broken where a result whose scan and meshes the service does not pack cannot be edited."""
    monkeypatch.setattr("garmentq.service.pages.files_page.MAX_SHOWN_FILE_SIZE", 0)
    editor = open_editor(page, shirt)
    assert editor.locator("[data-layer]").count() == 0
    assert editor.locator("#drape").is_enabled() and not editor.locator("#draping .error").count()
    assert len(faults) == 2 and all("404" in one for one in faults), "the view and the scan"
    faults.clear()


def test_what_cannot_be_sewn_or_meshed_is_shown_where_it_is(editor, site):
    """Broken where a pattern that the service refuses is queued, or the edge that it names is not marked."""
    editor.uncheck("[data-option=sewn]")
    choose(editor, {"panel": "front", "point": 0})
    editor.fill("[data-option=step]", "8")
    editor.locator("#board").focus()
    editor.keyboard.press("Shift+ArrowDown")
    editor.click("#drape")
    editor.locator("#findings .bad button").first.click()
    assert "cannot be draped" in editor.inner_text("#draping")
    faults = editor.locator(".edge.fault")
    assert {faults.nth(k).get_attribute("data-edge") for k in range(faults.count())} >= {"0", "7"}
    assert "edge" in str(editor.evaluate("document.querySelector('#editor').session.selection"))
    editor.keyboard.press("Control+z")
    choose(editor, {"panel": "front", "point": 4})
    editor.fill("[data-option=step]", "90")
    editor.locator("#board").focus()
    editor.keyboard.press("Shift+ArrowDown")
    editor.click("#drape")
    editor.locator("#findings .bad", has_text="crosses itself").first.wait_for()
    assert editor.locator(".edge.fault[data-edge='8']").count() == 1, "the neck is drawn down across the hem"
    assert find_waiting(site) == []


@pytest.mark.nightly
def test_two_people_edit_one_result_at_once(open_window, own_site, quick):
    """Broken where a version is lost or overwrites another one, and where a key sees or changes what is another's."""
    site, database, first = own_site, own_site.services.database, own_site.result
    keys = {name: create_key(database, name, ("read", "submit")) for name in ("anna", "ben", "eve")}
    with database.write() as session:
        for name in ("anna", "ben"):
            grant_job(session, keys[name][0].id, first)
    original = read_file(site, first, "pattern.json")
    steps, made, seen = {"anna": -10.0, "ben": 20.0}, {}, {}
    with ExitStack() as stack:
        for name, step in steps.items():
            window = stack.enter_context(open_window(site, token=keys[name][1]))
            page = seen[name] = open_editor(window.new_page(), first)
            choose(page, {"panel": "front", "point": 0})
            page.fill("[data-option=step]", str(abs(step)))
            page.locator("#board").focus()
            page.keyboard.press("ArrowDown" if step < 0 else "ArrowUp")
            page.fill("#version-name", f"{name}'s")
        page.click("#drape")
        page.click("#cancel-drape")
        page.locator("#draping .error", has_text="cancelled").wait_for()
        stopped = page.locator("#draping .error a").get_attribute("href").removeprefix("/jobs/")
        for name, page in seen.items():
            page.click("#drape")
            page.locator("#draping progress").wait_for()
            (made[name],) = set(find_waiting(site)) - set(made.values())
        for job in made.values():
            work(site, job)
        for name, page in seen.items():
            mine, other = made[name], next(job for whose, job in made.items() if whose != name)
            page.locator(f"#draped[data-job='{mine}']").wait_for()
            assert page.locator("#verdicts tr").count() > 2
            assert f"from {first}" in page.inner_text(f"#versions [data-version='{mine}']")
            assert f"{name}'s" in page.inner_text(f"#versions [data-version='{mine}']")
            assert page.locator(f"#versions [data-version='{first}']").count() == 1
            assert page.locator(f"#versions [data-version='{other}']").count() == 0
            layers = "[...document.querySelectorAll('[data-layer]')].map((box) => box.dataset.layer)"
            assert set(page.evaluate(layers)) == {"cloth", "body", "scan", "before"}
            saved = read_pattern(page.request.get(f"/v1/jobs/{mine}/artifacts/pattern.json").body())
            was = read_pattern(original).panel("front").points[0, 1]
            assert saved.panel("front").points[0, 1] == pytest.approx(was + steps[name] * 1e-3)
        page = seen["anna"]
        page.click(f"#versions [data-version='{made['anna']}'] a")
        page.locator(f"#draped[data-job='{made['anna']}']").wait_for()
        assert "front: up to 10.0 mm" in page.inner_text("#differences")
        refuse_another(stack.enter_context(open_window(site, token=keys["eve"][1])), [first, *made.values()])
        refuse_another(page.context, [made["ben"]])
    assert read_file(site, first, "pattern.json") == original
    assert {row.job for row in list_versions(database, first)} == {first, stopped, *made.values()}


def refuse_another(window, jobs: list[str]) -> None:
    """Check that a window's key finds none of the jobs on any page, and can change none."""
    page = window.new_page()
    page.goto("/")
    for job in jobs:
        assert page.locator(f"[data-job='{job}']").count() == 0
        paths = (f"/results/{job}", f"/results/{job}/edit", f"/results/{job}/labels", f"/v1/jobs/{job}/versions",
                 f"/v1/jobs/{job}/artifacts/pattern.json", f"/v1/match?first={job}&second=skirt")  # fmt: skip
        assert {window.request.get(path).status for path in paths} == {404}
        send = "([path, body]) => import('/static/api.js').then((api) => api.postJson(path, body)).catch((e) => e.code)"
        order = {"kind": "export", "result": job, "options": {"format": "pdf"}}
        assert page.evaluate(send, ["/v1/jobs", order]) == "job.unknown"
        assert page.evaluate(send, [f"/v1/jobs/{job}/cancel", {}]) == "job.unknown"
    window.faults.clear()  # the browser itself reports the answers 404


@pytest.mark.nightly
def test_a_recovered_shirt_is_widened_draped_and_undone(page, site):
    """Broken where on a real recovery 20 mm in front and 20 mm behind do not make the draped hem 40 +- 2 mm longer,
    draping takes more than 15 s of CPU, a seam's sides differ by 1e-6 m, or undo leaves a trace."""
    scan, body = (EXAMPLE / f"{name}.ply" for name in ("garment", "body"))
    first = submit(
        site.services.database,
        site.services.store,
        Order(scan, body, settings=RecoverySettings(method="deform", vertex_count=1500), terms=JobTerms("recovered")),
    ).job
    work(site, first, ServiceSettings(home=site.settings.home))  # whose recovery is no stand-in
    editor = open_editor(page, first)
    text = page.evaluate(TEXT)
    assert text.encode() == read_file(site, first, "pattern.json")
    pattern = read_pattern(text)
    editor.uncheck("[data-option=align]")
    editor.fill("[data-option=step]", "10")
    for name in ("front", "back"):
        x, y = pattern.panel(name).points.T
        corner = np.where(y < y.min() + 0.03, x, -np.inf).argmax()
        choose(editor, {"panel": name, "point": int(corner)})
        editor.locator("#board").focus()
        editor.keyboard.press("ArrowRight")
    assert editor.inner_text("#seams-summary") == "Both sides of every seam are equally long."
    job = drape(editor, site)
    metrics = json.loads(read_file(site, job, "metrics.json"))
    assert metrics["contour_change.hem_mm"] == pytest.approx(40.0, abs=2.0)
    assert seam_mismatch(read_pattern(read_file(site, job, "pattern.json"))) < 1e-6
    services = site.services
    (ended,) = report_jobs(services.database, [find_job(services.database, job)], services.settings)
    assert ended.cpu_seconds is not None and ended.cpu_seconds < 15.0
    while editor.locator("[data-command=undo]").is_enabled():
        editor.locator("#board").focus()
        editor.keyboard.press("Control+z")
    assert page.evaluate(TEXT) == text
    assert read_file(site, first, "pattern.json").decode() == text


TEXT = """async () => {
    const { writePattern } = await import('/static/edit/pattern_model.js');
    return writePattern(document.querySelector('#editor').session.present);
}"""
"""What a download would have."""


@pytest.mark.nightly
def test_a_shirt_widened_at_the_hem_is_draped_wider(editor, site):
    """Broken where 20 mm in front and 20 mm behind do not make the draped hem 40 +- 2 mm longer."""
    editor.fill("[data-option=step]", "10")
    for item in ({"panel": "front", "point": 0}, {"panel": "back", "point": 1}):
        choose(editor, item)
        editor.locator("#board").focus()
        editor.keyboard.press("ArrowRight")
    job = drape(editor, site)
    metrics = json.loads(editor.request.get(f"/v1/jobs/{job}/artifacts/metrics.json").text())
    assert metrics["contour_change.hem_mm"] == pytest.approx(40.0, abs=2.0)
    assert metrics["seam_mismatch_mm"] < 1e-3
