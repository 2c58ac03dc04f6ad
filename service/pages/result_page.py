"""`/results/ID`: a person with its garments, a garment in 3D beside its pattern, or the files of an export."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from fastapi import Response
from sqlalchemy import select

from ..api.access import AppState, AppStateDependency, find_own
from ..kinds.redrape_request import REDRAPE
from ..models import JobRow
from ..records import Artifact, JobReport
from ..refining import is_preview
from ..results import ResultMissing, list_files, report_jobs
from ..states import State
from ..submission import PERSON_KIND
from .checks_card import draw_checks
from .exports_card import EXPORT_KIND, EXPORTABLE, describe_size, draw_exports, draw_made, title_format
from .fabric_words import draw_fabric
from .facts_card import draw_facts
from .garment_words import describe_template, title_garment
from .garments_card import RECOVER_KIND, draw_garments
from .help_note import draw_heading
from .lineage import find_origin, find_person
from .markup import Html, html, join
from .measures_card import draw_measures
from .page_route import make_router
from .pictures_card import draw_pictures
from .result_views import Addresses, draw_views, has_cloth, has_view
from .session import VisitorOf
from .shares_card import draw_shares
from .shell import Visitor, draw_shell
from .stored_files import REPORT, find_file, list_pictures, read_json
from .words import draw_redrape, draw_verdict
from .worn_card import draw_worn

router = make_router()


@router.get("/results/{job}")
def show_result(job: str, rooms: AppStateDependency, visitor: VisitorOf) -> Response:
    """Return the page of one result."""
    row = find_own(rooms, visitor.caller, job)
    (report,) = report_jobs(rooms.database, [row], rooms.settings)
    files = [Artifact.from_row(one) for one in list_files(rooms.database, row.id)]
    if not files:
        raise ResultMissing(f"job {row.id} has no result yet: it is {row.state}.")
    names = {file.name for file in files}
    person = find_person(rooms, report, visitor)
    title, head = _draw_head(report, row, names, visitor, person)
    if report.kind == EXPORT_KIND:
        content = [head, draw_made(report, files, find_origin(rooms, report, visitor)), draw_measures(report)]
        return draw_shell(title, join(content), visitor)
    views = _draw_views(rooms, report, names, person)
    if report.kind == PERSON_KIND:
        garments = _list_children(rooms, report, RECOVER_KIND)
        known = [draw_worn(report, may_change=False), draw_facts(report)]
        content = [head, draw_garments(garments), views, *known, draw_checks(report.gates, report.warnings)]
    else:
        content = [head, views, _draw_known(rooms, report, visitor)]
    content += [_draw_files(report, files), draw_shares(report, visitor)]
    data = f"/results/{report.id}/view.bin" if has_view(names) else ""
    return draw_shell(title, join(content), visitor, ["result.js"], data=data)


def _list_children(rooms: AppState, job: JobReport, kind: str) -> list[JobReport]:
    """Return the jobs of a kind that a job made."""
    ids = [child.job for child in job.children if child.kind == kind]
    with rooms.database.read() as session:
        rows = session.scalars(select(JobRow).where(JobRow.id.in_(ids)).order_by(JobRow.created, JobRow.id)).all()
    return report_jobs(rooms.database, rows, rooms.settings)


def _draw_head(
    job: JobReport, row: JobRow, names: set[str], visitor: Visitor, person: JobRow | None
) -> tuple[str, Html]:
    """Return title and head of the page: `T-shirt · Anna Bluse`, with a link to the person, and what can be done."""
    own = title_garment(job.garment) if job.garment else job.name
    if job.kind == EXPORT_KIND:
        own = title_format(row.request.get("format", ""))
    beside = job.name if job.garment and person is None else ""
    link = html(' · <a href="/results/{}">{}</a>', person.id, person.name) if person else Html()
    head = html(
        HEAD, title=f"{own} · {beside}" if beside else own, link=link, verdict=draw_verdict(job.verdict),
        redrape=draw_redrape(job), what=_describe(job), links=join(_list_links(job, names, visitor), " "),
    )  # fmt: skip
    return " · ".join(one for one in (own, person.name if person else beside) if one), head


def _describe(job: JobReport) -> str:
    template = f"base pattern {describe_template(job.template)}" if job.template else ""
    fabric = f"fabric {job.fabric.replace('_', ' ')}" if job.fabric else ""
    return ", ".join(one for one in (template, fabric) if one)


def _list_links(job: JobReport, names: set[str], visitor: Visitor) -> list[Html]:
    """Return the buttons of the head."""
    links = [html('<a class="button" href="/jobs/{}">Job</a>', job.id)]
    if REPORT in names:
        links.append(html('<a class="button" href="/results/{}/report">Report</a>', job.id))
    if {"worn.npz", "pattern.json"} <= names and visitor.may_submit:
        links.append(html('<a class="button" href="/results/{}/edit">Edit the pattern</a>', job.id))
    if "labels.npz" in names:
        links.append(html('<a class="button" href="/results/{}/labels">Labels</a>', job.id))
    if "pattern.json" in names:
        links.append(html('<a class="button" href="/match?a={}">Match</a>', job.id))
    if job.kind in EXPORTABLE and job.state == State.SUCCEEDED:
        links.append(html('<a class="button" href="/compare?a={}">Compare</a>', job.id))
    if job.state == State.SUCCEEDED and is_preview(job.kind, job.settings) and visitor.may_submit:
        links.append(html('<button type="button" id="refine">Refine</button>'))
    links.append(html('<a class="button" href="/v1/jobs/{}/result.zip" download>All files (.zip)</a>', job.id))
    return links


def _draw_views(rooms: AppState, job: JobReport, names: set[str], person: JobRow | None) -> Html:
    base = f"/results/{job.id}"
    pictures = draw_pictures(base, list_pictures(rooms, job.id), has_cloth(names))
    scanned = person.id if person and job.kind == RECOVER_KIND and find_file(rooms, person.id, "scan.ply") else ""
    return draw_views(job, names, Addresses(base, job.id, scanned), pictures)


def _draw_known(rooms: AppState, job: JobReport, visitor: Visitor) -> Html:
    """Return the cards of a garment; those without content are left out."""
    fabric = draw_fabric(job.fabric, read_json(rooms, job.id, "fit.json"))
    cards = [
        draw_checks(job.gates, job.warnings),
        draw_measures(job),
        draw_exports(rooms, job, visitor),
        html('<section class="card">{}</section>', fabric) if job.garment else Html(),
        _draw_lines(read_json(rooms, job.id, "manifest.json")),
        _draw_made_from(job),
    ]
    return html('<div class="cards">{}</div>', join(card for card in cards if card))


def _draw_lines(manifest: Any) -> Html:
    """Return the section on how sure the pattern's lines are; nothing where the manifest has none."""
    from ...core.judge.line_intervals import describe_margins  # imports numpy: not at every start

    lines = manifest.get("lines") if isinstance(manifest, Mapping) else None
    if not lines:
        return Html()
    rows = join(
        html('<tr><td>{}</td><td class="number">{}</td><td>{}</td></tr>', *describe_margins(one)) for one in lines
    )
    return html(LINES, heading=draw_heading("How sure", ABOUT_LINES), count=len(lines), rows=rows)


