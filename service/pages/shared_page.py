"""`/shared/TOKEN`: one result for whoever has the link; no session, no other job, no body."""

from __future__ import annotations

from collections.abc import Collection
from typing import Annotated

from fastapi import Depends, Path, Request, Response
from sqlalchemy import select
from starlette.background import BackgroundTask

from ..api.access import AppState, AppStateDependency
from ..api.download import SendOptions, send_file
from ..audit import record_access
from ..jobs import find_job
from ..keys import Caller
from ..logs import REQUEST
from ..models import JobInputRow, JobRow, OwnerRow
from ..records import Artifact, JobReport
from ..results import ResultMissing, list_files, report_jobs
from ..share_records import Share
from ..shares import ShareUnknown, find_share, note_opened
from ..states import State
from .figures import cut_figure, find_figure
from .markup import Html, html
from .measures_card import draw_measures
from .page_route import make_router
from .session import address_of
from .shell import draw_shell
from .shown_meshes import WORN, is_companion_mesh, list_shown
from .stored_files import pack_files
from .words import draw_time, draw_verdict

router = make_router()

PRIVATE = {"cache-control": "no-store", "referrer-policy": "no-referrer", "x-robots-tag": "noindex, nofollow"}
"""Headers of every answer to a link: it is kept neither by caches nor by search engines, nor sent to other hosts."""

DRAWING = "pattern.svg"
"""File of the flat pattern's drawing."""


def get_share(request: Request, rooms: AppStateDependency, token: Annotated[str, Path(max_length=200)]) -> Share:
    """Return the share of a request's token, and count the request for its address.

    Raises:
        ShareUnknown: if the token is not valid; the address may try only a few.
        TooManyRequests: if the address tried too many tokens, or sends too many requests.
    """
    address = address_of(request)
    rooms.meter.check_address(address, token)
    rooms.meter.take(f"share {address}")
    try:
        share = find_share(rooms.database, token)
    except ShareUnknown:
        rooms.meter.note_wrong(address)
        raise
    rooms.meter.note_key(token)
    return share


ShareOf = Annotated[Share, Depends(get_share)]


@router.get("/shared/{token}")
def show_shared(token: str, request: Request, rooms: AppStateDependency, share: ShareOf) -> Response:
    """Return the page of a shared result."""
    (report,) = report_jobs(rooms.database, [find_job(rooms.database, share.job)], rooms.settings)
    files = {row.name for row in list_files(rooms.database, share.job)}
    address = f"/shared/{token}"
    answer = draw_shell(
        report.name, _draw(rooms, share, report, files, address), scripts=["shared.js"],
        data=f"{address}/view.bin" if _choose_mesh(files) else "",
    )  # fmt: skip
    answer.headers.update(PRIVATE)
    origin = (address_of(request), REQUEST.get())
    answer.background = BackgroundTask(_record, rooms, share, origin)
    return answer


@router.get("/shared/{token}/view.bin")
def show_shared_view(rooms: AppStateDependency, share: ShareOf) -> Response:
    """Return the garment's mesh and flat pattern as `pack_shown` packs them, without the body."""
    there = {row.name: row.sha256 for row in list_files(rooms.database, share.job)}
    names = [name for name in (_choose_mesh(there), WORN) if name in there]
    if not names:
        raise ResultMissing("the result has no mesh to show.")
    packed = pack_files(rooms.store, tuple((name, there[name]) for name in names))
    return Response(packed, media_type="application/octet-stream", headers=PRIVATE)


@router.get("/shared/{token}/figure")
def show_shared_figure(rooms: AppStateDependency, share: ShareOf) -> Response:
    """Return the picture of the garment as it is worn."""
    source = find_figure(rooms, share.job, find_job(rooms.database, share.job).kind)
    figure = None if source is None else cut_figure(rooms.store, source)
    if figure is None:
        raise ResultMissing("the result has no picture.")
    return Response(figure, media_type="image/webp", headers=PRIVATE)


