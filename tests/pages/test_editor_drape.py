"""What is edited is draped: the place in space under the pointer, what cannot be sewn, versions, and a real drape."""

from __future__ import annotations

import json

import httpx
import numpy as np
import pytest
import trimesh
from garmentq.core.pattern import load_draped_template, read_pattern
from garmentq.service.jobs import find_job
from garmentq.service.keys import admit, create_key
from garmentq.service.models import JobRow
from garmentq.service.query import JobQuery, find_jobs
from garmentq.service.submission import Order, submit
from garmentq.workers.recovery import run_job
from quick_edit import drape_at_once


@pytest.fixture
def quick(monkeypatch):
    """Let draping take no time."""
    drape_at_once(monkeypatch)


@pytest.fixture
def editor(page, shirt):
    """Open the editor of the T-shirt, and wait for its drape."""
    page.goto(f"/results/{shirt}/edit")
    page.locator(f"#draped[data-job='{shirt}']").wait_for()
    return page


def choose(page, *items: dict) -> None:
    """Select without the mouse, which other tests use."""
    page.evaluate("(items) => document.querySelector('#editor').session.select(items)", list(items))


def drape(page, site) -> str:
    """Press the button, work as a worker does, and wait for the version; gives its job."""
    page.click("#drape")
    page.locator("#draping progress").wait_for()
    (job,) = find_jobs(site.services.database, JobQuery({"state": "queued", "kind": "edit"}).conditions)
    with site.services.database.write() as session:  # before what other tests have queued here
        session.get(JobRow, job.id).priority = 1000
    run_job(site.settings, site.services.database, job.id, lambda: False)
    ended = find_job(site.services.database, job.id)
    assert ended.state == "succeeded", ended.error_message
    page.locator(f"#draped[data-job='{job.id}']").wait_for()
    return job.id


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


def test_what_cannot_be_sewn_is_shown_where_it_is(editor):
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


def test_versions_stand_beside_each_other(editor, site, shirt, quick):
    """Broken by a drape that gives no version, one that overwrites its predecessor, or one that does not open."""
    original = editor.request.get(f"/v1/jobs/{shirt}/artifacts/pattern.json").text()
    choose(editor, {"panel": "front", "point": 0})
    editor.locator("#board").focus()
    editor.keyboard.press("Shift+ArrowDown")
    editor.fill("#version-name", "longer")
    job = drape(editor, site)
    assert editor.locator("#verdicts tr").count() > 2
    assert editor.locator(f"#versions [data-version='{shirt}']").count() == 1
    assert "longer" in editor.inner_text(f"#versions [data-version='{job}']")
    assert {"cloth", "body", "before"} <= set(
        editor.evaluate("[...document.querySelectorAll('[data-layer]')].map((box) => box.dataset.layer)")
    )
    assert editor.request.get(f"/v1/jobs/{shirt}/artifacts/pattern.json").text() == original
    saved = read_pattern(editor.request.get(f"/v1/jobs/{job}/artifacts/pattern.json").body())
    assert saved.panel("front").points[0, 1] == pytest.approx(read_pattern(original).panel("front").points[0, 1] - 0.01)
    editor.click(f"#versions [data-version='{job}'] a")
    editor.locator(f"#draped[data-job='{job}']").wait_for()
    assert "front: up to 10.0 mm" in editor.inner_text("#differences")


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


def test_another_keys_pattern_is_not_shown(address, settings, database, store, tube_recovery, tmp_path):
    """Broken where a key that was not asked for a job opens its pattern, or a template that there is none of opens."""
    scan = trimesh.Trimesh(tube_recovery().scan.vertices, tube_recovery().scan.faces, process=False)
    scan.export(tmp_path / "scan.ply")
    (_, anna), (_, eve) = (create_key(database, name, ("read", "submit"), 10) for name in ("anna", "eve"))
    owner = admit(database, anna, "").key
    job = submit(database, store, Order(tmp_path / "scan.ply", "builtin:female", name="hers", key=owner, quota=1)).job
    for token, status in ((anna, 200), (eve, 404)):
        with httpx.Client(base_url=address, timeout=30.0) as visitor:
            visitor.post("/signin", data={"token": token, "next": "/"})
            assert visitor.get(f"/results/{job}/edit").status_code == status
            assert visitor.get("/templates/nosuch/edit").status_code == 404
    with httpx.Client(base_url=address, timeout=30.0) as stranger:
        assert stranger.get(f"/results/{job}/edit").headers["location"].startswith("/signin")
