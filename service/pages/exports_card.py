"""The exports of a garment's result, and what an export made."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from sqlalchemy import select

from ..api.access import AppState
from ..models import JobInputRow, JobRow, OwnerRow
from ..records import Artifact, JobReport
from ..states import State
from .control_words import speak_of_controls
from .garment_words import title_garment
from .help_note import draw_heading
from .markup import Html, html, join
from .shell import Visitor

EXPORTABLE = ("recover", "dress", "refit", "drape", "edit")
"""Kinds of jobs whose results have a pattern to export; the service refuses others."""

EXPORT_KIND = "export"
"""Kind of the jobs that write a pattern in another format."""

PURPOSES = {
    "pdf": ("PDF", "to print at full size, paste and cut"),
    "svg": ("SVG", "to change lines in a drawing program"),
    "dxf": ("DXF", "for cutting machines and pattern programs"),
    "marker": ("Marker", "all pieces laid out on the width of the cloth"),
    "sizes": ("Sizes", "the pattern graded up and down, with its nest"),
    "clo": ("CLO", "the sewn pattern for CLO and Marvelous Designer"),
    "blender": ("Blender", "panels and sewing threads for Blender's cloth"),
    "garmentcode": ("GarmentCode", "panels and seams as JSON for programs"),
    "obj": ("OBJ", "the meshes, which every 3D program reads"),
    "glb": ("GLB", "the meshes for web pages and games"),
    "usd": ("USD", "the meshes for film pipelines"),
    "texture": ("Texture", "the scan's colours, and prints of the pieces"),
}
"""Title and purpose of each format, in the order of the page: to cut by, for other programs, to look at."""

MAX_LISTED_EXPORTS = 40
"""Largest number of exports that are searched for the newest of each format."""


def draw_exports(rooms: AppState, job: JobReport, visitor: Visitor) -> Html:
    """Return the card that offers exports of a result, each with the one that was made last."""
    if job.kind not in EXPORTABLE or job.state != State.SUCCEEDED:
        return Html()
    made: dict[str, JobRow] = {}
    for row in find_exports(rooms, job.id, visitor):
        made.setdefault(row.request.get("format", ""), row)
    rows = join(_draw_format(name, made.get(name), visitor) for name in PURPOSES if visitor.may_submit or name in made)
    return html(OFFERED, heading=draw_heading("Exports", ABOUT), rows=rows) if rows else Html()


def _draw_format(name: str, made: JobRow | None, visitor: Visitor) -> Html:
    title, purpose = PURPOSES[name]
    button = html("<b>{}</b>", title)
    if visitor.may_submit:
        look = "primary" if name == "pdf" else ""
        button = html('<button type="button" class="{}" data-export="{}">{}</button>', look, name, title)
    last = Html()
    if made is not None:
        done = made.state == State.SUCCEEDED
        last = html('<a href="/{}/{}">{}</a>', "results" if done else "jobs", made.id, "open" if done else made.state)
    return html("<tr><td>{}</td><td>{}</td><td>{}</td></tr>", button, purpose, last)


def find_exports(rooms: AppState, job: str, visitor: Visitor) -> list[Any]:
    """Return the exports of a result that the visitor sees, newest first."""
    statement = select(JobRow).join(JobInputRow, JobInputRow.job == JobRow.id)
    statement = statement.where(JobInputRow.input == job, JobRow.kind == EXPORT_KIND)
    if not visitor.caller.sees_all:
        statement = statement.join(OwnerRow, OwnerRow.job == JobRow.id).where(OwnerRow.key == visitor.caller.key)
    statement = statement.order_by(JobRow.created.desc(), JobRow.id).limit(MAX_LISTED_EXPORTS)
    with rooms.database.read() as session:
        return list(session.scalars(statement))


def title_format(name: str) -> str:
    """Return the title of a format."""
    return PURPOSES[name][0] if name in PURPOSES else name.upper()


def draw_made(job: JobReport, files: Sequence[Artifact], origin: JobReport | None) -> Html:
    """Return what an export made: its files, its garment, and what the pattern has not."""
    rows = join(
        html(FILE, " primary" if number == 0 else "", job.id, file.name, file.name, describe_size(file.size))
        for number, file in enumerate(files)
    )
    source = Html()
    if origin is not None:
        title = title_garment(origin.garment or origin.name)
        source = html('<p>Made of <a href="/results/{}">{}</a>.</p>', origin.id, title)
    missing = join(html("<li>{}</li>", speak_of_controls(text)) for text in job.warnings)
    lacks = html(LACKS, rows=missing) if missing else Html()
    return html(MADE, rows=rows, source=source, lacks=lacks)


def describe_size(size: int) -> str:
    """Return a size [bytes] in words, to three digits."""
    for unit in ("bytes", "kB", "MB"):
        if size < 1000 or unit == "MB":
            break
        size /= 1000  # type: ignore[assignment]
    return f"{size:.3g} {unit}"


ABOUT = "PDF is what a sewing room prints. The others carry the same pieces or meshes into other programs."

OFFERED = """<section class="card" id="exports">{heading}<div id="exported" role="status"></div>
<table class="exports">{rows}</table></section>"""

MADE = """<section class="card" id="made"><h2>Files</h2><ul class="made">{rows}</ul>{source}{lacks}</section>"""

FILE = """<li><a class="button{}" href="/v1/jobs/{}/artifacts/{}" download>{}</a> <span class="soft">{}</span></li>"""

LACKS = """<h3>Not in this pattern</h3><ul>{rows}</ul>"""
