"""axe-core finds nothing serious on the pages."""

from __future__ import annotations

import pytest


@pytest.mark.parametrize("path", ["/", "/?view=list", "/jobs/{job}", "/results/{job}"])
def test_axe_finds_nothing_serious(page, site, path, find_barriers):
    """Broken where a control has no name, a text too little contrast, or the keyboard no way to a part."""
    page.goto(path.format(job=site.result))
    if path.startswith("/results"):
        page.locator("#result[data-ready]").wait_for()
    for summary in page.locator("summary").all():
        summary.click()
    assert find_barriers(page) == []
