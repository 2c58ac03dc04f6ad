"""`/compare?a=JOB&b=JOB`: two results side by side, in 3D and in numbers."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated

from fastapi import Query, Response
from sqlalchemy import select

from ..api.access import AppState, AppStateDependency, find_own
from ..models import JobInputRow, JobRow, OwnerRow, SubjectJobRow
from ..query import find_jobs, parse_conditions
from ..records import JobReport
from ..results import list_files, report_jobs
from ..states import State
from .comparison import draw_comparison
from .exports_card import EXPORTABLE
from .garment_words import title_garment
from .lineage import find_person
from .markup import Html, html, join
from .page_route import make_router
from .result_views import has_view
from .session import VisitorOf
from .shell import Visitor, draw_shell
from .words import draw_time, draw_verdict

router = make_router()

JobWord = Annotated[str, Query(max_length=16)]
"""The id of a job, or the beginning of it; empty: not chosen yet."""

MAX_OFFERED_RESULTS = 30
"""Largest number of results that the page offers from each source: a person has a few, the newest of a cut are many."""


@router.get("/compare")
def show_comparison(rooms: AppStateDependency, visitor: VisitorOf, a: JobWord = "", b: JobWord = "") -> Response:
    """Return the page of two results; with one, or none, the form that chooses the other."""
    chosen = [find_own(rooms, visitor.caller, word) for word in (a.strip(), b.strip()) if word.strip()]
    reports = report_jobs(rooms.database, chosen, rooms.settings)
    first = reports[0] if reports else None
    title = "Choose another result" if len(reports) == 2 else "Choose a result"
    form = html(FORM, title=title, a=a.strip(), b=b.strip(), offered=_draw_offered(rooms, first, visitor))
    if len(reports) < 2:
        return draw_shell("Compare two results", html("<h1>Compare two results</h1>{}", form), visitor)
    one, other = reports
    sides = join(
        html(SIDE, side=side, job=job.id, name=_name(rooms, job, visitor), verdict=draw_verdict(job.verdict),
             view=_draw_space(rooms, job)) for side, job in (("First", one), ("Second", other))
    )  # fmt: skip
    match = html('<a class="button" href="/match?a={}&amp;b={}">Compare the patterns</a>', one.id, other.id)
    have_patterns = {one.kind, other.kind} <= set(EXPORTABLE)
    tables = draw_comparison(one, other)
    content = html(COMPARED, sides=sides, tables=tables, form=form, match=match if have_patterns else Html())
    return draw_shell("Compare two results", content, visitor, ["compare.js"])


def _draw_space(rooms: AppState, job: JobReport) -> Html:
    names = {file.name for file in list_files(rooms.database, job.id)}
    if not has_view(names):
        return html('<p class="soft">This result has nothing to show in 3D.</p>')
    return html('<div class="space" data-view="/results/{}/view.bin"></div>', job.id)


def _name(rooms: AppState, job: JobReport, visitor: Visitor) -> str:
    """Return a result's title with its person's name: `T-shirt · Anna Bluse`."""
    person = find_person(rooms, job, visitor)
    title = title_garment(job.garment) if job.garment else job.name
    beside = person.name if person else job.name if job.garment else ""
    return f"{title} · {beside}" if beside else title


def _draw_offered(rooms: AppState, first: JobReport | None, visitor: Visitor) -> Html:
    """Return the list of results that a result is likely compared with."""
    if first is None:
        return Html()
    found = {row.id: row for row in _find_offered(rooms, first, visitor) if row.id != first.id}
    rows = report_jobs(rooms.database, list(found.values())[:MAX_OFFERED_RESULTS], rooms.settings)
    items = join(
        html('<li><a href="/compare?a={}&amp;b={}">{}</a> <span class="soft">{}</span> {}</li>', first.id, job.id,
             _name(rooms, job, visitor), draw_time(job.created), draw_verdict(job.verdict)) for job in rows
    )  # fmt: skip
    empty = html('<p class="soft">There is no other result of this person or cut yet.</p>')
    return html('<ul class="offered">{}</ul>', items) if items else empty


def _find_offered(rooms: AppState, first: JobReport, visitor: Visitor) -> Iterator[JobRow]:
    """Yield results with a pattern that the visitor sees: of the same person, of the same subject, of the same cut."""
    caller = visitor.caller
    person = find_person(rooms, first, visitor)
    inputs = [first.id, *first.inputs.values(), *([person.id] if person else [])]
    own = SubjectJobRow.subject.in_(select(SubjectJobRow.subject).where(SubjectJobRow.job == first.id))
    readers = select(JobInputRow.job).where(JobInputRow.input.in_(inputs)).limit(MAX_OFFERED_RESULTS)
    subjects = select(SubjectJobRow.job).where(own).limit(MAX_OFFERED_RESULTS)
    with rooms.database.read() as session:
        ids = [*first.inputs.values(), *session.scalars(readers), *session.scalars(subjects)]
        statement = select(JobRow).where(JobRow.id.in_(ids), JobRow.kind.in_(EXPORTABLE))
        statement = statement.where(JobRow.state == State.SUCCEEDED)
        if not caller.sees_all:
            statement = statement.join(OwnerRow, OwnerRow.job == JobRow.id).where(OwnerRow.key == caller.key)
        related = list(session.scalars(statement.order_by(JobRow.created.desc(), JobRow.id)))
    yield from related
    if first.garment:
        conditions = parse_conditions(f'garment = "{first.garment}" and state = {State.SUCCEEDED}')
        owner = None if caller.sees_all else caller.key
        alike = find_jobs(rooms.database, conditions, limit=MAX_OFFERED_RESULTS, owner=owner)
        yield from (row for row in alike if row.kind in EXPORTABLE)


FORM = """<section class="card" id="choose"><h2>{title}</h2>{offered}
<form class="row" method="get" action="/compare"><label>First job <input name="a" value="{a}" maxlength="16" required
 autocomplete="off" spellcheck="false"></label>
<label>Second job <input name="b" value="{b}" maxlength="16" required autocomplete="off" spellcheck="false"></label>
<button type="submit" class="primary">Compare</button></form></section>"""

SIDE = """<section class="card view" aria-label="{side}"><h2>{side}: <a href="/results/{job}">{name}</a></h2>
<p class="row">{verdict}</p>{view}</section>"""

COMPARED = """<div class="head"><h1>Compare two results</h1><p class="row">{match}</p></div>
<div id="compare"><div class="views">{sides}</div>
<div class="row tools" id="camera" hidden><div class="row" role="group" aria-label="Look from">
<button type="button" data-side="front">Front</button> <button type="button" data-side="back">Back</button>
<button type="button" data-side="left">Left</button> <button type="button" data-side="right">Right</button>
<button type="button" id="turntable" aria-pressed="false">Turntable</button></div>
<label><input type="checkbox" id="bodies" checked> Bodies</label>
<span class="soft">Both turn together: drag, or Tab to a picture and press the arrows, + or -.</span></div>
<div id="problem"></div></div>{tables}{form}"""
