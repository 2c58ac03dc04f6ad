"""Reports on narrow screens: every cell carries the head of its column."""

from __future__ import annotations

from garmentq.core.deliver.export.page import page_html


def test_cells_carry_the_heads_of_their_columns():
    """Broken where a stacked row shows a number without what it is, or a head with markup breaks out of its quotes."""
    head = '<tr><th></th><th>Value</th><th class=num>Area &amp; "size" [cm<b>2</b>]</th></tr>'
    rows = "<tr><td>a</td><td class=num>1</td><td>2</td><td>3</td></tr><tr><td>b</td></tr>"
    shown = page_html("scan", [f"<table class=x>{head}{rows}</table>", "<table><tr><td>alone</td></tr></table>"])
    assert '<td data-head="">a</td><td data-head="Value" class=num>1</td>' in shown
    assert '<td data-head="Area &amp; &quot;size&quot; [cm2]">2</td><td data-head="">3</td>' in shown
    assert '<tr><td data-head="">b</td></tr>' in shown and '<td data-head="">alone</td>' in shown
    assert head in shown


def test_a_report_fits_a_phone_in_light_and_dark():
    """Broken where the style of a report has no rules for a narrow screen or for dark."""
    shown = page_html("scan", [])
    assert "max-width: 640px" in shown and "prefers-color-scheme: dark" in shown
