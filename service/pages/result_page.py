"""`/results/ID`: a job's result in 3D beside its pattern; without WebGL its pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from fastapi import Response
from sqlalchemy import select

from ..api.access import AppState, AppStateDependency, find_own
from ..jobs import JobUnknown
from ..kinds.recover_request import PERSON
from ..models import JobInputRow, JobRow, OwnerRow
from ..records import Artifact, JobReport
from ..refining import is_preview
from ..results import ResultMissing, list_files, report_jobs
from ..share_records import DEFAULT_SHARE_DAYS, SHARE_DAYS
from ..states import State
from .fabric_words import draw_fabric
from .markup import Html, html, join
from .measures_card import draw_measures
from .page_route import make_router
from .session import VisitorOf
from .shell import Visitor, draw_shell
from .shown_meshes import BODY, SCANS, WORN, WORN_TOGETHER, is_companion_mesh, list_shown
from .stored_files import REPORT, find_file, list_pictures, read_json
from .words import draw_family, draw_gates, draw_redrape, draw_verdict

router = make_router()

STYLES = {
    "cloth": "Cloth",
    "texture": "Texture",
    "normals": "Fold normals",
    "distance": "Distance from the scan",
    "inferred": "Inferred, not scanned",
    "strain": "Stretch",
    "pressure": "Pressure",
}
"""Colourings of the cloth."""

EXPORTABLE = ("recover", "dress", "refit", "drape", "edit")
"""Kinds of jobs whose results have a pattern to export; the service refuses others."""


@router.get("/results/{job}")
def show_result(job: str, rooms: AppStateDependency, visitor: VisitorOf) -> Response:
    """Return the page of one result."""
    row = find_own(rooms, visitor.caller, job)
    (report,) = report_jobs(rooms.database, [row], rooms.settings)
    files = [Artifact.from_row(one) for one in list_files(rooms.database, row.id)]
    if not files:
        raise ResultMissing(f"job {row.id} has no result yet: it is {row.state}.")
    names = {file.name for file in files}
    content = join(
        [
            _draw_head(report, names, visitor),
            _draw_views(rooms, report, names, _find_person(rooms, report, visitor)),
            draw_family(report),
            _draw_known(rooms, report),
            draw_measures(report),
            _draw_files(rooms, report, files, visitor),
            _draw_shares(report, visitor),
        ]
    )
    data = f"/results/{report.id}/view.bin" if _has_view(names) else ""
    return draw_shell(report.name, content, visitor, ["result.js"], data=data)


def _draw_head(job: JobReport, names: set[str], visitor: Visitor) -> Html:
    links = [html('<a class="button" href="/jobs/{}">Job</a>', job.id)]
    if REPORT in names:
        links.append(html('<a class="button" href="/results/{}/report">Report</a>', job.id))
    if {"worn.npz", "pattern.json"} <= names and visitor.may_submit:
        links.append(html('<a class="button" href="/results/{}/edit">Edit the pattern</a>', job.id))
    if "labels.npz" in names:
        links.append(html('<a class="button" href="/results/{}/labels">Labels</a>', job.id))
    if "pattern.json" in names:
        links.append(html('<a class="button" href="/match?a={}">Match</a>', job.id))
    if job.state == State.SUCCEEDED and is_preview(job.kind, job.settings) and visitor.may_submit:
        links.append(html('<button type="button" id="refine">Refine</button>'))
    links.append(html('<a class="button" href="/v1/jobs/{}/result.zip" download>All files (.zip)</a>', job.id))
    what = ", ".join(one for one in (job.garment, job.template, job.fabric) if one)
    head = '<div class="head"><h1>{}</h1><p class="row">{}{}<span class="soft">{}</span></p><p class="row">{}</p></div>'
    return html(head, job.name, draw_verdict(job.verdict), draw_redrape(job), what, join(links, " "))


def _draw_shares(job: JobReport, visitor: Visitor) -> Html:
    """Return the card that makes and revokes links to a result; empty if the visitor may not."""
    if not visitor.may_submit or job.state != State.SUCCEEDED:
        return Html()
    days = join(
        html('<option value="{}"{}>{}</option>', one, Html(" selected" if one == DEFAULT_SHARE_DAYS else ""),
             f"{one} day{'s' if one > 1 else ''}") for one in SHARE_DAYS
    )  # fmt: skip
    return html(SHARES, days=days)


def _has_view(names: set[str]) -> bool:
    """Return whether `view.bin` has any content."""
    return bool(set(list_shown(names)) - set(SCANS)) or WORN in names


def _find_person(rooms: AppState, job: JobReport, visitor: Visitor) -> str:
    """Return the job of the garment's person if the visitor may see its scan; else an empty text."""
    try:
        row = find_own(rooms, visitor.caller, job.inputs.get(PERSON, ""))
    except JobUnknown:
        return ""
    return row.id if find_file(rooms, row.id, "scan.ply") else ""


