"""The list of jobs and the page of one, in a real browser."""

from __future__ import annotations

import re

import httpx
import pytest
from api_work import make_ply
from garmentq.service.jobs import claim, fail, find_job
from garmentq.service.keys import create_key, own
from garmentq.service.pages import jobs_page
from garmentq.service.progress import report
from garmentq.service.records import Progress
from garmentq.service.states import State
from garmentq.service.understanding import note_checked

HOSTILE = '"><script>alert(1)</script><img src=x onerror=alert(2)>'


@pytest.fixture
def held(site):
    """Give a function that queues a job under a name and claims it, as a worker does."""

    def take(name: str):
        return claim(site.services.database, site.queue(name), "test", 600.0)

    return take


def test_a_dropped_scan_becomes_a_job(page, site, tmp_path):
    """Broken where the form, the upload or an option does not reach the job."""
    scan = tmp_path / "skirt.ply"
    scan.write_bytes(make_ply())
    page.goto("/")
    page.set_input_files("#scan", scan)
    assert "skirt.ply" in page.locator("#told").inner_text()
    page.get_by_text("Options").click()
    page.get_by_label("Name", exact=True).first.fill("Anna's skirt")
    page.get_by_label("Tags").fill("spring, fitting")
    page.get_by_label("Body", exact=True).fill("builtin:female,height=1.70")
    page.get_by_label("Method").select_option("deform")
    page.get_by_role("button", name="Queue the job").click()
    page.wait_for_url("**/jobs/*")
    row = find_job(site.services.database, page.url.rsplit("/", 1)[1])
    assert (row.name, row.state) == ("Anna's skirt", State.QUEUED)
    assert row.request["body"] == "builtin:female,height=1.70" and row.request["settings"]["method"] == "deform"
    assert page.locator(".tag").all_inner_texts() == ["fitting", "spring"]
    page.get_by_role("button", name="Cancel").click()
    page.get_by_role("button", name="Try again").wait_for()
    assert find_job(site.services.database, row.id).state == State.CANCELLED
    page.get_by_role("button", name="Try again").press("Enter")
    page.get_by_role("button", name="Cancel").wait_for()
    assert find_job(site.services.database, row.id).state == State.QUEUED


def test_a_refused_order_says_why(page, faults, tmp_path):
    """Broken where a mistake is lost, or the form cannot be sent again."""
    scan = tmp_path / "skirt.ply"
    scan.write_bytes(make_ply())
    page.goto("/")
    page.set_input_files("#scan", scan)
    page.get_by_text("Options").click()
    page.get_by_label("Template").fill("no-such-template")
    page.get_by_role("button", name="Queue the job").click()
    assert "no-such-template" in page.locator("#problem [role=alert]").inner_text()
    assert page.get_by_role("button", name="Queue the job").is_enabled()
    assert "404" in faults.pop()  # the browser itself reports the refusal on its console


def test_a_job_is_followed_live(page, site, held):
    """Broken where progress, what was understood, or the end does not come by itself."""
    claimed = held("live")
    page.goto(f"/jobs/{claimed.job}")
    report(site.services.database, claimed, Progress("check", 0.5, "reading"))
    page.get_by_text("check: reading").wait_for()
    note_checked(site.services.database, claimed, {"as": "garment", "vertices": 1234})
    report(site.services.database, claimed, Progress("drape", 0.25, "step 3", 0.6, 42.0))
    page.get_by_text("drape: step 3, about 42 s to go").wait_for()
    page.get_by_text("vertices: 1234").wait_for()
    assert page.locator("#progress").evaluate("(bar) => bar.value") == 0.6
    fail(site.services.database, claimed, "scan.truncated", "The file is cut off; export it again.", True)
    page.get_by_role("alert").filter(has_text="cut off").wait_for()
    page.get_by_role("button", name="Try again").wait_for()


