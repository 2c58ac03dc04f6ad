"""`/`: the jobs, newest first, each with those below it, and a form for a new scan."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated
from urllib.parse import urlencode

from fastapi import Depends, Query, Response
from sqlalchemy import select

from ...core.recover.settings import METHODS, QUALITIES, REDRAPES
from ...core.run.units import UNITS
from ...core.scan.header import CLOUDS, FORMATS
from ..api.access import AppState, AppStateDependency
from ..families import find_below
from ..kinds.redrape_request import REDRAPE
from ..materials import list_materials
from ..models import JobRow, OwnerRow
from ..query import JobQuery, find_roots
from ..records import JobReport
from ..results import report_jobs
from ..states import State
from .markup import Html, html, join
from .page_route import make_router
from .session import VisitorOf
from .shell import Visitor, draw_shell
from .words import draw_state, draw_time, draw_verdict

router = make_router()

PAGE_FAMILY_COUNT = 50
"""Number of families on one page."""

Field = Annotated[str, Query(max_length=255)]
FILTERS = ("state", "verdict", "garment", "kind", "tag", "name")
"""Fields by which the list can be filtered, by the names of `query`, beside a condition."""


@dataclass(frozen=True)
class JobListQuery:
    """Describe a filter by fields and a condition of `query`; empty fields are ignored; only jobs before `before`."""

    state: Field = ""
    verdict: Field = ""
    garment: Field = ""
    kind: Field = ""
    tag: Field = ""
    name: Field = ""
    where: Annotated[str, Query(max_length=1000)] = ""
    before: Annotated[str, Query(max_length=16, pattern="^[0-9a-f]*$")] = ""

    @property
    def chosen(self) -> dict[str, str]:
        """Return the fields that are set."""
        return {name: value for name in FILTERS if (value := str(getattr(self, name)).strip())}


@router.get("/")
def show_jobs(rooms: AppStateDependency, visitor: VisitorOf, query: Annotated[JobListQuery, Depends()]) -> Response:
    """Return the page of the visitor's jobs."""
    chosen, where, before = query.chosen, query.where, query.before
    job_query = JobQuery(chosen, [where] if where.strip() else [])
    owner = None if visitor.caller.sees_all else visitor.caller.key
    roots = find_roots(rooms.database, job_query.conditions, PAGE_FAMILY_COUNT + 1, owner, before or None)
    families = _gather(rooms, roots[:PAGE_FAMILY_COUNT], owner)
    filters = chosen | ({"where": where} if where.strip() else {})
    has_older = len(roots) > PAGE_FAMILY_COUNT
    more = html('<a class="button" rel="next" href="/?{}">Older jobs</a>',
                urlencode(filters | {"before": roots[PAGE_FAMILY_COUNT - 1].id})) if has_older else Html()  # fmt: skip
    newest = html('<a class="button" href="/?{}">Newest jobs</a>', urlencode(filters)) if before else Html()
    content = join(
        [
            html("<h1>Jobs</h1>"),
            _draw_drop(rooms, visitor) if visitor.may_submit else Html(),
            _draw_filters(chosen | {"where": where}),
            _draw_list(families, is_filtered=bool(filters)),
            html('<p class="row">{}{}</p>', newest, more),
        ]
    )
    return draw_shell("Jobs", content, visitor, ["jobs.js"], "/")


def _gather(rooms: AppState, roots: list[JobRow], owner: str | None) -> list[list[JobReport]]:
    """Return each root with all below it that the visitor sees, in order of creation."""
    below = find_below(rooms.database, [row.id for row in roots])
    if owner is not None and below:
        seen = select(OwnerRow.job).where(OwnerRow.key == owner, OwnerRow.job.in_([row.id for row in below]))
        with rooms.database.read() as session:
            seen_jobs = set(session.scalars(seen))
        below = [row for row in below if row.id in seen_jobs]
    reports = report_jobs(rooms.database, [*roots, *below], rooms.settings)
    families: dict[str, list[JobReport]] = {}
    for report in reports:
        families.setdefault(report.family, []).append(report)
    return list(families.values())


def _draw_list(families: list[list[JobReport]], is_filtered: bool) -> Html:
    if not families:
        text = "No job matches." if is_filtered else "There are no jobs yet: drop a scan above."
        return html('<p class="card soft">{}</p>', text)
    rows = join(_draw_row(job, depth > 0) for family in families for depth, job in enumerate(family))
    return html(LIST, rows=rows)


def _draw_row(job: JobReport, is_below: bool) -> Html:
    is_alone = job.kind != REDRAPE and all(child.kind == REDRAPE for child in job.children)
    url = f"/results/{job.id}" if job.state == State.SUCCEEDED and is_alone else f"/jobs/{job.id}"
    thumbnail = Html()
    if job.state == State.SUCCEEDED:
        thumbnail = html('<img src="/jobs/{}/thumbnail" alt="" width="56" height="75" loading="lazy">', job.id)
    what = " · ".join([job.kind, ", ".join(one for one in (job.garment, job.fabric) if one)]).removesuffix(" · ")
    error = html('<span class="bad">{}</span>', job.error.message) if job.error else Html()
    tags = join((html('<span class="tag">{}</span>', tag) for tag in job.tags), " ") if not is_below else Html()
    return html(
        ROW, look=" below" if is_below else "", job=job.id, picture=thumbnail, url=url, name=job.name, what=what,
        state=draw_state(job), verdict=draw_verdict(job.verdict), created=draw_time(job.created),
        error=error, tags=tags, open="" if job.finished else " open",
    )  # fmt: skip