def _draw_views(rooms: AppState, job: JobReport, names: set[str], person: str) -> Html:
    there = list_shown(names)
    cloth = [name for name in there if not is_companion_mesh(name)]
    titles = there | ({PERSON_SCAN: "The person's scan"} if person else {})
    shown = {*cloth[:1], *WORN_TOGETHER, *_find_wearer(cloth)} if cloth else {"scan"} if "scan" in there else {BODY}
    boxes = join(
        html('<label><input type="checkbox" data-mesh="{}"{}{}> {}</label>', name,
             Html("" if name in cloth else " data-beside"), Html(" checked" if name in shown else ""), title)
        for name, title in titles.items()
    )  # fmt: skip
    styles = join(html('<option value="{}">{}</option>', name, title) for name, title in STYLES.items())
    pictures = join(
        html('<figure><img src="/results/{}/pictures/{}" alt="{}" loading="lazy"><figcaption>{}</figcaption></figure>',
             job.id, number, one.title, one.title) for number, one in enumerate(list_pictures(rooms, job.id))
    )  # fmt: skip
    return html(
        VIEWS, job=job.id, person=person, files=" ".join(sorted(names & VIEW_FILES)), boxes=boxes, styles=styles,
        pictures=pictures, uncoloured=_explain_missing_colours(job),
        packed=Html(" data-packed") if _has_view(names) else Html(),
        cloth=Html() if cloth else Html(" hidden"),
        flat=Html() if WORN in names else Html(" hidden"),
        player=Html() if "garment.pc2" in names else Html(" hidden"),
        solid=Html() if there else Html(" hidden"), hidden=Html(" hidden" if cloth else ""),
    )  # fmt: skip


def _find_wearer(cloth: Sequence[str]) -> tuple[str, ...]:
    """Return the possible names of the wearer of the first shown mesh: of one size, or the only one."""
    return BODY, f"{BODY}_{cloth[0].partition('_')[2]}"


PERSON_SCAN = "person"
"""Name of the person's scan on the page."""


def _explain_missing_colours(job: JobReport) -> str:
    """Return why a result has no colours."""
    checked = job.details.get("checked") or {}
    scan = checked.get("scan") if isinstance(checked, Mapping) else None
    if isinstance(scan, Mapping) and scan.get("has_colours"):
        return "No texture: the result was stored by a version without colours; submit its scan again."
    return f"No texture: {'the scan has no colours' if job.kind == 'recover' else 'only a recovery has one'}."


VIEW_FILES = {WORN, "garment.pc2", "body.pc2", "frames.json"}
"""Files whose presence the page's script checks."""


def _draw_known(rooms: AppState, job: JobReport) -> Html:
    warnings = join(html('<p class="doubt">{}</p>', text) for text in job.warnings)
    checks = html("<h2>Checks</h2>{}{}", warnings, draw_gates(job.gates))
    if not job.garment:
        return html('<section class="card">{}</section>', checks) if job.warnings or job.gates else Html()
    fabric = draw_fabric(job.fabric, read_json(rooms, job.id, "fit.json"))
    both = '<div class="pair"><section class="card">{}</section><section class="card">{}</section></div>{}'
    return html(both, fabric, checks, _draw_lines(read_json(rooms, job.id, "manifest.json")))


def _draw_lines(manifest: Any) -> Html:
    """Return the section on how sure the pattern's lines are; nothing where the manifest has none."""
    from ...core.judge.line_intervals import describe_margins  # imports numpy: not at every start

    lines = manifest.get("lines") if isinstance(manifest, dict) else None
    if not lines:
        return Html()
    rows = join(
        html('<tr><td>{}</td><td class="number">{}</td><td>{}</td></tr>', *describe_margins(one)) for one in lines
    )
    head = html("<tr><th>Seam or edge</th><th>Length</th><th>Place on the cloth</th></tr>")
    return html('<section class="card"><h2>How sure</h2><table>{}{}</table></section>', head, rows)


