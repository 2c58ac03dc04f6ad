"""`/webhooks`: addresses that receive a message when a job ends."""

from __future__ import annotations

from fastapi import Response

from ..api.access import AppStateDependency
from ..states import ENDED
from ..webhook_records import Webhook
from ..webhooks import list_webhooks
from .actions import draw_action, draw_frame
from .markup import Html, html, join
from .page_route import make_router
from .session import VisitorOf
from .shell import draw_shell
from .words import draw_time

router = make_router()


@router.get("/webhooks")
def show_webhooks(rooms: AppStateDependency, visitor: VisitorOf) -> Response:
    """Return the page of the visitor's webhooks."""
    found = list_webhooks(rooms.database, None if visitor.caller.sees_all else visitor.caller.key)
    states = join(html('<label><input type="checkbox" name="states" value="{}"> {}</label>', one, one)
                  for one in sorted(ENDED))  # fmt: skip
    rows = join(_draw_row(one, visitor.may_submit) for one in found)
    content = html(
        PAGE, form=html(FORM, states=states) if visitor.may_submit else Html(), frame=draw_frame(),
        table=html(TABLE, rows=rows) if found else html('<p class="soft">There are no webhooks.</p>'),
    )  # fmt: skip
    return draw_shell("Webhooks", content, visitor, ["actions.js"], "/webhooks")


def _draw_row(webhook: Webhook, may_change: bool) -> Html:
    actions = join(
        [
            draw_action("Test", "POST", f"/v1/webhooks/{webhook.id}/test"),
            draw_action("Delete…", "DELETE", f"/v1/webhooks/{webhook.id}", f"Delete the webhook {webhook.url}?"),
        ],
        " ",
    )
    last = html("no message yet")
    if webhook.served is not None:
        look = "bad" if webhook.error else "good"
        last = html('{} <span class="{}">{}</span>', draw_time(webhook.served), look, webhook.error or webhook.status)
    return html(ROW, url=webhook.url, states=", ".join(webhook.states) or "every end", last=last, owed=webhook.owed,
                actions=actions if may_change else Html())  # fmt: skip


PAGE = """<h1>Webhooks</h1>{form}{frame}{table}"""

FORM = """<form class="card" data-webhook><h2>New webhook</h2><label class="long">Address
<input name="url" type="url" required maxlength="2000" placeholder="https://studio.example/garmentq"></label>
<fieldset class="row"><legend>Ends that are reported (none: all)</legend>{states}</fieldset>
<p><button type="submit" class="primary">Create the webhook</button></p></form>"""

TABLE = """<div class="wide" tabindex="0" role="region" aria-label="Webhooks"><table class="library"><thead><tr>
<th scope="col">Address</th><th scope="col">Ends</th><th scope="col">Latest message</th>
<th scope="col" class="number">To send</th><th scope="col"><span class="hushed">Actions</span></th></tr></thead>
<tbody>{rows}</tbody></table></div>"""

ROW = """<tr><th scope="row">{url}</th><td data-head="Ends">{states}</td><td data-head="Latest message">{last}</td>
<td class="number" data-head="To send">{owed}</td>
<td class="row">{actions}</td></tr>"""
