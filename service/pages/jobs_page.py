"""`/`: the jobs, newest first, as a gallery or a list, and the form for new scans."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated
from urllib.parse import urlencode

from fastapi import Depends, Query, Response
from fastapi.responses import JSONResponse
from sqlalchemy import select

from ..api.access import AppState, AppStateDependency
from ..batches import BatchUnknown, find_batch
from ..families import find_below
from ..gallery import read_families
from ..models import JobRow, OwnerRow
from ..query import TAG, Condition, JobQuery, find_families, find_roots
from ..records import JobReport
from ..results import report_jobs
from ..states import State
from .gallery_cards import draw_cards, is_undressed
from .jobs_list import draw_list
from .markup import Html, html, join
from .page_route import make_router
from .selection_bar import draw_batch, draw_selection
from .session import VisitorOf
from .shell import draw_shell
from .submit_form import draw_form

router = make_router()

PAGE_FAMILY_COUNT = 50
"""Number of families on one page of gallery or list."""

MAX_SELECTED_FAMILIES = 5000
"""Largest number of families that are selected at once; each is changed by a request of its own."""

Field = Annotated[str, Query(max_length=255)]
LIST_VIEW = "list"
"""Value of `view` for the list; the gallery is the page's usual view."""

FILTERS = ("state", "verdict", "garment", "kind", "tag", "name")
"""Fields by which the list can be filtered, by the names of `query`, beside a condition."""


@dataclass(frozen=True)
class JobListQuery:
    """Describe a filter by fields and a condition of `query`; empty fields are ignored; only jobs before `before`.

    `view` is `list` or empty; with `bodies` persons without a garment are shown, too.
    """

    state: Field = ""
    verdict: Field = ""
    garment: Field = ""
    kind: Field = ""
    tag: Field = ""
    name: Field = ""
    where: Annotated[str, Query(max_length=1000)] = ""
    before: Annotated[str, Query(max_length=16, pattern="^[0-9a-f]*$")] = ""
    view: Annotated[str, Query(pattern=f"^({LIST_VIEW})?$")] = ""
    bodies: Annotated[str, Query(pattern="^1?$")] = ""

    @property
    def chosen(self) -> dict[str, str]:
        """Return the fields that are set."""
        return {name: value for name in FILTERS if (value := str(getattr(self, name)).strip())}

    @property
    def is_filtered(self) -> bool:
        """Return whether a field or a condition is set."""
        return bool(self.chosen or self.where.strip())

    @property
    def conditions(self) -> list[Condition]:
        """Return every condition of the filter.

        Raises:
            QueryBad: if one cannot be parsed.
        """
        return JobQuery(self.chosen, [self.where] if self.where.strip() else []).conditions

    def link(self, **changes: str) -> str:
        """Return the address of this page with some of its fields changed."""
        fields = self.chosen | {name: getattr(self, name).strip() for name in ("where", "before", "view", "bodies")}
        found = {name: value for name, value in (fields | changes).items() if value}
        return f"/?{urlencode(found)}" if found else "/"


@router.get("/")
def show_jobs(rooms: AppStateDependency, visitor: VisitorOf, query: Annotated[JobListQuery, Depends()]) -> Response:
    """Return the page of the visitor's jobs, as a gallery or as a list."""
    owner = None if visitor.caller.sees_all else visitor.caller.key
    is_list = query.view == LIST_VIEW
    shown, older = _draw_table(rooms, query, owner) if is_list else _draw_gallery(rooms, query, owner)
    if not shown:
        shown = _draw_nothing(query, visitor.may_submit)
    more = html('<a class="button" rel="next" href="{}">Older jobs</a>', query.link(before=older)) if older else Html()
    newest = html('<a class="button" href="{}">Newest jobs</a>', query.link(before="")) if query.before else Html()
    content = join(
        [
            html('<div class="bar"><h1>{}</h1>{}</div>', "Jobs" if is_list else "Gallery", _draw_views(query)),
            draw_form(rooms) if visitor.may_submit else Html(),
            _draw_filters(query.chosen | {"where": query.where}, query.view),
            _draw_batch(rooms, query, owner, visitor.may_submit),
            shown,
            html('<p class="row">{}{}</p>', newest, more),
            draw_selection() if visitor.may_submit else Html(),
        ]
    )
    return draw_shell("Jobs", content, visitor, ["jobs.js"], "/")


@router.get("/selection")
def list_selection(
    rooms: AppStateDependency, visitor: VisitorOf, query: Annotated[JobListQuery, Depends()]
) -> JSONResponse:
    """Return ids and names of all families that the filter finds, on whatever page they are."""
    owner = None if visitor.caller.sees_all else visitor.caller.key
    if query.view == LIST_VIEW:
        rows = find_roots(rooms.database, query.conditions, MAX_SELECTED_FAMILIES, owner)
        found = [(row.id, row.name) for row in rows]
    else:
        found = find_families(rooms.database, query.conditions, MAX_SELECTED_FAMILIES, owner)
    return JSONResponse({"families": [{"job": job, "name": name} for job, name in found]})


