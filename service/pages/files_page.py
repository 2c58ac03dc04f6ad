"""`/results/ID/report`, its pictures and meshes, and the figure of each job."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Collection, Sequence
from contextlib import suppress

from fastapi import Request, Response

from ..api.access import AppState, AppStateDependency, find_own
from ..api.download import REVALIDATED, Download, SendOptions, send_file, slice_bytes
from ..records import Artifact
from ..results import ResultMissing, list_files
from ..store import ArtifactDamaged, ArtifactMissing
from .contact_sheets import cut_column, find_contact_sheet
from .figures import cut_figure, find_figure
from .page_route import make_router
from .session import VisitorOf
from .shell import Visitor
from .shown_meshes import SCANS, WORN, list_shown
from .stored_files import REPORT, Picture, find_file, list_pictures, pack_files

router = make_router()

REPORT_POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; frame-ancestors 'none'; sandbox"
"""Content-Security-Policy of a report: its own style and pictures; no script runs in it, whatever it contains."""

MAX_SHOWN_FILE_SIZE = 64 * 1024**2
"""Largest file that is packed for a view [bytes]: a scan of 1.3 million vertices."""

PICTURE_CACHE_CONTROL = "private, max-age=3600"
"""Cache of a job's figure in a browser; meshes of bodies are asked for again each time."""


@router.get("/results/{job}/report")
def show_report(job: str, request: Request, rooms: AppStateDependency, visitor: VisitorOf) -> Response:
    """Return the stored report for display."""
    row = find_own(rooms, visitor.caller, job)
    file = find_file(rooms, row.id, REPORT)
    if file is None:
        raise ResultMissing("the job has no report.")
    shown = SendOptions("text/html; charset=utf-8", {"content-security-policy": REPORT_POLICY})
    return send_file(rooms, visitor.caller, file, request, shown)


@router.get("/results/{job}/pictures/{number}")
def show_picture(job: str, number: int, rooms: AppStateDependency, visitor: VisitorOf) -> Response:
    """Return one picture of the report, counted from 0."""
    row = find_own(rooms, visitor.caller, job)
    pictures = list_pictures(rooms, row.id)
    if not 0 <= number < len(pictures):
        raise ResultMissing("the report has no such picture.")
    return Response(pictures[number].content, media_type=f"image/{pictures[number].kind}")


@router.get("/results/{job}/pictures/{number}/{column}")
def show_column(job: str, number: int, column: int, rooms: AppStateDependency, visitor: VisitorOf) -> Response:
    """Return one column of a contact sheet among the pictures of the report, both counted from 0."""
    row = find_own(rooms, visitor.caller, job)
    return send_column(list_pictures(rooms, row.id), number, column)


def send_column(pictures: Sequence[Picture], number: int, column: int) -> Response:
    """Return one column of a contact sheet.

    Raises:
        ResultMissing: if there is no such picture, or it has no such column.
    """
    sheet = find_contact_sheet(pictures[number].title) if 0 <= number < len(pictures) else None
    if sheet is None or not 0 <= column < len(sheet.heads):
        raise ResultMissing("the report has no such picture.")
    return Response(cut_column(pictures[number].content, column, len(sheet.heads)), media_type="image/png")


@router.get("/results/{job}/view.bin")
def show_view(job: str, request: Request, rooms: AppStateDependency, visitor: VisitorOf) -> Response:
    """Return meshes and flat pattern of a result as `pack_shown` packs them; scans are requested separately."""
    return _send_packed(job, _list_packed, request, rooms, visitor)


@router.get("/results/{job}/scan.bin")
def show_scan(job: str, request: Request, rooms: AppStateDependency, visitor: VisitorOf) -> Response:
    """Return the scan of a result as `pack_shown` packs it."""
    return _send_packed(job, lambda there: ["scan.ply"], request, rooms, visitor)


def _list_packed(names: Collection[str]) -> list[str]:
    return [f"{name}.ply" for name in list_shown(names) if name not in SCANS] + [WORN]


def _send_packed(
    job: str, choose: Callable[[Collection[str]], list[str]], request: Request, rooms: AppState, visitor: Visitor
) -> Response:
    """Return the chosen files of a result, packed."""
    row = find_own(rooms, visitor.caller, job)
    there = {row.name: Artifact.from_row(row) for row in list_files(rooms.database, row.id)}
    files = [
        (name, there[name].sha256)
        for name in choose(there)
        if name in there and there[name].size <= MAX_SHOWN_FILE_SIZE
    ]
    if not files:
        raise ResultMissing("the job has no such mesh, or it is too large to be shown; download its files.")
    etag = f'"{hashlib.sha256(repr(files).encode()).hexdigest()[:32]}"'
    headers = {"etag": etag, "cache-control": REVALIDATED}
    if etag in request.headers.get("if-none-match", ""):
        return Response(status_code=304, headers=headers)
    packed = slice_bytes(pack_files(rooms.store, tuple(files)))
    return Download(rooms, visitor.caller, packed, SendOptions(headers=headers))


@router.get("/jobs/{job}/thumbnail")
def show_thumbnail(job: str, request: Request, rooms: AppStateDependency, visitor: VisitorOf) -> Response:
    """Return a job's figure; a blank picture if its result has none."""
    row = find_own(rooms, visitor.caller, job)
    source = find_figure(rooms, row.id, row.kind)
    if source is None:
        return Response(BLANK, media_type="image/svg+xml")
    headers = {"etag": f'"figure-{source.sha256}"', "cache-control": PICTURE_CACHE_CONTROL}
    if headers["etag"] in request.headers.get("if-none-match", ""):
        return Response(status_code=304, headers=headers)
    with suppress(ArtifactMissing, ArtifactDamaged):
        if (figure := cut_figure(rooms.store, source)) is not None:
            return Response(figure, media_type="image/webp", headers=headers)
    return Response(BLANK, media_type="image/svg+xml")


BLANK = '<svg xmlns="http://www.w3.org/2000/svg" width="1" height="1"/>'
"""Picture for a job without one."""
