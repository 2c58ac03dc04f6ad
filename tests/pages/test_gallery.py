"""The gallery: cards of persons and garments, in a real browser of a real service."""

from __future__ import annotations

import io
import re
from pathlib import Path

import httpx
import numpy as np
import pytest
from gallery_families import SCAN, SKIN, add_job, add_person, keep_sheet
from garmentq.service.batch_records import FamilyCount
from garmentq.service.batches import BatchUnknown, find_batch
from garmentq.service.gallery import read_families
from garmentq.service.keys import create_key
from garmentq.service.pages import control_words
from garmentq.service.pages.control_words import speak_of_controls
from garmentq.service.pages.figures import cut_figure, find_figure
from garmentq.service.query import JobQuery, find_families
from garmentq.service.states import State
from PIL import Image


@pytest.fixture
def add(site):
    """Return a function that adds a job in any state, without its work; gives the id."""
    return lambda *args, **values: add_job(site.services, *args, **values)


def test_a_figure_is_the_scan_from_the_front_and_nothing_else(site):
    """Broken where the card's picture is a contact sheet, the bare body beside the scan, or keeps its white ground."""
    person = add_job(site.services, "cut", state=State.SUCCEEDED)
    keep_sheet(site.services, person)
    source = find_figure(site.services, person, "person")
    seen = np.asarray(Image.open(io.BytesIO(cut_figure(site.services.store, source))).convert("RGB")).astype(int)
    height, width = seen.shape[:2]
    assert width < 280 and abs(height / width - 416 / 116) < 0.05
    assert np.abs(seen[height // 2, width // 2] - SCAN).max() < 12 and seen[0, 0].min() > 245
    assert np.abs(seen - SKIN).max(axis=2).min() > 100  # no pixel of the body's picture


def test_the_figure_of_a_garment_is_its_front_view(site):
    """Broken where a recovery's card has another picture of the report, or none."""
    with httpx.Client(base_url=site.url) as client:
        client.post("/signin", data={"token": site.token})
        answer = client.get(f"/jobs/{site.result}/thumbnail")
        assert answer.headers["content-type"] == "image/webp"
        again = client.get(f"/jobs/{site.result}/thumbnail", headers={"if-none-match": answer.headers["etag"]})
        assert again.status_code == 304 and again.headers["etag"] == answer.headers["etag"]
    with Image.open(io.BytesIO(answer.content)) as figure:
        assert 100 < max(figure.size) <= 400


def test_a_card_has_a_person_its_garments_and_what_was_made_of_them(page, site, add):
    """Broken where garments have no verdict in words, exports are cards too, or an error is not in the card."""
    person, upper, _ = add_person(site.services, "Clara")
    add("Clara's pattern", "export", reads=upper, state=State.SUCCEEDED)
    add("a wider one", "edit", reads=upper, state=State.QUEUED)
    page.goto("/?name=Clara")
    card = page.locator("li.family")
    assert card.count() == 1 and card.get_attribute("data-job") == person
    assert card.get_by_role("heading").inner_text() == "Clara"
    garments = card.locator(".garments li")
    assert [" ".join(text.split()) for text in garments.all_text_contents()] == ["pass T-shirt", "failed Lower"]
    assert garments.first.get_by_role("link").get_attribute("href") == f"/results/{upper}"
    assert "lower: Say the wearer with the option Body. body.missing" in card.locator(".error").inner_text()
    card.get_by_text("2 more, 1 open").click()
    assert card.locator(".others a").all_inner_texts() == ["Clara's pattern", "a wider one"]
    shapes = [one.get_attribute("d") for one in garments.locator(".icon path").all()]
    assert len(set(shapes)) == 2


def test_a_person_without_a_garment_is_shown_only_on_request(page, site, add):
    """Broken where the picture of somebody in no known clothes comes without a click."""
    person = add("undressed", state=State.SUCCEEDED)
    keep_sheet(site.services, person)
    page.goto("/?name=undressed")
    assert page.locator("li.family img").count() == 0 and page.locator("li.family svg.blank").count() == 1
    page.get_by_role("link", name="Show pictures of persons without a garment").click()
    assert page.locator("li.family img").evaluate("(one) => one.decode().then(() => one.naturalHeight)") == 400
    page.get_by_role("link", name="Hide pictures").click()
    assert page.locator("li.family img").count() == 0


def test_the_view_stays_in_the_address_with_the_filter(page, site):
    """Broken where gallery and list lose each other's filter."""
    add_person(site.services, "Toggle")
    page.goto("/?name=Toggle")
    page.get_by_role("link", name="List", exact=True).click()
    assert page.locator("tr.job").count() == 3 and "name=Toggle" in page.url and "view=list" in page.url
    assert page.locator("tr.below a:not(.plain)").all_inner_texts() == ["Toggle: upper", "Toggle: lower"]
    page.get_by_role("button", name="Find").click()
    assert "view=list" in page.url
    page.get_by_role("group", name="View").get_by_role("link", name="Gallery").click()
    assert page.locator("li.family").count() == 1


def test_cards_live(page, site, add):
    """Broken where a card stands still, or its change loses what was chosen or unfolded."""
    person = add("Live", state=State.RUNNING, stage="separate", progress=0.2, overall=0.1, lease_until=1e12)
    page.goto("/?name=Live")
    page.get_by_text("running: separate 20%").wait_for()
    page.get_by_label("Select Live").check()
    database = site.services.database
    with database.write() as session:
        from garmentq.service.models import JobRow

        session.get(JobRow, person).progress = 0.7
    page.get_by_text("running: separate 70%").wait_for()
    for name in ("upper", "lower"):
        add(name, "recover", parent=person, state=State.QUEUED)
    with database.write() as session:
        session.get(JobRow, person).state = State.SUCCEEDED
    page.get_by_text("0 of 2 garments done").wait_for()
    assert page.locator("progress[data-progress]").evaluate("(bar) => bar.value") == pytest.approx(1 / 3, abs=0.01)
    assert page.get_by_label("Select Live").is_checked()


def test_filters_look_into_families(site, add):
    """Broken where a garment of a person is not found by its category, or a reader of a result is a card."""
    person, upper, _ = add_person(site.services, "Deep", tags=("deep",))
    add("Deep's export", "export", reads=upper, tags=("deep",), state=State.SUCCEEDED)
    database = site.services.database
    for fields in ({"tag": "deep", "verdict": "pass"}, {"tag": "deep", "garment": "tshirt"}, {"tag": "deep"}):
        assert find_families(database, JobQuery(fields).conditions, 10) == [(person, "Deep")]
    assert find_families(database, JobQuery({"tag": "deep", "kind": "export"}).conditions, 10) == []
    (family,) = read_families(database, [person])
    assert [one.name for one in family.garments] == ["upper", "lower"] and [one.kind for one in family.others] == [
        "export"
    ]


def test_common_and_rare_filters_find_the_same(site, add, monkeypatch):
    """Broken where the two ways to look for many and for few matches differ."""
    from garmentq.service import query

    for n in range(3):
        add_person(site.services, f"many {n}", tags=("many",))
    conditions = JobQuery({"tag": "many", "verdict": "pass"}).conditions
    few = find_families(site.services.database, conditions, 2)
    monkeypatch.setattr(query, "MIN_EXISTS_MATCH_COUNT", 1)
    many = find_families(site.services.database, conditions, 2)
    assert [name for _, name in few] == ["many 2", "many 1"] and many == few
    assert [name for _, name in find_families(site.services.database, conditions, 2, before=few[-1][0])] == ["many 0"]


def test_a_batch_is_counted_by_families(own_site):
    """Broken where jobs are counted in place of persons, or those of another key."""
    services = own_site.services
    (hers, _), (his, _) = (create_key(services.database, name, ("read",)) for name in ("hers", "his"))
    add_person(services, "failed", tags=("b",))
    add_job(services, "done", tags=("b",), state=State.SUCCEEDED, owner=hers.id)
    opened = add_job(services, "open", tags=("b",), state=State.SUCCEEDED, owner=hers.id)
    add_job(services, "upper", "recover", parent=opened, tags=("b",), owner=hers.id)
    assert find_batch(services.database, "b").families == FamilyCount(1, 1, 1)
    assert find_batch(services.database, "b", hers.id).families == FamilyCount(1, 0, 1)
    with pytest.raises(BatchUnknown):
        find_batch(services.database, "b", his.id)


def test_pages_speak_of_controls(page):
    """Broken where a page tells to type an option or a command."""
    said = speak_of_controls("Give --body body.ply, or --keep-colour; `garmentq status` lists them all.")
    assert said == "Give the option Body body.ply, or the option Keep colour; the list of jobs lists them all."
    assert speak_of_controls("a -- b, 3--4, x--y") == "a -- b, 3--4, x--y"
    words = (*control_words.CONTROLS, "keep-colour", "x--y")
    said = [f"`garmentq {one} JOB` or --{word}." for one in (*control_words.COMMANDS, "up") for word in words]
    page.goto("/")
    script = "(all) => import('/static/words.js').then((words) => all.map(words.speakOfControls))"
    assert page.evaluate(script, said) == list(map(speak_of_controls, said))  # scripts say the same
    pages = Path(jobs_folder())
    assert not re.findall(r">[^<{]* --[a-z]", "".join(one.read_text() for one in pages.glob("*.py")))


def jobs_folder() -> Path:
    """Return the folder of the pages' modules."""
    from garmentq.service import pages

    return Path(pages.__file__).parent
