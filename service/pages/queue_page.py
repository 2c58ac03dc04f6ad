"""`/queue`: what runs and what waits, the workers, and what keeps them from working."""

from __future__ import annotations

from dataclasses import replace

from fastapi import Response

from ..api.access import AppStateDependency
from ..api.batches import count_own
from ..database import Database
from ..health import explain, find_troubles, hide_worker_names, read_queue
from ..jobs import find_jobs_by_id
from ..models import JobRow
from ..query import JobQuery, find_jobs
from ..states import OPEN, State
from .control_words import speak_of_controls
from .markup import Html, html, join
from .page_route import make_router
from .session import VisitorOf
from .shell import draw_shell
from .words import draw_time

router = make_router()

QUEUE_ROW_COUNT = 50
"""Number of jobs of each open state that are listed."""

ORDER = {State.RUNNING: "started", State.QUEUED: "-priority", State.WAITING: "created"}
"""Open states in the order of the page, and by what the jobs of each are sorted."""


@router.get("/queue")
def show_queue(rooms: AppStateDependency, visitor: VisitorOf) -> Response:
    """Return the page of the queue; only who administers the service sees names of workers and machines."""
    caller, queue = visitor.caller, read_queue(rooms.database)
    if not caller.sees_all:
        queue = replace(hide_worker_names(queue), states=count_own(rooms, caller.key))
    owner = None if caller.sees_all else caller.key
    numbers = join(
        html('<li><strong class="figure-number">{}</strong> {}</li>', queue.states.get(state, 0), state)
        for state in (*ORDER, *(one for one in State if one not in OPEN))
    )
    alerts = find_troubles(replace(queue, outages=[])) if queue.workers else []
    if not queue.workers and any(queue.states.get(state) for state in OPEN):
        alerts = ["no worker is up, or none reaches its broker: the jobs wait until the operator starts one."]
    troubles = join(html('<p class="error" role="alert">{}</p>', one[:1].upper() + one[1:]) for one in alerts)
    outages = join(
        html('<p class="error" role="alert">Jobs wait since {}{}: {} <code>{}</code></p>', draw_time(one.since),
             f" on {one.place}" if one.place else "", speak_of_controls(explain(one.code)), one.code)
        for one in queue.outages
    )  # fmt: skip
    workers = join(
        html(WORKER, name=one.name, queues=one.queues, concurrency=one.concurrency, started=draw_time(one.started),
             seen=draw_time(one.seen)) for one in queue.workers
    )  # fmt: skip
    table = html(WORKERS, rows=workers) if queue.workers else html('<p class="soft">No worker is up.</p>')
    parts = join(_draw_jobs(rooms.database, state, order, owner) for state, order in ORDER.items())
    content = html(PAGE, numbers=numbers, troubles=join([troubles, outages]), workers=table, parts=parts)
    return draw_shell("Queue", content, visitor, ["queue.js"], "/queue")


def _draw_jobs(database: Database, state: State, order: str, owner: str | None) -> Html:
    rows = find_jobs(database, JobQuery({"state": state}).conditions, order, QUEUE_ROW_COUNT, owner)
    if not rows:
        return Html()
    roots = {row.id: row.name for row in find_jobs_by_id(database, [row.family for row in rows if row.parent])}
    shown = join(
        _draw_job(row, f"{roots[row.family]}: {row.name}" if row.family in roots else row.name) for row in rows
    )
    return html(JOBS, title=str(state).capitalize(), rows=shown, label=f"Jobs {state}")


def _draw_job(row: JobRow, name: str) -> Html:
    share = f"{row.overall:.4f}" if row.state == State.RUNNING else ""
    bar = html('<progress max="1" value="{}" aria-label="Progress of {}"></progress> {}', share, name, row.stage)
    since = row.started if row.state == State.RUNNING else row.created
    ready = (
        html(" paused until {}: <code>{}</code>", draw_time(row.not_before), row.delay_code) if row.delay_code else ""
    )
    return html(JOB, id=row.id, name=name, kind=row.kind, priority=row.priority, queue=row.queue,
                since=draw_time(since), state=bar if share else ready or Html())  # fmt: skip


PAGE = """<h1>Queue</h1><div id="queue"><ul class="numbers">{numbers}</ul>{troubles}
<section class="card"><h2>Workers</h2>{workers}</section>{parts}</div>"""

WORKERS = """<div class="wide" tabindex="0" role="region" aria-label="Workers"><table class="library"><thead><tr>
<th scope="col">Worker</th><th scope="col">Queues</th><th scope="col" class="number">Jobs at a time</th>
<th scope="col">Up since</th><th scope="col">Last seen</th></tr></thead><tbody>{rows}</tbody></table></div>"""

WORKER = """<tr><th scope="row">{name}</th><td>{queues}</td><td class="number">{concurrency}</td><td>{started}</td>
<td>{seen}</td></tr>"""

JOBS = """<section class="card"><h2>{title}</h2><div class="wide" tabindex="0" role="region" aria-label="{label}">
<table class="library"><thead><tr><th scope="col">Job</th><th scope="col">Kind</th><th scope="col">Queue</th>
<th scope="col" class="number">Priority</th><th scope="col">Since</th><th scope="col">Progress</th></tr></thead>
<tbody>{rows}</tbody></table></div></section>"""

JOB = """<tr><th scope="row"><a href="/jobs/{id}">{name}</a></th><td>{kind}</td><td>{queue}</td>
<td class="number">{priority}</td>
<td>{since}</td><td>{state}</td></tr>"""