def _draw_files(rooms: AppState, job: JobReport, files: Sequence[Artifact], visitor: Visitor) -> Html:
    rows = join(
        html('<tr><td><a href="/v1/jobs/{}/artifacts/{}" download>{}</a></td><td class="number">{}</td></tr>',
             job.id, file.name, file.name, f"{file.size:,}".replace(",", " ")) for file in files
    )  # fmt: skip
    return html(FILES, rows=rows, exports=_draw_exports(rooms, job, visitor))


def _draw_exports(rooms: AppState, job: JobReport, visitor: Visitor) -> Html:
    if job.kind not in EXPORTABLE or job.state != State.SUCCEEDED:
        return Html()
    from ...core.deliver.formats.registry import DESCRIPTIONS  # imports scipy: not at every start

    made = [
        html('<li><a href="/results/{}">{}</a> <span class="soft">{}</span></li>', one.id,
             one.request.get("format", "export"), one.state)
        for one in _find_exports(rooms, job.id, visitor)
    ]  # fmt: skip
    buttons = join(
        html('<button type="button" data-export="{}" title="{}">{}</button>', name, title, name.upper())
        for name, title in DESCRIPTIONS.items()
    )
    offered = html('<p class="row">{}</p><div id="exported" role="status"></div>', buttons)
    return html("<h2>Exports</h2>{}<ul>{}</ul>", offered if visitor.may_submit else Html(), join(made))


def _find_exports(rooms: AppState, job: str, visitor: Visitor) -> list[Any]:
    """Return the exports of a result that the visitor sees, newest first."""
    statement = select(JobRow).join(JobInputRow, JobInputRow.job == JobRow.id)
    statement = statement.where(JobInputRow.input == job, JobRow.kind == "export")
    if not visitor.caller.sees_all:
        statement = statement.join(OwnerRow, OwnerRow.job == JobRow.id).where(OwnerRow.key == visitor.caller.key)
    with rooms.database.read() as session:
        return list(session.scalars(statement.order_by(JobRow.created.desc(), JobRow.id).limit(20)))


VIEWS = """<div id="result" data-job="{job}" data-person="{person}" data-files="{files}"{packed}>
<div class="views"><section class="card view"{solid} aria-label="3D"><div class="row tools">
<fieldset class="row"><legend>Shown</legend>{boxes}</fieldset>
<label{cloth}>Colour <select id="style">{styles}</select></label>
<label><input type="checkbox" id="wireframe"> Wireframe</label>
<button type="button" id="whole">Whole</button></div>
<div id="space"></div><p class="row"><span id="colours" hidden><canvas id="bar" width="200" height="12"
 role="img" aria-label="Colours from none to the largest value"></canvas> <span id="end"></span></span>
<span id="loading" class="soft" role="status">Loading…</span>
<span id="unseen" class="soft" hidden>The scan's colours; grey where the scan has none.</span>
<span id="uncoloured" class="soft" hidden>{uncoloured}</span></p>
<p class="row" id="player"{player}><button type="button" id="play" aria-pressed="false">Play</button>
<input type="range" id="frame" min="0" max="0" value="0" aria-label="Frame"><output id="time"></output></p></section>
<section class="card view"{flat} aria-label="Pattern"><div class="row tools">
<span class="soft" id="pointed" role="status">Point at a panel or an edge.</span></div><div id="flat"></div>
<div id="measured" role="status"></div></section></div>
<div id="problem"></div>
<section class="card" id="pictures"{hidden}><h2>Pictures</h2><div class="pictures">{pictures}</div></section></div>"""

SHARES = """<details class="card" id="shares"><summary>Share</summary>
<p>A link shows the garment, its pattern, its measures and its PDF to whoever has it, but neither the body nor other
jobs. It needs no key, and can be revoked.</p>
<form class="row"><label>Valid for <select>{days}</select></label><button type="submit">Make a link</button></form>
<p role="status"></p><div class="problem"></div><ul></ul></details>"""

FILES = """<section class="card">{exports}<details><summary>Files</summary><div class="wide"><table><thead><tr>
<th scope="col">File</th><th scope="col" class="number">Bytes</th></tr></thead><tbody>{rows}</tbody></table></div>
</details></section>"""
