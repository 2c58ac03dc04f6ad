"""Pages of fabrics, base patterns, keys, webhooks and the queue."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import httpx
import pytest
from gallery_families import add_job
from garmentq.core.cloth.fabrics import get_fabric, load_fabrics
from garmentq.service.catalogue import show_fabric
from garmentq.service.jobs import claim
from garmentq.service.keys import create_key, list_keys
from garmentq.service.materials import list_materials
from garmentq.service.models import OutageRow, WorkerRow
from garmentq.service.pages.base_patterns_page import draw_panels
from garmentq.service.pages.fabrics_page import STRIP_LENGTH, find_bending_length, find_droop
from garmentq.service.states import State
from garmentq.service.subject_records import SubjectFields
from garmentq.service.subjects import assign_jobs, create_subject, list_subjects
from garmentq.service.templates import list_templates
from garmentq.service.webhooks import create_webhook, list_webhooks

PLACES = ("/fabrics", "/base-patterns", "/keys", "/webhooks", "/queue", "/subjects")


@pytest.mark.parametrize("path", PLACES)
def test_each_page_is_in_the_navigation_and_accessible(page, path, find_barriers):
    """Broken where a page is a dead end, its place is not marked, a control has no name, or a telephone overflows."""
    page.goto("/")
    page.locator(f'nav a[href="{path}"]').click()
    page.wait_for_url(f"**{path}")
    assert page.locator("nav [aria-current=page]").get_attribute("href") == path
    assert page.get_by_role("heading", level=1).count() == 1
    assert find_barriers(page) == []
    page.set_viewport_size({"width": 390, "height": 844})
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    assert page.locator("header.top").bounding_box()["height"] < 100


def test_a_swatch_bends_as_peirce_says():
    """Broken where a stiffer cloth hangs lower, or the angle does not fulfil Peirce's formula."""
    fabrics = sorted(load_fabrics(), key=find_bending_length)
    angles = [find_droop(one) for one in fabrics]
    assert angles == sorted(angles, reverse=True) and 0.0 < angles[-1] and angles[0] < math.pi / 2
    for one, angle in zip(fabrics, angles, strict=True):
        length = STRIP_LENGTH * (math.cos(angle / 2) / (8 * math.tan(angle))) ** (1 / 3)
        assert length == pytest.approx(find_bending_length(one), rel=1e-6)
    poplin = get_fabric("cotton_poplin")
    assert find_bending_length(replace(poplin, k=8 * poplin.k)) == pytest.approx(2 * find_bending_length(poplin))


def test_a_fabric_is_imported_and_deleted(page, site, tmp_path):
    """Broken where an imported fabric is not in the library, or a shipped one can be deleted."""
    fabric = show_fabric(get_fabric("denim")) | {"name": "our_denim", "title": "Our denim"}
    file = tmp_path / "fabrics.json"
    file.write_text(json.dumps([fabric]))
    page.goto("/fabrics")
    assert page.get_by_role("button", name="Delete…").count() == 0
    page.get_by_label("Import fabrics").set_input_files(file)
    page.get_by_role("button", name="Import", exact=True).click()
    row = page.get_by_role("row", name="Our denim")
    row.get_by_role("button", name="Delete…").click()
    assert page.get_by_role("dialog").get_by_role("heading").inner_text() == "Delete the fabric Our denim?"
    page.get_by_role("dialog").get_by_role("button", name="Delete").click()
    row.wait_for(state="detached")
    assert "our_denim" not in [one.name for one in list_materials(site.services.database)]


def test_a_base_pattern_is_drawn_imported_and_deleted(page, site, faults, tmp_path):
    """Broken where a template has no drawing, or an import is refused without its reason."""
    page.goto("/base-patterns")
    drawing = page.locator('img[src="/templates/skirt/drawing.svg"]')
    drawing.scroll_into_view_if_needed()
    assert drawing.evaluate("(one) => one.decode().then(() => one.naturalWidth)") > 0
    file = tmp_path / "pattern.json"
    with httpx.Client(base_url=site.url, headers={"authorization": f"Bearer {site.token}"}) as client:
        file.write_bytes(client.get("/v1/templates/skirt").content)
    page.get_by_label("Import a pattern file").set_input_files(file)
    page.get_by_label("Name").fill("skirt")
    page.get_by_role("button", name="Import", exact=True).click()
    page.get_by_role("alert").get_by_text("template.name_bad").wait_for()
    assert "422" in faults.pop()
    page.get_by_label("Name").fill("our-skirt")
    page.get_by_role("button", name="Import", exact=True).click()
    card = page.locator("li.family").filter(has=page.get_by_role("heading", name="our-skirt"))
    card.get_by_role("button", name="Delete…").click()
    page.get_by_role("dialog").get_by_role("button", name="Delete").click()
    card.wait_for(state="detached")
    assert "our-skirt" not in [one.name for one in list_templates(site.services.database)]


