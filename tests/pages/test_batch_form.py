"""Several files and folders in the form of new jobs."""

from __future__ import annotations

import pytest
from api_work import make_ply
from garmentq.service.jobs import find_job
from garmentq.service.query import JobQuery, find_jobs
from garmentq.service.states import State


@pytest.fixture
def folder(tmp_path):
    """Make a folder as a studio has it: two scans, a broken one, and a picture, one in a folder below."""
    scans = tmp_path / "March fitting"
    (scans / "more").mkdir(parents=True)
    (scans / "anna.ply").write_bytes(make_ply(0.31))
    (scans / "broken.ply").write_bytes(make_ply(0.32)[:-20])
    (scans / "more" / "clara.ply").write_bytes(make_ply(0.33))
    (scans / "anna.jpg").write_bytes(b"picture")
    return scans


def choose_options(page):
    """Say which axis is up, that the scans are garments, and who wears them."""
    page.goto("/")
    page.get_by_text("Options").click()
    page.get_by_label("Up axis").select_option("y")
    page.get_by_label("The scan is").select_option("garment")
    page.get_by_label("Tags").fill("spring")
    page.get_by_label("Body", exact=True).fill("builtin:female,height=1.70")


def test_a_folder_becomes_a_batch(page, site, faults, folder):
    """Broken where a bad file stops the good ones, is queued itself, or a job lacks the batch's tag or an option."""
    choose_options(page)
    page.locator("#folder").set_input_files(folder)
    rows = page.locator(".files li")
    assert rows.count() == 4 and page.locator("[name=batch]").input_value() == "March fitting"
    told = {
        name: rows.filter(has_text=name).locator(".told") for name in ("anna.ply", "broken.ply", "clara.ply", "jpg")
    }
    told["broken.ply"].locator("code", has_text="scan.truncated").wait_for()
    told["clara.ply"].get_by_text("a garment; 1.00 × 1.00 × 1.33 m").wait_for()
    assert told["jpg"].inner_text() == "left out: not a format of scans"
    page.get_by_role("button", name="Queue all").click()
    page.get_by_text("2 of 3 queued.").wait_for()
    assert told["anna.ply"].get_by_role("link", name="queued").count() == 1
    found = find_jobs(site.services.database, JobQuery({"tag": "March fitting"}).conditions)
    assert sorted(row.name for row in found) == ["anna", "clara"] and {row.state for row in found} == {State.QUEUED}
    assert {row.request["settings"]["up"] for row in found} == {"y"}
    assert len(find_jobs(site.services.database, JobQuery({"tag": "spring", "name": "clara"}).conditions)) == 1
    page.get_by_role("link", name="Show the batch").click()
    assert page.locator("li.family h2").all_inner_texts() == ["clara", "anna"]
    assert [one for one in faults if "422" not in one] == []
    faults.clear()


def test_several_chosen_files_lead_to_their_batch(page, site, folder):
    """Broken where files that are chosen together are not queued, or a later choice of one file stays a batch."""
    for name, mark in (("anna.ply", 0.34), ("more/clara.ply", 0.35)):
        (folder / name).write_bytes(make_ply(mark))
    choose_options(page)
    page.locator("#scan").set_input_files([folder / "anna.ply", folder / "more" / "clara.ply"])
    page.locator("[name=batch]").fill("two at once")
    page.get_by_role("button", name="Queue all").click()
    page.wait_for_url("**/?tag=two+at+once")
    assert page.locator("li.family").count() == 2
    choose_options(page)
    page.locator("#scan").set_input_files([folder / "anna.ply", folder / "more" / "clara.ply"])
    page.locator("[name=batch]").fill("once more")
    page.get_by_role("button", name="Queue all").click()
    page.wait_for_url("**/?tag=once+more")
    assert page.locator("li.family").count() == 2  # known jobs have the batch's tag, too
    choose_options(page)
    page.locator("#scan").set_input_files([folder / "anna.ply", folder / "more" / "clara.ply"])
    page.locator("#scan").set_input_files([folder / "anna.ply"])
    assert not page.locator("#batch").is_visible()
    page.locator("#understood tr").first.wait_for()
    page.get_by_label("Name", exact=True).first.fill("alone")
    page.get_by_role("button", name="Queue the job").click()
    page.wait_for_url("**/jobs/*")
    assert find_job(site.services.database, page.url.rsplit("/", 1)[1]).state == State.QUEUED


LIST = """async () => {
    const { listFiles } = await import('/static/dropped.js');
    const file = (name) => ({ isFile: true, name, file: (done) => done(new File(['x'], name)) });
    const folder = (name, ...parts) => ({ isFile: false, isDirectory: true, name, createReader: () => ({
        readEntries: (done) => done(parts.length ? [parts.shift()] : []) }) });
    const found = await listFiles(folder('a', file('2.ply'), folder('b', file('3.ply')), file('1.ply')));
    return found.map((one) => one.name);
}"""
"""Lists the files of a folder whose reader hands over one entry at a time, as browsers do a hundred."""


def test_a_dropped_folder_is_read_to_its_end(page):
    """Broken where only the first part of a folder's entries is read, or folders below are left out."""
    page.goto("/")
    assert page.evaluate(LIST) == ["1.ply", "2.ply", "3.ply"]
