"""A link to a result: made on its page, opened by somebody who is not signed in, revoked."""

from __future__ import annotations


def test_a_link_is_made_opened_and_revoked(page, site, chromium, find_barriers):
    """Broken where the page makes no link, a stranger sees no garment, or a revoked link still shows it."""
    page.goto(f"/results/{site.result}")
    page.locator("#result[data-ready]").wait_for()
    page.locator("#shares summary").click()
    page.get_by_label("Valid for").select_option("1")
    page.get_by_role("button", name="Make a link").click()
    link = page.get_by_label("Link", exact=True).input_value()
    assert "/shared/" in link
    stranger = chromium.new_context(viewport={"width": 390, "height": 844}).new_page()
    stranger.goto(link)
    stranger.locator("#shared[data-ready]").wait_for()
    assert stranger.locator("nav").count() == 0 and stranger.locator("canvas").count() == 1
    assert stranger.evaluate("document.documentElement.scrollWidth") <= 390
    page.get_by_role("button", name="Revoke").click()
    page.get_by_text("The link is revoked.").wait_for()
    assert stranger.goto(link).status == 404
    stranger.context.close()
    assert find_barriers(page) == []
