"""`/v1/jobs/{job}/result` and `/v1/jobs/{job}/artifacts`: the report of a job, and its files."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, Request, Response
from fastapi.responses import StreamingResponse

from ..exports import find_export
from ..models import BodyRow
from ..records import Artifact
from ..results import ResultMissing, list_files
from ..states import ENDED
from .access import AppState, AppStateDependency, Reader, find_own
from .answers import Files, Result, Wearer
from .archive import pack_files
from .download import Download, SendOptions, send_file
from .jobs import EXAMPLE as JOB
from .jobs import show_job
from .problems import API_REFUSAL_STATUSES, show_answer, show_bytes, show_file, show_list, show_refusals

router = APIRouter(tags=["results"])

FILE = {"name": "pattern.svg", "sha256": "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08", "size": 90}


WEARER = {
    "job": "3685ecfd4f81",
    "source": "mesh:body",
    "fit_rms": 0.003,
    "joints": {"pelvis": [0, 0.9, 0]},
    "parameters": {},
}


@router.get(
    "/jobs/{job}/result", summary="Show a job's result.",
    responses=show_answer(JOB | {"files": [FILE]}, model=Result),
)  # fmt: skip
def show_result(job: str, rooms: AppStateDependency, caller: Reader) -> Any:
    """Return an ended job with its files."""
    row = find_own(rooms, caller, job)
    if row.state not in ENDED:
        raise ResultMissing(f"job {row.id} is {row.state}; `garmentq logs -f {row.id}` follows it.")
    return show_job(rooms, row) | {"files": _find_files(rooms, row.id)}


@router.get(
    "/jobs/{job}/artifacts",
    summary="List a job's files.",
    responses=show_answer(show_list("files", [FILE]), model=Files),
)
def list_artifacts(job: str, rooms: AppStateDependency, caller: Reader) -> Any:
    """Return the names, hashes and sizes of a job's files."""
    return show_list("files", _find_files(rooms, find_own(rooms, caller, job).id))


@router.get(
    "/jobs/{job}/artifacts/{name:path}",
    summary="Download a file of a job.",
    response_class=StreamingResponse,
    responses={
        200: show_file("The file."),
        206: show_file("The bytes that `Range` names."),
        304: {"description": "`If-None-Match` names the file's hash."},
        **show_refusals(*API_REFUSAL_STATUSES, 416),
    },
)
def download_artifact(job: str, name: str, request: Request, rooms: AppStateDependency, caller: Reader) -> Response:
    """Return a file. The name is looked up in the job's list and is never a path.

    The file is hashed while it is sent: of a damaged file less arrives than `Content-Length` says. Parts that `Range`
    names are not hashed; the `ETag` is the hash of the whole.
    """
    row = find_own(rooms, caller, job)
    found = [file for file in _find_files(rooms, row.id) if file.name == name]
    if not found:
        raise ResultMissing(f"job {row.id} has no file '{name[:80]}'; /v1/jobs/{row.id}/artifacts lists them.")
    return send_file(rooms, caller, found[0], request)


@router.get(
    "/jobs/{job}/result.zip",
    summary="Download all files of a job.",
    response_class=StreamingResponse,
    responses={
        200: show_bytes("The files.", "application/zip"),
        **show_refusals(*API_REFUSAL_STATUSES),
    },
)
def download_result(job: str, rooms: AppStateDependency, caller: Reader) -> Response:
    """Return all files of a job as one .zip; it is cut off if a file is damaged. The list of files has their hashes."""
    row = find_own(rooms, caller, job)
    files = _find_files(rooms, row.id)
    if not files:
        raise ResultMissing(f"job {row.id} has no files; `garmentq status {row.id}` shows why.")
    headers = {"content-disposition": f'attachment; filename="{row.id}.zip"'}
    return Download(
        rooms,
        caller,
        pack_files(rooms.store, files, row.finished or row.created),
        SendOptions("application/zip", headers),
    )


@router.get(
    "/jobs/{job}/exports/{name}",
    summary="Download a file by name from a job's newest export that has it.",
    response_class=StreamingResponse,
    responses={
        200: show_file("The file."),
        206: show_file("The bytes that `Range` names."),
        304: {"description": "`If-None-Match` names the file's hash."},
        **show_refusals(*API_REFUSAL_STATUSES, 416),
    },
)
def download_export(job: str, name: str, request: Request, rooms: AppStateDependency, caller: Reader) -> Response:
    """Return a file that a job of kind `export` wrote from this job's result; no export is started."""
    row = find_own(rooms, caller, job)
    found = find_export(rooms.database, row.id, name, "" if caller.sees_all else caller.key)
    return send_file(rooms, caller, found, request)


@router.get(
    "/bodies/of/{job}", summary="Show the wearer that a job estimated.",
    responses=show_answer(WEARER, model=Wearer),
)  # fmt: skip
def show_wearer(job: str, rooms: AppStateDependency, caller: Reader) -> Any:
    """Return joints [m] by name and the fitted model's parameters."""
    row = find_own(rooms, caller, job)
    with rooms.database.read() as session:
        body = session.get(BodyRow, row.id)
    if body is None:
        raise ResultMissing(f"job {row.id} has no result; `garmentq status {row.id}` shows why.")
    shown = {"source": body.source, "fit_rms": body.fit_rms, "joints": body.joints, "parameters": body.parameters}
    return {"job": row.id, **shown}


def _find_files(rooms: AppState, job: str) -> list[Artifact]:
    return [Artifact.from_row(row) for row in list_files(rooms.database, job)]