def _draw_filters(chosen: Mapping[str, str]) -> Html:
    def options(values: list[str], field: str) -> Html:
        return join(
            html('<option value="{}"{}>{}</option>', one, Html(" selected" if chosen.get(field, "") == one else ""),
                 one or "any") for one in ["", *values]
        )  # fmt: skip

    return html(
        FILTER, states=options([one.value for one in State], "state"), verdicts=options(VERDICTS, "verdict"),
        open=Html(" open" if any(chosen.values()) else ""),
        **{field: chosen.get(field, "") for field in ("garment", "kind", "tag", "name", "where")},
    )  # fmt: skip


def _draw_drop(rooms: AppState, visitor: Visitor) -> Html:
    fabrics = join(html('<option value="{}">{}</option>', one.name, one.title or one.name)
                   for one in list_materials(rooms.database))  # fmt: skip
    qualities = join(html("<option>{}</option>", name) for name in QUALITIES)
    methods = join(html("<option>{}</option>", name) for name in METHODS)
    units = join((html("<option>{}</option>", name) for name in UNITS), "")
    redrapes = join(html("<option>{}</option>", name) for name in REDRAPES)
    scans, bodies = ([f".{name}" for name in names] for names in ((*FORMATS, *CLOUDS), (*FORMATS, "npz", "json")))
    return html(DROP, fabrics=fabrics, qualities=qualities, methods=methods, redrapes=redrapes, units=units,
                scans=",".join(scans), bodies=",".join(bodies),
                formats=", ".join((*FORMATS, *CLOUDS)).upper())  # fmt: skip


VERDICTS = ["pass", "doubtful", "fail"]

LIST = """<div class="wide"><table class="jobs"><thead><tr><th scope="col"><span class="hushed">Picture</span></th>
<th scope="col">Job</th><th scope="col">State</th><th scope="col">Verdict</th><th scope="col">Created</th></tr></thead>
<tbody>{rows}</tbody></table></div>"""

ROW = """<tr class="job{look}{open}" data-job="{job}"><td class="picture">{picture}</td>
<td><a href="{url}">{name}</a> {tags}<br><span class="soft">{what}</span> {error}</td>
<td><a class="plain" href="/jobs/{job}">{state}</a></td><td>{verdict}</td><td class="soft">{created}</td></tr>"""

FILTER = """<details class="card filters"{open}><summary>Find jobs</summary><form method="get" action="/" class="row">
<label>State <select name="state">{states}</select></label>
<label>Verdict <select name="verdict">{verdicts}</select></label>
<label>Garment <input name="garment" value="{garment}" size="12"></label>
<label>Kind <input name="kind" value="{kind}" size="9"></label>
<label>Tag <input name="tag" value="{tag}" size="10"></label>
<label>Name <input name="name" value="{name}" size="14"></label>
<label>Condition <input name="where" value="{where}" size="30" placeholder="surface_rms_mm.t2s &lt; 4"></label>
<button type="submit">Find</button> <a href="/">All jobs</a></form></details>"""

DROP = """<form id="submit" class="card"><h2>New job</h2>
<div id="drop" class="drop"><label for="scan">Drop a scan here, or choose a file</label>
<input id="scan" name="scan" type="file" accept="{scans}" required>
<p id="told" class="soft" role="status">A raw scan of a person, or a garment: {formats}.</p>
</div>
<details><summary>Options</summary><div class="options">
<label>Name <input name="name" maxlength="255" placeholder="the file's name"></label>
<label>Tags <input name="tags" placeholder="spring, fitting"></label>
<label>The scan is <select name="as"><option value="">detected</option><option value="person">a person</option>
<option value="garment">a garment</option></select></label>
<label>Unit <select name="units"><option value="">detected</option>{units}</select></label>
<label>Up axis <select name="up"><option value="">detected</option><option>y</option><option>z</option>
<option>-y</option><option>-z</option><option>x</option><option>-x</option></select></label>
<label>Height <input name="height" type="number" min="0.5" max="2.5" step="0.01" placeholder="by the unit"></label>
<label>Body <input name="body" placeholder="builtin:female,height=1.70"></label>
<label>Body's file <input name="body_file" type="file" accept="{bodies}"></label>
<label>Labels <input name="labels" type="file" accept=".npz,.npy,.json,.txt"></label>
<label>Wearing <input name="wearing" placeholder="upper,lower"></label>
<label>Template <input name="template" placeholder="chosen from the scan"></label>
<label>Fabric <select name="fabric"><option value="">default</option>{fabrics}</select></label>
<label>Quality <select name="quality"><option value="">default</option>{qualities}</select></label>
<label>Method <select name="method"><option value="">default</option>{methods}</select></label>
<label>Re-drape <select name="redrape"><option value="">default</option>{redrapes}</select></label>
</div></details>
<p class="row"><button type="submit" class="primary">Queue the job</button><progress id="sent" max="1" value="0" hidden
 aria-label="Upload"></progress></p><div id="problem"></div>
<section id="understood" hidden aria-label="Detected in the scan"><h3>Detected in the scan</h3>
<div class="wide"><table></table></div><p id="looking" class="soft" role="status"></p></section></form>"""
