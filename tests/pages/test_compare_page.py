"""Two results side by side: numbers with their differences, and views that turn together."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from garmentq.service.keys import create_key, grant_job
from garmentq.service.kinds.recover_request import PERSON
from garmentq.service.models import JobInputRow
from garmentq.service.pages.comparison import draw_comparison, format_difference
from garmentq.service.records import Gate
from person_jobs import keep_person
from shells import dress_in_shells


def make_job(metrics: dict[str, float | None], *gates: Gate) -> SimpleNamespace:
    """Return what a comparison reads of a job."""
    return SimpleNamespace(metrics=metrics, gates=gates)


def test_differences_have_signs():
    """Broken where a difference has the wrong sign, or two numbers that read the same differ by a rounding error."""
    assert format_difference(101.94, 104.46, ".1f") == "+2.5" and format_difference(104.4, 102.0, ".1f") == "−2.4"
    assert format_difference(10.04, 9.96, ".1f") == "=" and format_difference(None, 1.0, ".1f") == ""


def test_what_one_result_has_not_stays_empty():
    """Broken where a measure, check or metric that only one of two results has is left out, or ends the page."""
    one = make_job({"finished.chest_mm": 1020.0, "faces": 10.0}, Gate("seams", "pass", 0.1, 3.0, ""))
    other = make_job({"finished.chest_mm": 1045.0, "finished.hip_mm": None}, Gate("ends", "fail", 5.0, 4.0, ""))
    shown = str(draw_comparison(one, other))
    assert "102.0" in shown and "104.5" in shown and "+2.5" in shown and ">hip<" not in shown
    assert shown.index("Ends of sleeves and legs") < shown.index("1 passed") < shown.index("Lengths of seams")
    assert shown.count("not checked") == 2 and "1 metrics" in shown
    assert str(draw_comparison(make_job({}), make_job({}))) == '<div class="cards"></div>'


@pytest.fixture
def pair(site, whole_tube, tmp_path) -> tuple[str, str]:
    """Return two skirts of one person, the second of which is larger."""
    tube = whole_tube()
    nodes = 1.3 * tube.garment.nodes
    larger = replace(tube, meshes=replace(tube.meshes, detail=nodes))
    jobs = site.keep("first skirt"), site.keep("second skirt", larger)
    person = keep_person(site.services, tmp_path / "anna", dress_in_shells(1))
    with site.services.database.write() as session:
        for job in jobs:
            session.add(JobInputRow(job=job, name=PERSON, input=person))
    return jobs


def look_at(page) -> np.ndarray:
    """Return where the two cameras stand, each from what it looks at [m]."""
    page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    script = """() => document.querySelector('#compare').viewers.map((viewer) =>
        viewer.camera.position.clone().sub(viewer.controls.target).toArray())"""
    return np.array(page.evaluate(script))


def test_two_views_turn_together(page, site, pair, find_barriers):
    """Broken where a view does not follow the other, shows another scale, or a result cannot be chosen on its page."""
    page.goto(f"/results/{pair[0]}")
    page.get_by_role("link", name="Compare", exact=True).click()
    page.locator(f'.offered a[href$="{pair[1]}"]').click()
    page.locator("#compare[data-ready]").wait_for()
    assert page.locator("#compare h2").all_inner_texts() == ["First: Skirt · anna", "Second: Skirt · anna"]
    front = look_at(page)
    assert np.allclose(*front) and front[0, 2] > 0.0
    second = page.locator("canvas").nth(1)
    second.focus()
    second.press("ArrowLeft")
    turned = look_at(page)
    assert np.allclose(*turned) and not np.allclose(turned, front)
    page.locator("canvas").first.press("+")
    nearer = look_at(page)
    assert np.allclose(*nearer) and np.linalg.norm(nearer[0]) < np.linalg.norm(turned[0])
    page.get_by_role("button", name="Back", exact=True).click()
    back = look_at(page)
    assert np.allclose(*back) and np.allclose(back[0, 2], -front[0, 2])
    assert page.get_by_role("link", name="Compare the patterns").get_attribute("href").endswith(f"b={pair[1]}")
    page.set_viewport_size({"width": 390, "height": 844})
    assert np.allclose(*look_at(page)) and page.evaluate("document.documentElement.scrollWidth") <= 390
    for summary in page.locator("summary").all():
        summary.click()
    assert find_barriers(page) == []


def test_a_key_compares_only_its_own_results(own_site, chromium):
    """Broken where the page shows or offers a result of another key."""
    mine, foreign = own_site.result, own_site.keep("foreign")
    row, token = create_key(own_site.services.database, "studio", ("read",))
    with own_site.services.database.write() as session:
        grant_job(session, row.id, mine)
    with chromium.new_context(base_url=own_site.url) as opened:
        assert opened.request.post("/signin", form={"token": token}).ok
        offered = opened.request.get(f"/compare?a={mine}")
        assert offered.ok and foreign not in offered.text()
        for query in (f"a={mine}&b={foreign}", f"a={foreign}&b={mine}", f"a={foreign}", f"a={mine}&b=nosuchjob"):
            assert opened.request.get(f"/compare?{query}").status == 404
        assert opened.request.get(f"/compare?a={mine}&b={mine}").ok
        assert opened.request.get(f"/compare?a={'x' * 40}").status in (404, 422)
