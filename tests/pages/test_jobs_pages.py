"""The list of jobs and the page of one, in a real browser."""

from __future__ import annotations

import base64
import re

import httpx
import pytest
from api_work import make_ply
from garmentq.core.recover.settings import QUALITIES, RecoverySettings
from garmentq.service import inspection
from garmentq.service.jobs import claim, fail, find_job
from garmentq.service.keys import create_key, grant_job
from garmentq.service.pages import jobs_page
from garmentq.service.progress import report
from garmentq.service.records import Progress
from garmentq.service.states import State
from garmentq.service.understanding import note_checked

HOSTILE = '"><script>alert(1)</script><img src=x onerror=alert(2)>'


@pytest.fixture
def held(site):
    """Return a function that queues a job under a name and claims it, as a worker does."""

    def take(name: str):
        return claim(site.services.database, site.queue(name), "test", 600.0)

    return take


DROP = """([name, letters]) => {
    const transfer = new DataTransfer(), content = Uint8Array.from(atob(letters), (letter) => letter.charCodeAt(0));
    transfer.items.add(new File([content], name));
    const drop = document.querySelector('#drop');
    const send = (kind) => drop.dispatchEvent(
        new DragEvent(kind, { dataTransfer: transfer, bubbles: true, cancelable: true }));
    send('dragenter');
    const isTaken = !send('dragover') && drop.classList.contains('over');
    send('drop');
    return isTaken && !drop.classList.contains('over');
}"""
"""Drops a file, as a hand does that drags it from a folder; true where the place took it and was lit meanwhile."""


def read_rows(page) -> dict[str, str]:
    """Return what the page says was understood of a scan."""
    page.locator("#understood tr").first.wait_for()
    return dict(text.split("\t") for text in page.locator("#understood tr").all_inner_texts())


def test_a_dropped_scan_becomes_a_job(page, site, faults):
    """Broken where a dropped file, what is understood of it, the form, or an option does not reach page or job."""
    page.goto("/")
    assert page.evaluate(DROP, ["skirt.ply", base64.b64encode(make_ply()).decode()])
    page.locator("#looking", has_text="scan.up_ambiguous").wait_for()
    page.get_by_text("Options").click()
    page.get_by_label("Up axis").select_option("y")
    page.locator("#looking", has_text="body.missing").wait_for()
    told = read_rows(page)
    assert "422" in faults.pop()  # the browser itself reports the refusal on its console
    assert told["Detected as"] == "a garment" and told["Size"].startswith("1.00 × 1.00 × 1.00 m, y of the file is up")
    assert told["Surface"] == "4 points, 4 faces" and told["Attributes"] == "no colours, no labels"
    assert "skirt.ply" in page.locator("#told").inner_text() and not page.locator("#sent").is_visible()
    page.get_by_label("Name", exact=True).first.fill("Anna's skirt")
    page.get_by_label("Tags").fill("spring, fitting")
    page.get_by_label("Quality").select_option("preview")
    page.set_input_files("[name=body_file]", {"name": "anna.ply", "mimeType": "", "buffer": make_ply(0.5)})
    page.get_by_text("will check the body and the labels").wait_for()
    page.get_by_role("button", name="Queue the job").click()
    page.wait_for_url("**/jobs/*")
    row = find_job(site.services.database, page.url.rsplit("/", 1)[1])
    assert (row.name, row.state) == ("Anna's skirt", State.QUEUED)
    assert row.request["body"]["name"] == "anna.ply"
    settings = row.request["settings"]
    assert (settings["method"], settings["vertex_count"], settings["up"]) == ("deform", 2000, "y")
    assert page.locator(".tag").all_inner_texts() == ["fitting", "spring"]
    page.get_by_role("button", name="Cancel").click()
    page.get_by_role("button", name="Try again").wait_for()
    assert find_job(site.services.database, row.id).state == State.CANCELLED
    page.get_by_role("button", name="Try again").press("Enter")
    page.get_by_role("button", name="Cancel").wait_for()
    assert find_job(site.services.database, row.id).state == State.QUEUED


def test_a_preview_is_refined_by_a_button(page, site):
    """Broken where the button of a preview's job or result queues nothing or two jobs, or other results have it."""
    preview = site.keep("glance", chosen=RecoverySettings(**QUALITIES["preview"]))
    opened = []
    for place in ("jobs", "results"):
        page.goto(f"/{place}/{preview}")
        page.get_by_role("button", name="Refine").click()
        page.wait_for_url(re.compile(f"/jobs/(?!{preview})"))
        opened.append(page.url.rsplit("/", 1)[1])
        page.goto(f"/{place}/{site.result}")
        assert page.get_by_role("button", name="Refine").count() == 0
    assert opened[0] == opened[1]
    row = find_job(site.services.database, opened[0])
    assert (row.name, row.state, row.request["settings"]["method"]) == ("glance", State.QUEUED, "hybrid")


