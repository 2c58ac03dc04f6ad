"""`/keys`: the API keys, for who administers the service."""

from __future__ import annotations

from fastapi import Response

from ..api.access import AppStateDependency
from ..keys import DEFAULT_JOB_QUOTA, SCOPES, list_keys
from ..records import Key
from .actions import draw_action, draw_frame
from .markup import Html, html, join
from .page_route import make_router
from .session import VisitorOf
from .shell import draw_shell
from .words import draw_time

router = make_router()


@router.get("/keys")
def show_keys(rooms: AppStateDependency, visitor: VisitorOf) -> Response:
    """Return the page of keys."""
    visitor.caller.check_scope("admin")
    keys = [Key.from_row(row) for row in list_keys(rooms.database)]
    rows = join(map(_draw_row, sorted(keys, key=lambda key: (key.revoked is not None, -key.created))))
    scopes = join(html('<label><input type="checkbox" name="scopes" value="{}"{}> {}</label>', one,
                       Html(" checked") if one in ("read", "submit") else Html(), one) for one in SCOPES)  # fmt: skip
    empty = Html() if keys else html('<p class="soft">There are no keys: only this machine may use the service.</p>')
    content = html(PAGE, scopes=scopes, quota=DEFAULT_JOB_QUOTA, rows=rows, empty=empty,
                   first=Html() if keys else html(FIRST), frame=draw_frame())  # fmt: skip
    return draw_shell("Keys", content, visitor, ["actions.js"], "/keys")


def _draw_row(key: Key) -> Html:
    question = f"Revoke the key {key.name}? Its programs and browsers are refused at once; its jobs stay."
    revoke = draw_action("Revoke…", "DELETE", f"/v1/keys/{key.id}", question)
    ended = (
        html('<span class="bad">revoked</span> {}', draw_time(key.revoked)) if key.revoked else draw_time(key.expires)
    )
    return html(
        ROW, name=key.name, id=key.id, scopes=", ".join(key.scopes), quota=key.quota, priority=key.priority,
        created=draw_time(key.created), used=draw_time(key.used), ended=ended, revoke=Html() if key.revoked else revoke,
    )  # fmt: skip


FIRST = """<p class="soft">The first key ends the use without one; give it admin, or this page is closed to you.</p>"""

PAGE = """<h1>Keys</h1><form class="card" data-key><h2>New key</h2><div class="options">
<label>Name <input name="name" required maxlength="255"></label>
<label>Open jobs <input name="quota" type="number" min="1" max="1000000" value="{quota}"></label>
<label>Highest priority <input name="priority" type="number" min="0" max="100" value="0"></label>
<label>Days until it expires <input name="days" type="number" min="1" max="36500" placeholder="never"></label></div>
<fieldset class="row"><legend>It may</legend>{scopes}</fieldset>
{first}
<p><button type="submit" class="primary">Create the key</button></p></form>{frame}
{empty}<div class="wide" tabindex="0" role="region" aria-label="Keys"><table class="library"><thead><tr>
<th scope="col">Key</th><th scope="col">May</th><th scope="col" class="number">Open jobs</th>
<th scope="col" class="number">Priority</th><th scope="col">Created</th><th scope="col">Used</th>
<th scope="col">Expires</th><th scope="col"><span class="hushed">Actions</span></th></tr></thead>
<tbody>{rows}</tbody></table></div>"""

ROW = """<tr><th scope="row">{name}<br><code class="soft">{id}</code></th><td data-head="May">{scopes}</td>
<td class="number" data-head="Open jobs">{quota}</td><td class="number" data-head="Priority">{priority}</td>
<td data-head="Created">{created}</td><td data-head="Used">{used}</td><td data-head="Expires">{ended}</td>
<td>{revoke}</td></tr>"""
