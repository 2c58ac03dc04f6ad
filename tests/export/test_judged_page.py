"""What the reports of worn and moving garments share."""

from __future__ import annotations

from garmentq.core.deliver.export.judged_page import Heading, gates_html, head_html, manifest_html, numbers_html
from garmentq.core.run.verdict import Gate, Verdict

BAD = "<script>alert(1)</script>"


def test_names_from_files_are_escaped():
    """Broken where a pattern's, motion's or metric's name reaches the page as HTML."""
    gate = Gate(BAD, Verdict.DOUBTFUL, 1.0, 2.0, BAD)
    page = "".join(
        [head_html(Heading("in motion", BAD, {"Motion": BAD}), [gate], [BAD]), gates_html([gate]),
         numbers_html({BAD: 1.0}), manifest_html({"body": BAD})]
    )  # fmt: skip
    assert "<script>" not in page
    assert page.count("&lt;script&gt;") == 8


def test_checks_show_value_limit_and_meaning():
    """Broken where a verdict is shown without what it was judged by, or under the name that code has for it."""
    table = gates_html([Gate("at_rest", Verdict.FAIL, 2.5, 1.0, "It moves.")])
    assert all(word in table for word in ("at rest", "fail", "2.5", "1", "It moves.", "Passes to"))