def test_a_scan_is_chosen_and_queued_by_touch(open_window, site, monkeypatch, tmp_path):
    """Broken where a hand on a telephone cannot choose a scan, see that its wearer was found, and queue it."""
    monkeypatch.setattr(inspection, "INSPECTOR", "garmentq_inspector:inspect_order")
    scan = tmp_path / "anna.ply"
    scan.write_bytes(make_ply(0.125))
    touched = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}
    with open_window(**touched) as opened:
        page = opened.new_page()
        page.goto("/")
        with page.expect_file_chooser() as chooser:
            page.get_by_text("Choose files").tap()
        chooser.value.set_files(scan)
        page.locator("#understood[data-sure='1']").wait_for()
        told = read_rows(page)
        assert told["Detected as"] == "a whole person" and told["Wearer"] == "1.66 m tall"
        assert (told["Repaired"], told["Doubtful"]) == ("Dropped 7 points as flyers.", "The hem lies inside the body.")
        assert page.evaluate("document.documentElement.scrollWidth") <= 390
        page.get_by_text("Options").tap()
        page.get_by_label("Tags").fill("touched")
        page.get_by_role("button", name="Queue the job").tap()
        page.wait_for_url("**/jobs/*")
        row = find_job(site.services.database, page.url.rsplit("/", 1)[1])
        assert (row.kind, row.name, row.state) == ("person", "anna", State.QUEUED)


def test_a_scan_that_cannot_be_read_says_so_before_it_is_queued(page, faults):
    """Broken where a bad file is queued first, or is refused without its code and what to do."""
    page.goto("/")
    page.evaluate(DROP, ["bad.ply", base64.b64encode(make_ply()[:-20]).decode()])
    alert = page.locator("#looking [role=alert]")
    alert.wait_for()
    assert "scan.truncated" in alert.inner_text() and page.locator("#understood tr").count() == 0
    assert page.get_by_role("button", name="Queue the job").is_enabled()
    assert "422" in faults.pop()


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
    note_checked(site.services.database, claimed, {"as": "garment", "scan": {"vertex_count": 1234, "face_count": 5}})
    report(site.services.database, claimed, Progress("drape", 0.25, "step 3", 0.6, 42.0))
    page.get_by_text("drape: step 3, about 42 s to go").wait_for()
    page.get_by_text("1,234 points, 5 faces").wait_for()
    assert page.locator("#progress").evaluate("(bar) => bar.value") == 0.6
    fail(site.services.database, claimed, "scan.truncated", "The file is cut off; export it again.", True)
    page.get_by_role("alert").filter(has_text="cut off").wait_for()
    page.get_by_role("button", name="Try again").wait_for()


def test_the_list_lives_and_is_found_by_filters(page, site, held):
    """Broken where a running job stands still in the list, or a filter of `query` finds others."""
    claimed = held("find-me")
    page.goto("/?view=list&name=find-me")
    assert page.locator("tr.job").count() == 1
    report(site.services.database, claimed, Progress("drape", 0.5, ""))
    page.get_by_text("running: drape 50%").wait_for()
    fail(site.services.database, claimed, "scan.truncated", "The file is cut off.", True)
    page.get_by_text("The file is cut off.").wait_for()
    page.goto("/?view=list&name=find-me&state=succeeded")
    assert page.locator("tr.job").count() == 0
    page.goto("/?view=list&where=" + "surface_rms_mm.t2s < 1000")
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
        grant_job(session, hers.id, queued)
        grant_job(session, hers.id, site.result)
    for token, is_hers in ((his_token, False), (her_token, True)):
        with chromium.new_context(base_url=site.url) as opened:
            assert opened.request.post("/signin", form={"token": token}).ok
            page = opened.new_page()
            page.goto("/")
            assert page.locator("li.family").count() == (2 if is_hers else 0)
            page.goto("/?view=list")
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
        grant_job(session, row.id, site.result)
    with httpx.Client(base_url=site.url) as client:
        assert client.post("/signin", data={"token": token}).status_code == 303
        listed, result = client.get("/").text, client.get(f"/results/{site.result}").text
        assert 'id="submit"' not in listed and "tube" in listed
        assert "data-export" not in result and "/edit" not in result


@pytest.mark.parametrize("first", ["/", "/?view=list"])
def test_pages_of_the_list_follow_each_other(own_site, monkeypatch, first):
    """Broken where a job is left out or shown twice at the turn of a page, or a child stands without its parent."""
    site = own_site
    monkeypatch.setattr(jobs_page, "PAGE_FAMILY_COUNT", 2)
    made = [site.queue(f"job {n}") for n in range(4)]
    with httpx.Client(base_url=site.url) as client:
        client.post("/signin", data={"token": site.token})
        url, seen = first, []
        while url:
            text = client.get(url).text
            seen += re.findall(r'data-job="([0-9a-f]+)"', text)
            found = re.search(r'rel="next" href="([^"]+)"', text)
            url = found and found[1].replace("&amp;", "&")
    assert seen == [*reversed(made), site.result]
