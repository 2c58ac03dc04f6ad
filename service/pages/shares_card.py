"""The card that makes, lists and revokes links to a result."""

from __future__ import annotations

from ..records import JobReport
from ..share_records import DEFAULT_SHARE_DAYS, SHARE_DAYS
from ..states import State
from .markup import Html, html, join
from .shell import Visitor


def draw_shares(job: JobReport, visitor: Visitor) -> Html:
    """Return the card of a result's links; empty if the visitor may not make any."""
    if not visitor.may_submit or job.state != State.SUCCEEDED:
        return Html()
    days = join(
        html('<option value="{}"{}>{}</option>', one, Html(" selected" if one == DEFAULT_SHARE_DAYS else ""),
             f"{one} day{'s' if one > 1 else ''}") for one in SHARE_DAYS
    )  # fmt: skip
    return html(SHARES, days=days)


SHARES = """<details class="card" id="shares"><summary>Share</summary>
<p>A link shows the garment, its pattern, its measures and its PDF to whoever has it, but neither the body nor other
jobs. It needs no key, and can be revoked.</p>
<form class="row"><label>Valid for <select>{days}</select></label><button type="submit">Make a link</button></form>
<p role="status"></p><div class="problem"></div><ul></ul></details>"""
