"""`/static/NAME`: styles, scripts and pictures of the pages, only from this package.

Pages refer to them by `/static/EDITION/NAME`: the edition changes with any of the files, so a browser may cache them;
scripts import each other by relative names, which keep the edition.
"""

from __future__ import annotations

import gzip
import hashlib
import posixpath
import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path, PurePosixPath

from fastapi import APIRouter, Request, Response

from ..api.problems import refuse

router = APIRouter(include_in_schema=False)

FOLDER = Path(__file__).parent / "static"

TYPES = {
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".svg": "image/svg+xml",
}
"""Media types of the served files by extension; other files in the folder are not served."""

VENDORED = "vendor/"
"""Folder of files with their version in their name, which never change."""

IMPORT = re.compile(r"^import [^'\";]*?from '(\.[^']+)'", re.MULTILINE)
"""An import of a module at the beginning of a script."""

MIN_PACKED_FILE_SIZE = 1024
"""Size up to which a file is not compressed [bytes]: it fits into one packet."""


@dataclass(frozen=True)
class StaticFile:
    """Describe one file as it is sent.

    Attributes:
        content: Its bytes.
        packed: Its bytes compressed by gzip; empty for small files.
        etag: Identifies its content for a browser's cache.
        media: Its media type.
    """

    content: bytes
    packed: bytes
    etag: str
    media: str


@cache
def load_files() -> dict[str, StaticFile]:
    """Read every file of the folder once, by its name below it; a name is looked up here and is never a path."""
    return {path.relative_to(FOLDER).as_posix(): _load(path) for path in FOLDER.rglob("*") if path.suffix in TYPES}


@cache
def find_edition() -> str:
    """Return the edition in the addresses of all files on a page; it changes if any file changes."""
    etags = "".join(f"{name}{file.etag}" for name, file in sorted(load_files().items()))
    return f"files-{hashlib.sha256(etags.encode()).hexdigest()[:16]}"


@cache
def list_imports(script: str) -> tuple[str, ...]:
    """Return the names of all modules that a script imports, directly or indirectly, so that a page preloads them."""
    found: dict[str, None] = {}
    left = [script]
    while left:
        name = left.pop()
        file = load_files().get(name)
        if file is None or name.startswith(VENDORED):
            continue
        folder = PurePosixPath(name).parent
        for imported in IMPORT.findall(file.content.decode()):
            module = posixpath.normpath((folder / imported).as_posix())
            if module not in found:
                found[module] = None
                left.append(module)
    return tuple(found)


def _load(path: Path) -> StaticFile:
    content = path.read_bytes()
    packed = gzip.compress(content, 9, mtime=0) if len(content) > MIN_PACKED_FILE_SIZE else b""
    return StaticFile(content, packed, f'"{hashlib.sha256(content).hexdigest()[:32]}"', TYPES[path.suffix])


@router.get("/static/{name:path}")
def send_file(name: str, request: Request) -> Response:
    """Return a file, compressed if the browser accepts that; an earlier edition's name returns the present file."""
    edition, mark, rest = name.partition("/")
    if mark and edition.startswith("files-"):
        name = rest
    file = load_files().get(name)
    if file is None:
        raise refuse(404, "request.no_such_page", "there is no such file.")
    is_lasting = name.startswith(VENDORED) or edition == find_edition()
    lasting = "public, max-age=31536000, immutable" if is_lasting else "no-cache"
    headers = {"etag": file.etag, "cache-control": lasting, "vary": "accept-encoding"}
    if file.etag in request.headers.get("if-none-match", ""):
        return Response(status_code=304, headers=headers)
    if file.packed and "gzip" in request.headers.get("accept-encoding", ""):
        return Response(file.packed, headers=headers | {"content-encoding": "gzip"}, media_type=file.media)
    return Response(file.content, headers=headers, media_type=file.media)
