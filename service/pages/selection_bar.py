"""The bar of actions on chosen families, and the head of a batch."""

from __future__ import annotations

from ..batch_records import Batch, FamilyCount
from .actions import DIALOG
from .markup import Html, html, join

EXPORT_FIRST = "pdf"
"""Format that the list of exports begins with: a pattern to print."""


def draw_selection() -> Html:
    """Return the bar, hidden until something is chosen, and the dialog in which actions are confirmed."""
    from ...core.deliver.formats.registry import DESCRIPTIONS  # imports scipy: not at every start

    names = sorted(DESCRIPTIONS, key=lambda name: name != EXPORT_FIRST)
    formats = join(html('<option value="{}">{}: {}</option>', one, one.upper(), DESCRIPTIONS[one]) for one in names)
    return html("{}{}", html(SELECTION), html(DIALOG, formats=formats))


def draw_batch(batch: Batch, may_submit: bool) -> Html:
    """Return how far the families of a batch are."""
    count = batch.families or FamilyCount()
    export = html('<button type="button" id="export-all">Export all…</button>') if may_submit else Html()
    return html(BATCH, tag=batch.tag, succeeded=count.succeeded, failed=count.failed, open=count.open,
                done=count.succeeded + count.failed, total=count.total, export=export,
                bad="bad" if count.failed else "")  # fmt: skip


SELECTION = """<section id="selection" class="selection" hidden aria-label="Selection">
<strong id="selected" role="status"></strong>
<button type="button" data-action="all">Select all found</button>
<button type="button" data-action="none">Select none</button><span class="gap"></span>
<button type="button" data-action="rename">Rename…</button>
<button type="button" data-action="tag">Add a tag…</button>
<button type="button" data-action="priority">Priority…</button>
<button type="button" data-action="export">Export…</button>
<button type="button" data-action="retry">Try again</button>
<button type="button" data-action="cancel">Cancel</button>
<button type="button" data-action="delete" class="danger">Delete…</button></section>
<section id="outcome" class="card" hidden><p role="status"></p><ul></ul></section>"""

BATCH = """<section class="card batch" id="batch-head"><h2>{tag}</h2>
<div id="batch-counts" data-renewed class="row">
<progress max="{total}" value="{done}" aria-label="Families that ended"></progress>
<span><strong class="good">{succeeded}</strong> done</span><span><strong class="{bad}">{failed}</strong> failed</span>
<span><strong>{open}</strong> to go</span></div>{export}</section>"""
