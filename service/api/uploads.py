"""`/v1/scans`, `/v1/bodies`, `/v1/labels`, `/v1/patterns`, `/v1/motions`: raw bodies, written to disk up to a limit."""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request, Response
from starlette.concurrency import run_in_threadpool
from starlette.requests import ClientDisconnect

from ...core.body.spec import is_body_model
from ...core.run.errors import BadInput
from ..deletion import Deleted, delete_upload
from ..private import make_private
from ..store import StorageFull
from ..submission import clean_name
from ..uploads import check_bounds, find_upload, keep_upload
from .access import AppState, AppStateDependency, Reader, Submitter
from .answers import Upload
from .problems import BYTES, refuse, show_answer
from .schemas import Sha256

router = APIRouter(tags=["files"])

KINDS = {
    "scans": ("scan", "a scan"),
    "bodies": ("body", "a wearer's mesh or body model"),
    "labels": ("labels", "a label file"),
    "patterns": ("pattern", "a pattern file"),
    "motions": ("motion", "a motion"),
}
"""Kinds of uploads by their part of the path: the word in the names of the routes, and a description."""
EXTENSIONS = {"labels": (".npz", ".npy", ".json", ".txt"), "patterns": (".json",), "motions": (".bvh", ".npz", ".json")}
DIGEST = "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08"
EXAMPLE = {"sha256": DIGEST, "name": "skirt.ply", "size": 512034}

DELETED = {"jobs": ["3685ecfd4f81"], "uploads": 1, "files": 7, "size": 2048000, "young": 0}

Name = Annotated[str, Query(max_length=255, description="The file's name; only its extension has an effect.")]


class FileRefused(BadInput):
    """A file of this kind needs one of its extensions; docs/reference/http.md lists them."""

    code = "upload.extension"


def _add(kind: str) -> None:
    """Add the routes of one kind of file."""

    async def upload(
        request: Request, response: Response, rooms: AppStateDependency, caller: Submitter, name: Name
    ) -> Any:
        if request.headers.get("content-type", "").lower().startswith("multipart/"):
            raise refuse(415, "upload.not_raw", "send the file itself as the body, not a form that contains it.")
        cleaned = clean_name(name)
        length = _refuse_length(request, rooms)
        bounds = rooms.limits.upload_bounds if caller.key else None
        with rooms.meter.uploading(caller.key):
            await run_in_threadpool(rooms.store.check, rooms.settings.free_bytes + length)
            await run_in_threadpool(check_bounds, rooms.database, caller.key, length, bounds)
            async with _spool_body(request, rooms, Path(cleaned).suffix.lower()) as path:
                await run_in_threadpool(_check, kind, path, cleaned)
                keep = (rooms.database, rooms.store, caller.key, path, (name, kind), bounds)
                kept = await rooms.lanes.transfers.run(keep_upload, *keep)
        response.headers["location"] = f"/v1/{kind}/{kept.sha256}"
        response.headers["etag"] = f'"{kept.sha256}"'
        return {"sha256": kept.sha256, "name": cleaned, "size": kept.size}

    def show(sha256: Sha256, rooms: AppStateDependency, caller: Reader) -> Any:
        row = find_upload(rooms.database, caller.key, sha256, kind)
        return {"sha256": row.sha256, "name": clean_name(row.name), "size": row.size}

    def forget(sha256: Sha256, rooms: AppStateDependency, caller: Submitter) -> Any:
        row = find_upload(rooms.database, caller.key, sha256, kind)
        return delete_upload(rooms.database, rooms.store, row.sha256, caller.key)

    word, what = KINDS[kind]
    body = {"content": {"application/octet-stream": {"schema": BYTES}}}
    router.post(
        f"/{kind}",
        status_code=201,
        summary=f"Upload {what} as the raw body of the request.",
        responses=show_answer(EXAMPLE, 201, Upload, (408, 415, 507)),
        openapi_extra={"requestBody": {"required": True, **body}},
        name=f"upload_{word}",
    )(upload)
    router.get(f"/{kind}/{{sha256}}", summary=f"Show {what} that this key uploaded.", name=f"show_{word}",
               responses=show_answer(EXAMPLE, model=Upload))(show)  # fmt: skip
    router.delete(f"/{kind}/{{sha256}}", summary=f"Delete the upload of {what}; jobs keep it.", name=f"forget_{word}",
                  responses=show_answer(DELETED, model=Deleted))(forget)  # fmt: skip


for _kind in KINDS:
    _add(_kind)


def _refuse_length(request: Request, rooms: AppState) -> int:
    """Refuse a body whose Content-Length is too large; return the Content-Length, or 0."""
    text = request.headers.get("content-length", "0")
    length = int(text[:20]) if text.isascii() and text.isdigit() else 0
    if length > rooms.limits.upload_bytes:
        most = rooms.limits.upload_bytes
        raise refuse(413, "request.too_large", f"the body is larger than {most} bytes; send a smaller file.")
    return length


@asynccontextmanager
async def _spool_body(request: Request, rooms: AppState, suffix: str) -> AsyncIterator[Path]:
    """Write the body to a temporary file that exists for the block."""
    make_private(rooms.incoming)
    descriptor, temporary = tempfile.mkstemp(dir=rooms.incoming, suffix=suffix)
    try:
        digest = hashlib.sha256()
        with os.fdopen(descriptor, "wb") as out:
            async for chunk in request.stream():
                digest.update(chunk)
                out.write(chunk)
        expected = request.headers.get("x-content-sha256", digest.hexdigest()).lower()
        if expected != digest.hexdigest():
            raise refuse(422, "upload.damaged", "the file's hash is not X-Content-SHA256; send it again.")
        yield Path(temporary)
    except ClientDisconnect:
        raise refuse(499, "request.gone", "the client disconnected.") from None
    except OSError as error:
        raise StorageFull(f"the upload cannot be kept: {error.strerror}.") from error
    finally:
        with suppress(FileNotFoundError):
            os.unlink(temporary)


def _check(kind: str, path: Path, name: str) -> None:
    """Check name and size of a file; its content is checked in a limited process by the job that reads it."""
    if kind in EXTENSIONS:
        if path.suffix not in EXTENSIONS[kind]:
            raise FileRefused(f"{name} does not end in {' '.join(EXTENSIONS[kind])}.")
    elif kind != "bodies" or not is_body_model(path):
        from ...core.scan.header import check_extension

        check_extension(Path(name))
    if path.stat().st_size == 0:
        raise FileRefused(f"{name} is empty.")
