"""Errors in words of a page, with the navigation; programs get them as JSON."""

from __future__ import annotations

import httpx
import pytest
from garmentq.service.keys import create_key


@pytest.mark.parametrize(
    ("path", "title", "code"),
    [
        ("/no/such/page", "Not found", "request.no_such_page"),
        ("/jobs/abcdefabcdef", "Not found", "job.unknown"),
        ("/results/abcdefabcdef", "Not found", "job.unknown"),
        ("/v1/jobs/abcdefabcdef/result.zip", "Not found", "job.unknown"),
        ("/?view=sideways", "This did not work", "request.bad"),
        ("/?where=nonsense", "This did not work", "query.bad"),
    ],
)
def test_an_error_keeps_the_navigation(page, faults, path, title, code):
    """Broken where a browser sees JSON, a page without a way on, or a command in its sentence."""
    answer = page.goto(path)
    assert answer.status in (404, 422) and page.get_by_role("heading").inner_text() == title
    alert = page.get_by_role("alert").inner_text()
    assert "garmentq " not in alert and "--" not in alert and not alert[0].islower()
    assert page.locator("main code").inner_text() == code
    page.get_by_role("navigation").get_by_role("link").first.click()
    page.get_by_role("heading", name="Gallery").wait_for()
    faults.clear()


def test_a_program_gets_json_at_the_same_addresses(site):
    """Broken where a script that does not say what it accepts gets a page."""
    with httpx.Client(base_url=site.url, headers={"authorization": f"Bearer {site.token}"}) as client:
        for path in ("/v1/jobs/abcdefabcdef", "/v1/jobs/abcdefabcdef/result.zip", "/no/such/page"):
            answer = client.get(path)
            assert answer.headers["content-type"] == "application/problem+json" and answer.status_code == 404
        assert client.post("/no/such/page", headers={"accept": "text/html"}).json()["code"]


def test_without_a_session_an_unknown_address_shows_no_navigation(site):
    """Broken where somebody who has not signed in sees the pages' links, or the service fails."""
    answer = httpx.get(f"{site.url}/no/such/page", headers={"accept": "text/html"})
    assert answer.status_code == 404 and "<nav" not in answer.text and "There is no page" in answer.text


def test_a_refused_page_says_who_may(own_site):
    """Broken where a key without a scope sees JSON, or a sentence about an option."""
    _, token = create_key(own_site.services.database, "watcher", ("metrics",))
    with httpx.Client(base_url=own_site.url) as client:
        client.post("/signin", data={"token": token})
        answer = client.get("/", headers={"accept": "text/html"})
        assert answer.status_code == 403 and "ask the operator" in answer.text and "--scope" not in answer.text


def test_the_description_of_the_api_leads_back_and_has_both_themes(page, find_barriers):
    """Broken where `/docs` is a dead end, shows marks of code, is white at night, or overflows a telephone."""
    page.goto("/docs")
    assert page.locator("main > p > code").first.inner_text() == "code"
    assert find_barriers(page) == []
    page.emulate_media(color_scheme="dark")
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(18, 22, 29)"
    page.set_viewport_size({"width": 390, "height": 844})
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    page.get_by_role("link", name="Back to the gallery").click()
    page.get_by_role("heading", name="Gallery").wait_for()
