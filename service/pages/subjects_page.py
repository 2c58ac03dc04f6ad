"""`/subjects` and `/subjects/ID`: the persons who were scanned, with consent, retention and jobs."""

from __future__ import annotations

from typing import Annotated

from fastapi import Query, Response

from ..api.access import AppStateDependency
from ..gallery import read_families
from ..subject_records import Subject, SubjectFields, SubjectReport
from ..subjects import find_subject, list_subjects
from .actions import draw_action, draw_frame
from .gallery_cards import draw_cards
from .markup import Html, html, join
from .page_route import make_router
from .session import VisitorOf
from .shell import Visitor, draw_shell
from .words import draw_time

router = make_router()

PAGE_SUBJECT_COUNT = 50
"""Number of subjects on one page."""

NO_SUBJECT = SubjectFields("")
"""Fields of a form for a new subject."""


@router.get("/subjects")
def show_subjects(
    rooms: AppStateDependency,
    visitor: VisitorOf,
    name: Annotated[str, Query(max_length=255)] = "",
    before: Annotated[str, Query(pattern="^([0-9a-f]{12})?$")] = "",
) -> Response:
    """Return the page of the visitor's subjects, the newest first."""
    found = list_subjects(rooms.database, name.strip(), PAGE_SUBJECT_COUNT + 1, before, _find_realm(visitor))
    rows = join(map(_draw_row, found[:PAGE_SUBJECT_COUNT]))
    older = Html()
    if len(found) > PAGE_SUBJECT_COUNT:
        last = found[PAGE_SUBJECT_COUNT - 1].id
        older = html('<p><a class="button" rel="next" href="/subjects?before={}">Older subjects</a></p>', last)
    content = html(
        LIST, name=name, older=older, frame=draw_frame(),
        form=_draw_form(NO_SUBJECT, "", "New subject") if visitor.may_submit else Html(),
        table=html(TABLE, rows=rows) if found else html('<p class="soft">There is no such subject.</p>'),
    )  # fmt: skip
    return draw_shell("Subjects", content, visitor, ["actions.js"], "/subjects")


@router.get("/subjects/{subject}")
def show_subject(subject: str, rooms: AppStateDependency, visitor: VisitorOf) -> Response:
    """Return the page of one subject."""
    found = find_subject(rooms.database, subject[:12], _find_realm(visitor))
    owner = None if visitor.caller.sees_all else visitor.caller.key
    families = read_families(rooms.database, [one.job for one in found.families], owner)
    scans = join(
        html('<tr><th scope="row">{}</th><td class="number">{:.1f}</td><td>{}</td></tr>', one.name, 1e-6 * one.size,
             draw_time(one.created)) for one in found.scans
    )  # fmt: skip
    content = html(
        ONE, name=found.name, facts=_draw_facts(found), frame=draw_frame(),
        form=_draw_form(found.said, found.id, "Consent and retention") if visitor.may_submit else Html(),
        delete=_draw_deletion(found) if visitor.may_submit else Html(),
        cards=draw_cards(families, has_bodies=False) if families else html('<p class="soft">It has no jobs.</p>'),
        scans=html(SCANS, rows=scans) if found.scans else Html(),
    )  # fmt: skip
    return draw_shell(found.name, content, visitor, ["actions.js"], "/subjects")


def _find_realm(visitor: Visitor) -> str | None:
    return None if visitor.caller.sees_all else visitor.caller.key


def _draw_row(subject: Subject) -> Html:
    return html(
        ROW, id=subject.id, name=subject.name, jobs=subject.jobs, consented=draw_time(subject.consented),
        until=draw_time(subject.consent_until), expires=draw_time(subject.expires), created=draw_time(subject.created),
    )  # fmt: skip


def _draw_facts(subject: SubjectReport) -> Html:
    expires = html("All its data are deleted {}.", draw_time(subject.expires))
    kept = expires if subject.expires is not None else html("Its data are kept until somebody deletes them.")
    return html('<p class="soft">{} jobs, created {}. {}</p>', subject.jobs, draw_time(subject.created), kept)


def _draw_deletion(subject: SubjectReport) -> Html:
    question = (
        f"Delete {subject.name} with all data? {len(subject.scans)} scans, {subject.jobs} jobs and all that was made "
        "of them are deleted. This cannot be undone."
    )
    return draw_action("Delete the person's data…", "DELETE", f"/v1/subjects/{subject.id}", question, "/subjects")


def _draw_form(said: SubjectFields, subject: str, title: str) -> Html:
    times = {name: "" if getattr(said, name) is None else f"{getattr(said, name):.0f}" for name in TIMES}
    days = "" if said.keep_days is None else f"{said.keep_days:g}"
    return html(FORM, subject=subject, title=title, name=said.name, note=said.note, consent=said.consent, days=days,
                button="Save" if subject else "Create the subject", **times)  # fmt: skip


TIMES = ("consented", "consent_until", "keep_until")
"""Fields that are dates."""

LIST = """<h1>Subjects</h1>{form}{frame}<form method="get" action="/subjects" class="row card">
<label>Exact name <input name="name" value="{name}" maxlength="255"></label><button type="submit">Find</button>
<a href="/subjects">All subjects</a></form>{table}{older}"""

TABLE = """<div class="wide" tabindex="0" role="region" aria-label="Subjects"><table class="library"><thead><tr>
<th scope="col">Subject</th><th scope="col" class="number">Jobs</th><th scope="col">Agreed</th>
<th scope="col">Until</th>
<th scope="col">Data deleted</th><th scope="col">Created</th></tr></thead><tbody>{rows}</tbody></table></div>"""

ROW = """<tr><th scope="row"><a href="/subjects/{id}">{name}</a></th><td class="number" data-head="Jobs">{jobs}</td>
<td data-head="Agreed">{consented}</td><td data-head="Until">{until}</td><td data-head="Data deleted">{expires}</td>
<td data-head="Created">{created}</td></tr>"""

ONE = """<div class="bar"><h1>{name}</h1>{delete}</div>{facts}{frame}{cards}{form}{scans}"""

SCANS = """<section class="card"><h2>Scans</h2><div class="wide" tabindex="0" role="region" aria-label="Scans">
<table class="library"><thead><tr><th scope="col">File</th><th scope="col" class="number">MB</th>
<th scope="col">Stored</th></tr></thead><tbody>{rows}</tbody></table></div></section>"""

FORM = """<details class="card"><summary>{title}</summary><form data-subject="{subject}"><div class="options">
<label>Name <input name="name" required maxlength="255" value="{name}"></label>
<label>Agreed to be scanned <input name="consented" type="date" data-seconds="{consented}"></label>
<label>Where that is written <input name="consent" maxlength="255" value="{consent}"></label>
<label>Agreed until <input name="consent_until" type="date" data-seconds="{consent_until}"></label>
<label>Days that data are kept after the newest job <input name="keep_days" type="number" min="1" max="36500"
 value="{days}"></label>
<label>Data kept until, at most <input name="keep_until" type="date" data-seconds="{keep_until}"></label>
<label>Note <textarea name="note" maxlength="10000" rows="2">{note}</textarea></label></div>
<p><button type="submit" class="primary">{button}</button></p></form></details>"""
