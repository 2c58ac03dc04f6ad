"""Choosing families on the page of jobs, and actions on all of them, by mouse and by keyboard."""

from __future__ import annotations

import re

import pytest
from gallery_families import add_job, add_person
from garmentq.service.jobs import JobUnknown, find_job
from garmentq.service.pages import jobs_page
from garmentq.service.results import report_jobs
from garmentq.service.states import State


@pytest.fixture
def five(site, request):
    """Add five families of a tag that is the test's own; gives the tag and the ids, the newest first."""
    tag = re.sub("[^a-z]", "-", request.node.name)[:60]
    jobs = [add_job(site.services, f"{n} of five", tags=(tag,), state=State.QUEUED) for n in range(5)]
    return tag, jobs[::-1]


def read_states(site, jobs) -> list[str]:
    """Return the states of some jobs; `deleted` where there is none."""
    found = []
    for job in jobs:
        try:
            found.append(str(find_job(site.services.database, job).state))
        except JobUnknown:
            found.append("deleted")
    return found


@pytest.mark.parametrize("view", ["", "&view=list"], ids=["gallery", "list"])
def test_a_range_is_cancelled_and_tried_again(page, site, five, view):
    """Broken where Shift chooses no range, or an action works on others than the chosen ones."""
    tag, jobs = five
    page.goto(f"/?tag={tag}{view}")
    boxes = page.locator("[data-pick]")
    boxes.nth(1).click()
    boxes.nth(3).click(modifiers=["Shift"])
    page.get_by_text("3 selected").wait_for()
    assert page.get_by_role("button", name="Rename…").is_disabled()
    page.locator("#selection").get_by_role("button", name="Cancel").click()
    page.get_by_text("3 of 3 stopped").wait_for()
    assert read_states(site, jobs) == ["queued", "cancelled", "cancelled", "cancelled", "queued"]
    page.locator("#selection").get_by_role("button", name="Try again").click()
    page.get_by_text("3 of 3 queued again").wait_for()
    assert set(read_states(site, jobs)) == {"queued"}


def test_all_of_the_filter_are_deleted_after_a_question(page, site, five, monkeypatch, faults):
    """Broken where other pages of the filter are left out, the number is not named, or a refusal stops the others."""
    tag, jobs = five
    monkeypatch.setattr(jobs_page, "PAGE_FAMILY_COUNT", 2)
    with site.services.database.write() as session:
        from garmentq.service.models import JobRow

        for job in jobs[1:]:
            session.get(JobRow, job).state = State.SUCCEEDED
    page.goto(f"/?tag={tag}")
    assert page.locator("li.family").count() == 2
    box = page.get_by_label("Select 4 of five")
    box.focus()
    box.press("Space")
    page.get_by_role("button", name="Select all found").press("Enter")
    page.get_by_text("5 selected").wait_for()
    page.get_by_role("button", name="Delete…").press("Enter")
    dialog = page.get_by_role("dialog")
    assert dialog.get_by_role("heading").inner_text() == "Delete 5 persons or garments?"
    page.keyboard.press("Escape")
    assert set(read_states(site, jobs)) == {"queued", "succeeded"}
    page.get_by_role("button", name="Delete…").click()
    dialog.get_by_role("button", name="Delete 5").click()
    page.get_by_text("4 of 5 deleted, 1 not").wait_for()
    assert "cancel it first" in page.locator("#outcome li").inner_text()
    assert read_states(site, jobs) == ["queued", "deleted", "deleted", "deleted", "deleted"]
    page.get_by_text("1 selected").wait_for()
    assert "409" in faults.pop()  # the browser itself reports the refusal on its console


def test_a_family_is_renamed_and_tagged(page, site, five):
    """Broken where the card keeps its old name, or a new tag takes the others away."""
    tag, jobs = five
    page.goto(f"/?tag={tag}")
    page.get_by_label("Select 2 of five").check()
    page.get_by_role("button", name="Rename…").click()
    page.get_by_role("dialog").get_by_label("Name").fill("Frau Müller")
    page.keyboard.press("Enter")
    page.get_by_role("heading", name="Frau Müller").wait_for()
    page.get_by_role("button", name="Add a tag…").click()
    page.get_by_role("dialog").get_by_label("Tag").fill("second fitting")
    page.keyboard.press("Enter")
    page.get_by_role("link", name="second fitting").wait_for()
    (job,) = report_jobs(site.services.database, [find_job(site.services.database, jobs[2])], site.settings)
    assert (job.name, job.tags) == ("Frau Müller", sorted([tag, "second fitting"]))


def test_the_priority_of_families_is_changed(page, site, five):
    """Broken where a job that was not chosen changes, a number out of the range or none is sent, or the field hides
    what the priority is."""
    tag, jobs = five
    page.goto(f"/?tag={tag}")
    page.get_by_label("Select 4 of five").check()
    page.get_by_label("Select 3 of five").check()
    field, change = page.get_by_role("dialog").get_by_label("Priority"), page.get_by_role("button", name="Priority…")
    change.click()
    assert field.input_value() == "0"
    for wrong in ("101", "", "1.5"):
        field.fill(wrong)
        page.keyboard.press("Enter")
        assert page.get_by_role("dialog").is_visible()
    field.fill("-7")
    page.keyboard.press("Enter")
    page.get_by_text("2 of 2 changed").wait_for()
    assert [find_job(site.services.database, job).priority for job in jobs] == [-7, -7, 0, 0, 0]
    page.get_by_label("Select 2 of five").check()
    change.click()
    assert field.input_value() == ""
    page.keyboard.press("Escape")
    page.get_by_label("Select 2 of five").uncheck()
    page.get_by_label("Select 3 of five").uncheck()
    page.get_by_role("button", name="Rename…").click()
    assert page.get_by_role("dialog").get_by_label("Name").get_attribute("type") == "text"


def test_exports_of_a_batch_are_queued_and_offered(page, site):
    """Broken where a garment of the batch is left out, one that failed is exported, or no file is offered."""
    from garmentq.service.models import JobRow

    add_person(site.services, "Export me", tags=("to export",))
    page.goto("/?tag=to+export")
    counts = " ".join(page.locator("#batch-counts").inner_text().split())
    assert counts == "0 done 1 failed 0 to go"
    page.get_by_role("button", name="Export all…").click()
    page.get_by_role("dialog").get_by_label("Format").select_option("svg")
    page.get_by_role("dialog").get_by_role("button", name="Export").click()
    page.get_by_text("0 of 1 exports ready").wait_for()
    with site.services.database.write() as session:
        (made,) = session.query(JobRow).filter(JobRow.kind == "export", JobRow.name == "Export me upper").all()
        assert made.request["format"] == "svg"
        made.state = State.SUCCEEDED
        job = made.id
    link = page.locator("#outcome").get_by_role("link", name="Export me upper")
    link.wait_for()
    assert link.get_attribute("href") == f"/v1/jobs/{job}/result.zip"
    assert page.locator("li.family .others summary").inner_text().startswith("1 more")


def test_the_selection_is_accessible(page, site, five, find_barriers):
    """Broken where a button of the bar or of the dialog has no name or too little contrast."""
    tag, _ = five
    page.goto(f"/?tag={tag}")
    page.locator("[data-pick]").first.check()
    assert find_barriers(page) == []
    page.get_by_role("button", name="Delete…").click()
    assert find_barriers(page) == []
    page.set_viewport_size({"width": 390, "height": 844})
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