def test_a_drawing_has_each_panel_at_one_scale(site):
    """Broken where a panel is left out, drawn twice, or at a scale of its own."""
    from garmentq.core.garment.curves import panel_outline
    from garmentq.core.garment.templates import load_template
    from garmentq.service.templates import read_template

    drawing = draw_panels(read_template(site.services, "trousers"))
    shapes = [text.split('"')[0] for text in drawing.split('points="')[1:]]
    sizes = []
    for shape in shapes:
        points = [tuple(map(float, pair.split(","))) for pair in shape.split()]
        sizes.append(max(x for x, _ in points) - min(x for x, _ in points))
    true = [1e3 * float(panel_outline(one, 12)[:, 0].max() - panel_outline(one, 12)[:, 0].min())
            for one in load_template("trousers").panels]  # fmt: skip
    assert sizes == pytest.approx(true, abs=1.1)


def test_a_key_is_shown_once_and_revoked(open_window, own_site, faults):
    """Broken where a token is lost or shown again, or a revoked key stays valid."""
    site = own_site
    _, admin = create_key(site.services.database, "operator", ("admin",))
    with open_window(site, token=admin) as opened:
        page = opened.new_page()
        page.goto("/keys")
        page.get_by_label("Name").fill("atelier")
        page.get_by_label("Open jobs").fill("7")
        page.get_by_role("button", name="Create the key").click()
        token = page.get_by_label("The token of atelier.").input_value()
        headers = {"authorization": f"Bearer {token}"}
        assert httpx.get(f"{site.url}/v1/jobs", headers=headers).status_code == 200
        page.get_by_role("link", name="Done").click()
        row = page.get_by_role("row", name="atelier")
        row.wait_for()
        assert token not in page.content() and "read, submit" in row.inner_text()
        row.get_by_role("button", name="Revoke…").click()
        page.get_by_role("dialog").get_by_role("button", name="Revoke").click()
        row.get_by_text("revoked").wait_for()
        assert httpx.get(f"{site.url}/v1/jobs", headers=headers).status_code == 401
        assert [key.quota for key in list_keys(site.services.database) if key.name == "atelier"] == [7]


def test_a_subject_is_created_changed_and_deleted(open_window, own_site):
    """Broken where a date moves by a day, what was said of a person is lost on saving, or deletion asks nothing."""
    site = own_site  # a deletion takes all that was made of the same scan
    with open_window(site) as opened:
        page = opened.new_page()
        page.goto("/subjects")
        page.get_by_text("New subject").click()
        page.get_by_label("Name", exact=True).fill("Frau Müller")
        page.get_by_label("Agreed to be scanned").fill("2026-11-22")
        page.get_by_role("button", name="Create the subject").click()
        page.get_by_role("heading", name="Frau Müller").wait_for()
        (made,) = list_subjects(site.services.database, "Frau Müller")
        job = add_job(site.services, "first fitting", state=State.SUCCEEDED)
        assign_jobs(site.services.database, made.id, [job])
        page.reload()
        assert page.locator("li.family h2").all_inner_texts() == ["first fitting"]
        page.get_by_text("Consent and retention").click()
        assert page.get_by_label("Agreed to be scanned").input_value() == "2026-11-22"
        page.get_by_label("Days that data are kept").fill("90")
        page.get_by_role("button", name="Save").click()
        page.get_by_text("All its data are deleted").wait_for()
        (kept,) = list_subjects(site.services.database, "Frau Müller")
        assert (kept.keep_days, kept.consented) == (90.0, made.consented)
        page.get_by_role("button", name="Delete the person's data…").click()
        assert "1 jobs" in page.get_by_role("dialog").inner_text()
        page.get_by_role("dialog").get_by_role("button", name="Delete").click()
        page.wait_for_url("**/subjects")
        assert list_subjects(site.services.database, "Frau Müller") == []


def test_who_does_not_administer_sees_no_keys_and_no_imports(own_site):
    """Broken where a key without `admin` opens the page of keys, is led there, or is offered what it may not do."""
    _, token = create_key(own_site.services.database, "reader", ("read",))
    with httpx.Client(base_url=own_site.url) as client:
        client.post("/signin", data={"token": token})
        assert client.get("/keys").status_code == 403
        assert 'href="/keys"' not in client.get("/queue").text
        for path in ("/fabrics", "/base-patterns", "/webhooks"):
            text = client.get(path).text
            assert "<form class=" not in text.replace('<form class="signout"', "") and "data-send" not in text


