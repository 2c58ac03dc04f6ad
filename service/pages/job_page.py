"""`/jobs/ID`: the progress of a job, and what was detected in its files."""

from __future__ import annotations

from fastapi import Response

from ..api.access import AppStateDependency, find_own
from ..records import JobReport
from ..refining import is_preview
from ..results import list_files, report_jobs
from ..states import UNSUCCESSFUL, State
from ..submission import PERSON_KIND
from .checks_card import draw_checks
from .control_words import speak_of_controls
from .facts_card import draw_facts
from .markup import Html, html, join
from .page_route import make_router
from .session import VisitorOf
from .shell import Visitor, draw_shell
from .words import (
    draw_family,
    draw_redrape,
    draw_state,
    draw_time,
    draw_verdict,
    is_ended,
)
from .worn_card import draw_worn

router = make_router()

MATCHABLE = ("recover", "dress", "refit", "edit")
"""Kinds of jobs whose pattern can be compared with another one."""


@router.get("/jobs/{job}")
def show_job(job: str, rooms: AppStateDependency, visitor: VisitorOf) -> Response:
    """Return the page of one job."""
    row = find_own(rooms, visitor.caller, job)
    (report,) = report_jobs(rooms.database, [row], rooms.settings)
    has_files = any(True for _ in list_files(rooms.database, row.id))
    content = join(
        [
            html("<h1>{}</h1>", report.name),
            _draw_progress(report, visitor, has_files),
            draw_worn(report, visitor.may_submit),
            draw_facts(report),
            draw_family(report),
            draw_checks(report.gates),
            html('<details class="card"{}><summary>Events</summary><ol id="events"></ol></details>',
                 Html("" if is_ended(report) else " open")),
        ]
    )  # fmt: skip
    return draw_shell(report.name, content, visitor, ["job.js"])


def _draw_progress(job: JobReport, visitor: Visitor, has_files: bool) -> Html:
    may_change = visitor.may_submit
    buttons = []
    if may_change and not is_ended(job):
        buttons.append(html('<button type="button" id="cancel">Cancel</button>'))
    failed_below = any(child.state in UNSUCCESSFUL for child in job.children)
    if may_change and (job.state in UNSUCCESSFUL or failed_below):
        buttons.append(html('<button type="button" id="retry" class="primary">Try again</button>'))
    if may_change and job.state == State.SUCCEEDED and is_preview(job.kind, job.settings):
        buttons.append(html('<button type="button" id="refine">Refine</button>'))
    if has_files:
        buttons.append(html('<a class="button primary" href="/results/{}">Result</a>', job.id))
    if has_files and job.kind == PERSON_KIND:
        buttons.append(html('<a class="button" href="/results/{}/labels">Labels</a>', job.id))
    if has_files and job.kind in MATCHABLE:
        buttons.append(html('<a class="button" href="/match?a={}">Compare</a>', job.id))
    error = Html()
    if job.error:
        error = html(
            '<p class="error" role="alert">{} <code>{}</code></p>', speak_of_controls(job.error.message), job.error.code
        )
    verdict = join([draw_verdict(job.verdict), draw_redrape(job)])
    return html(
        PROGRESS, job=job.id, state=draw_state(job), verdict=verdict, kind=job.kind,
        created=draw_time(job.created), stage=job.stage, fraction=f"{job.overall or job.progress:.4f}", error=error,
        hidden=Html(" hidden" if is_ended(job) else ""), ended="1" if is_ended(job) else "",
        delay=html('<p class="doubt">Paused: {}.</p>', job.delay.code) if job.delay else Html(),
        buttons=join(buttons, " "), tags=join((html('<span class="tag">{}</span>', tag) for tag in job.tags), " "),
        warnings=join(html('<p class="doubt">{}</p>', speak_of_controls(text)) for text in job.warnings),
    )  # fmt: skip


PROGRESS = """<section class="card" id="job" data-job="{job}" data-ended="{ended}">
<p class="row"><span id="state">{state}</span>{verdict}<span class="soft">{kind}, created {created}</span>{tags}</p>
<p{hidden} id="running"><progress id="progress" max="1" value="{fraction}" aria-label="Progress"></progress>
<span id="stage" role="status">{stage}</span></p>
{error}{delay}{warnings}
<p class="row">{buttons}</p><div id="problem"></div></section>"""