def _draw_made_from(job: JobReport) -> Html:
    """Return links to the jobs that this one made, except its re-drape; nothing if there are none."""
    items = join(
        html('<li><a href="/{}/{}">{}</a> <span class="soft">{} {}</span></li>',
             "results" if child.state == State.SUCCEEDED else "jobs", child.job, child.name, child.kind, child.state)
        for child in job.children if child.kind != REDRAPE
    )  # fmt: skip
    return html('<section class="card"><h2>Made of this</h2><ul>{}</ul></section>', items) if items else Html()


def _draw_files(job: JobReport, files: Sequence[Artifact]) -> Html:
    rows = join(
        html('<tr><td><a href="/v1/jobs/{}/artifacts/{}" download>{}</a></td><td class="number">{}</td></tr>',
             job.id, file.name, file.name, describe_size(file.size)) for file in files
    )  # fmt: skip
    return html(FILES, rows=rows)


HEAD = """<div class="head"><h1>{title}{link}</h1><p class="row">{verdict}{redrape}<span class="soft">{what}</span></p>
<p class="row">{links}</p></div>"""

ABOUT_LINES = (
    "How far a length or a place may be from the true one: 9 of 10 lie within the interval. Where the scan does not "
    "show a line, the base pattern says where it is."
)

LINES = """<section class="card" id="lines">{heading}<details><summary>{count} seams and edges</summary>
<div class="wide" tabindex="0" role="region" aria-label="How sure"><table><tr><th scope="col">Seam or edge</th>
<th scope="col" class="number">Length</th><th scope="col">Place on the cloth</th></tr>{rows}</table></div></details>
</section>"""

FILES = """<section class="card"><details><summary>Files</summary><div class="wide"><table><thead><tr>
<th scope="col">File</th><th scope="col" class="number">Size</th></tr></thead><tbody>{rows}</tbody></table></div>
</details></section>"""