def test_who_only_reads_is_not_told_to_drop_scans(own_site):
    """Broken where an empty gallery names a place for scans that a key without `submit` has not."""
    _, token = create_key(own_site.services.database, "reader", ("read",))
    with httpx.Client(base_url=own_site.url, timeout=60.0) as client:
        client.post("/signin", data={"token": token})
        text = client.get("/").text
    assert "There are no jobs yet." in text and "drop a scan" not in text


def test_the_note_on_the_first_key_goes_with_it(own_site, open_window):
    """Broken where the page speaks of a first key although there is one, or not before."""
    with open_window(at=own_site) as opened:
        assert "The first key ends" in opened.request.get("/keys").text()
    _, token = create_key(own_site.services.database, "office", ("read", "admin"))
    with httpx.Client(base_url=own_site.url, timeout=60.0) as client:
        client.post("/signin", data={"token": token})
        text = client.get("/keys").text
    assert "office" in text and "The first key ends" not in text


@pytest.mark.parametrize("path", ["/fabrics", "/subjects", "/keys", "/webhooks"])
def test_a_table_has_nothing_cut_on_a_telephone(own_site, open_window, path):
    """Broken where a cell or its head is outside a telephone's screen, or a number has no head."""
    database = own_site.services.database
    create_subject(database, SubjectFields("Bertha-Maximiliane von Hohenfels", consented=1.0, keep_days=9.0))
    create_webhook(database, "https://1.1.1.1/a-rather-long-path/that-goes-on-and-on/2026", (), "")
    _, token = create_key(database, "fitting room", ("read", "submit", "admin"))
    with open_window(at=own_site, token=token, viewport={"width": 390, "height": 844}) as opened:
        page = opened.new_page()
        page.goto(path)
        row = page.locator("table.library tbody tr").first
        row.wait_for()
        assert page.evaluate(CUT) == []
        head = "cell => getComputedStyle(cell, '::before').content"
        heads = row.locator("td.number").evaluate_all(f"cells => cells.map({head})")
        assert heads and all(text.startswith('"') and ": " in text for text in heads)


CUT = """[...document.querySelectorAll("main td, main th")].filter((cell) => {
const { left, right, width } = cell.getBoundingClientRect(); return width && (left < 0 || right > innerWidth); })
.map((one) => one.textContent)"""


def test_a_webhook_is_created_tested_and_deleted(page, site, faults):
    """Broken where the secret is not shown, a refused address has no reason, or a test says nothing."""
    page.goto("/webhooks")
    page.get_by_label("Address").fill("http://127.0.0.1:9/")
    page.get_by_role("button", name="Create the webhook").click()
    page.get_by_role("alert").get_by_text("webhook").first.wait_for()
    assert "422" in faults.pop()
    page.get_by_label("Address").fill("https://hooks.invalid/garmentq")
    page.get_by_label("failed").check()
    page.get_by_role("button", name="Create the webhook").click()
    assert page.get_by_label("The secret that signs the messages.").input_value().startswith("whsec_")
    page.get_by_role("link", name="Done").click()
    row = page.get_by_role("row", name="hooks.invalid")
    assert "failed" in row.inner_text() and "no message yet" in row.inner_text()
    row.get_by_role("button", name="Delete…").click()
    page.get_by_role("dialog").get_by_role("button", name="Delete").click()
    page.get_by_text("There are no webhooks.").wait_for()
    assert list_webhooks(site.services.database, None) == []


def test_the_queue_names_workers_jobs_and_outages(page, own_site, open_window):
    """Broken where a running or waiting job, a worker or an outage is not on the page."""
    site = own_site
    database = site.services.database
    claimed = claim(database, site.queue("running one"), "worker-a", 600.0)
    site.queue("waiting one")
    with open_window(site) as opened:
        page = opened.new_page()
        page.goto("/queue")
        assert page.get_by_role("region", name="Jobs running").get_by_role("link").all_inner_texts() == ["running one"]
        assert page.get_by_role("region", name="Jobs queued").get_by_role("link").all_inner_texts() == ["waiting one"]
        alert = page.get_by_role("alert").inner_text()
        assert "No worker is up" in alert and "garmentq " not in alert
        from garmentq.service.database import clock

        with database.write() as session:
            session.add(WorkerRow(name="host-1", queues="cpu", concurrency=2, started=clock(), seen=clock()))
            session.add(OutageRow(place="host-1", code="store.unreachable", since=clock(), seen=clock()))
        page.get_by_role("region", name="Workers").get_by_text("host-1").wait_for()  # by itself
        assert page.get_by_role("alert").filter(has_text="store.unreachable").count() == 1
    assert claimed