def test_the_list_lives_and_is_found_by_filters(page, site, held):
    """Broken where a running job stands still in the list, or a filter of `query` finds others."""
    claimed = held("find-me")
    page.goto("/?name=find-me")
    assert page.locator("tr.job").count() == 1
    report(site.services.database, claimed, Progress("drape", 0.5, ""))
    page.get_by_text("running: drape 50%").wait_for()
    fail(site.services.database, claimed, "scan.truncated", "The file is cut off.", True)
    page.get_by_text("The file is cut off.").wait_for()
    page.goto("/?name=find-me&state=succeeded")
    assert page.locator("tr.job").count() == 0
    page.goto("/?where=" + "surface_rms_mm.t2s < 1000")
    names = page.locator("tr.job a:not(.plain)").all_inner_texts()
    assert "tube" in names and "find-me" not in names
    small = page.locator(f'tr[data-job="{site.result}"] img')
    assert small.evaluate("(image) => image.decode().then(() => image.naturalWidth)") > 50


def test_hostile_names_are_text(page, site, held, faults):
    """Broken where a name becomes a tag on a page."""
    claimed = held(HOSTILE[:200])
    fail(site.services.database, claimed, "scan.truncated", HOSTILE, True)
    for path in ("/?name=" + HOSTILE.replace("&", "%26"), f"/jobs/{claimed.job}", f"/results/{claimed.job}"):
        answer = page.goto(path)
        assert "<script>alert" not in answer.text()
        assert page.locator("img[src=x]").count() == 0
    assert "404" in faults.pop()  # the last has no result


def test_another_key_sees_and_changes_nothing(chromium, own_site):
    """Broken where a page shows a job of another key, or a button of one works on it."""
    site, database = own_site, own_site.services.database
    queued = site.queue("hers")
    (hers, her_token), (_, his_token) = (create_key(database, name, ("read", "submit")) for name in ("hers", "his"))
    with database.write() as session:
        own(session, hers.id, queued)
        own(session, hers.id, site.result)
    for token, is_hers in ((his_token, False), (her_token, True)):
        with chromium.new_context(base_url=site.url) as opened:
            assert opened.request.post("/signin", form={"token": token}).ok
            page = opened.new_page()
            page.goto("/")
            assert page.locator("tr.job").count() == (2 if is_hers else 0)
            pages = (f"/jobs/{site.result}", f"/results/{site.result}", f"/results/{site.result}/report",
                     f"/results/{site.result}/pictures/0", f"/jobs/{site.result}/thumbnail")  # fmt: skip
            assert {opened.request.get(path).status for path in pages} == ({200} if is_hers else {404})
            asked = "import('/static/api.js').then((api) => api.postJson('/v1/jobs/JOB/cancel')).catch((e) => e.code)"
            told = page.evaluate(asked.replace("JOB", queued))
            assert told == ({"job": queued, "state": "cancelled"} if is_hers else "job.unknown")


def test_who_may_only_read_is_offered_no_change(own_site):
    """Broken where a page offers what the key may not, or a job of 10 000 is not to be reached page by page."""
    site = own_site
    row, token = create_key(site.services.database, "reader", ("read",))
    with site.services.database.write() as session:
        own(session, row.id, site.result)
    with httpx.Client(base_url=site.url) as client:
        assert client.post("/signin", data={"token": token}).status_code == 303
        listed, result = client.get("/").text, client.get(f"/results/{site.result}").text
        assert 'id="submit"' not in listed and "tube" in listed
        assert "data-export" not in result and "/edit" not in result


def test_pages_of_the_list_follow_each_other(own_site, monkeypatch):
    """Broken where a job is left out or shown twice at the turn of a page, or a child stands without its parent."""
    site = own_site
    monkeypatch.setattr(jobs_page, "ROWS", 2)
    made = [site.queue(f"job {n}") for n in range(4)]
    with httpx.Client(base_url=site.url) as client:
        client.post("/signin", data={"token": site.token})
        url, seen = "/", []
        while url:
            text = client.get(url).text
            seen += re.findall(r'data-job="([0-9a-f]+)"', text)
            found = re.search(r'rel="next" href="([^"]+)"', text)
            url = found and found[1].replace("&amp;", "&")
    assert seen == [*reversed(made), site.result]