def _draw_batch(rooms: AppState, query: JobListQuery, owner: str | None, may_submit: bool) -> Html:
    """Return the head of the tag by which the list is filtered; nothing where there is none, or no job has it."""
    try:
        batch = find_batch(rooms.database, query.chosen[TAG], owner)
    except (KeyError, BatchUnknown):
        return Html()
    return draw_batch(batch, may_submit)


def _draw_gallery(rooms: AppState, query: JobListQuery, owner: str | None) -> tuple[Html, str]:
    """Return the cards of a page, and the root after which the next one begins; empty texts where there is none."""
    roots = find_families(rooms.database, query.conditions, PAGE_FAMILY_COUNT + 1, owner, query.before or None)
    shown = [root for root, _ in roots[:PAGE_FAMILY_COUNT]]
    families = read_families(rooms.database, shown, owner)
    cards = draw_cards(families, bool(query.bodies)) if families else Html()
    if query.bodies or any(map(is_undressed, families)):
        url, verb = (query.link(bodies=""), "Hide") if query.bodies else (query.link(bodies="1"), "Show")
        cards = html("{}{}", cards, html(BODIES, url=url, verb=verb))
    return cards, shown[-1] if len(roots) > PAGE_FAMILY_COUNT else ""


def _draw_table(rooms: AppState, query: JobListQuery, owner: str | None) -> tuple[Html, str]:
    """Return the list of a page, and the root after which the next one begins; empty texts where there is none."""
    roots = find_roots(rooms.database, query.conditions, PAGE_FAMILY_COUNT + 1, owner, query.before or None)
    shown = roots[:PAGE_FAMILY_COUNT]
    rows = draw_list(_gather(rooms, shown, owner)) if shown else Html()
    return rows, shown[-1].id if len(roots) > PAGE_FAMILY_COUNT else ""


def _draw_nothing(query: JobListQuery, may_submit: bool) -> Html:
    if not query.is_filtered:
        next_step = ": drop a scan above." if may_submit else "."
        return html('<p class="card soft" id="jobs">There are no jobs yet{}</p>', next_step)
    if query.view == LIST_VIEW:
        return html('<p class="card soft" id="jobs">No job matches. <a href="/?view=list">All jobs</a></p>')
    return html(NOTHING, url=query.link(view=LIST_VIEW, before=""))


def _draw_views(query: JobListQuery) -> Html:
    """Return the links between gallery and list; the filter stays."""
    one = '<a href="{}"{}>{}</a>'
    links = [
        html(one, query.link(view=view, before=""), Html(' aria-current="true"' if query.view == view else ""), name)
        for view, name in (("", "Gallery"), (LIST_VIEW, "List"))
    ]
    return html('<div class="toggle" role="group" aria-label="View">{}</div>', join(links))


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


def _draw_filters(chosen: Mapping[str, str], view: str) -> Html:
    def options(values: list[str], field: str) -> Html:
        return join(
            html('<option value="{}"{}>{}</option>', one, Html(" selected" if chosen.get(field, "") == one else ""),
                 one or "any") for one in ["", *values]
        )  # fmt: skip

    return html(
        FILTER, states=options([one.value for one in State], "state"), verdicts=options(VERDICTS, "verdict"),
        open=Html(" open" if any(text for name, text in chosen.items() if name != TAG) else ""), view=view,
        all=f"/?view={view}" if view else "/",
        **{field: chosen.get(field, "") for field in ("garment", "kind", "tag", "name", "where")},
    )  # fmt: skip


VERDICTS = ["pass", "doubtful", "fail"]

NOTHING = """<p class="card soft" id="jobs">No person or garment matches.
<a href="{url}">Look in the list of all jobs</a></p>"""

BODIES = """<p><a class="button" href="{url}">{verb} pictures of persons without a garment</a></p>"""

FILTER = """<details class="card filters"{open}><summary>Find jobs</summary><form method="get" action="/" class="row">
<label>State <select name="state">{states}</select></label>
<label>Verdict <select name="verdict">{verdicts}</select></label>
<label>Garment <input name="garment" value="{garment}" size="12"></label>
<label>Kind <input name="kind" value="{kind}" size="9"></label>
<label>Tag <input name="tag" value="{tag}" size="10"></label>
<label>Name <input name="name" value="{name}" size="14"></label>
<label>Condition <input name="where" value="{where}" size="30" placeholder="surface_rms_mm.t2s &lt; 4"></label>
<input type="hidden" name="view" value="{view}"><button type="submit">Find</button>
<a href="{all}">All jobs</a></form></details>"""