@router.get("/shared/{token}/pattern.svg")
def show_shared_pattern(request: Request, rooms: AppStateDependency, share: ShareOf) -> Response:
    """Return the drawing of the pattern."""
    return _send(rooms, share, share.job, DRAWING, SendOptions("image/svg+xml", PRIVATE), request)


@router.get("/shared/{token}/pattern.pdf")
def show_shared_pdf(request: Request, rooms: AppStateDependency, share: ShareOf) -> Response:
    """Return the PDF that was exported of the result last."""
    for job, name in _find_pdfs(rooms, share):
        return _send(rooms, share, job, name, SendOptions("application/pdf", PRIVATE), request)
    raise ResultMissing("the result has no PDF.")


def _send(rooms: AppState, share: Share, job: str, name: str, options: SendOptions, request: Request) -> Response:
    """Return a file of a job; it counts as a download of the key that shared it."""
    file = next((Artifact.from_row(row) for row in list_files(rooms.database, job) if row.name == name), None)
    if file is None:
        raise ResultMissing(f"the result has no {name}.")
    return send_file(rooms, Caller(share.key, (), 0), file, request, options)


def _draw(rooms: AppState, share: Share, report: JobReport, files: set[str], address: str) -> Html:
    what = ", ".join(one for one in (report.garment, report.fabric) if one)
    pdf = html('<a class="button primary" href="{}/pattern.pdf" download>Pattern (PDF)</a>', address)
    drawing = html(PATTERN, address)
    return html(
        SHARED, name=report.name, verdict=draw_verdict(report.verdict), what=what, expires=draw_time(share.expires),
        address=address, pdf=pdf if _find_pdfs(rooms, share) else Html(),
        solid=Html() if _choose_mesh(files) else Html(" hidden"),
        drawing=drawing if DRAWING in files else Html(), measures=draw_measures(report, is_shared=True),
    )  # fmt: skip


def _choose_mesh(files: Collection[str]) -> str:
    """Return the name of the file of the first mesh of cloth; empty if there is none."""
    return next((f"{name}.ply" for name in list_shown(files) if not is_companion_mesh(name)), "")


def _find_pdfs(rooms: AppState, share: Share) -> list[tuple[str, str]]:
    """Return job and file of each PDF that was exported of a shared result by who shared it, newest first."""
    statement = select(JobRow).join(JobInputRow, JobInputRow.job == JobRow.id)
    statement = statement.where(JobInputRow.input == share.job, JobRow.kind == "export")
    statement = statement.where(JobRow.state == State.SUCCEEDED)
    if share.key:
        statement = statement.join(OwnerRow, OwnerRow.job == JobRow.id).where(OwnerRow.key == share.key)
    with rooms.database.read() as session:
        rows = session.scalars(statement.order_by(JobRow.created.desc(), JobRow.id).limit(20)).all()
    found = [(row.id, file.name) for row in rows for file in list_files(rooms.database, row.id)]
    return [(job, name) for job, name in found if name.endswith(".pdf")]


def _record(rooms: AppState, share: Share, origin: tuple[str, str]) -> None:
    """Count that the page was shown, and record it under the link's id; the token is written nowhere."""
    note_opened(rooms.database, share.id)
    record_access(rooms.database, share.key, "GET 200", f"/shared/{share.id}", origin)


PATTERN = """<section class="card"><h2>Pattern</h2>
<img class="drawing" src="{}/pattern.svg" alt="Pattern"></section>"""

SHARED = """<div class="head"><h1>{name}</h1><p class="row">{verdict}<span class="soft">{what}</span></p>
<p class="row">{pdf}<span class="soft">This link is valid until {expires}.</span></p></div>
<div id="shared" data-view="{address}/view.bin"><div class="views"><section class="card view"{solid} aria-label="3D">
<div id="space"></div><p id="loading" class="soft" role="status">Loading…</p></section>
<section class="card"><img class="figure" src="{address}/figure" alt="The garment as it is worn"></section></div>
<div id="problem"></div></div>{drawing}{measures}"""
