"""Files of a result for the pages: small JSON files, the report, and the pictures in it."""

from __future__ import annotations

import base64
import json
import re
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from ...core.run.errors import GarmentqError
from ..records import Artifact
from ..results import list_files
from ..services import Services
from ..store import ArtifactDamaged, ArtifactMissing, Store

REPORT = "report.html"

PICTURE = re.compile(r'<img [^>]*?alt="([^"]*)"[^>]*? src="data:image/(png|gif);base64,([A-Za-z0-9+/=]+)"')
"""A picture in one of our reports: its alternative text and its bytes."""

PICTURE_DATA = re.compile(rb' src="data:image/(?:png|gif);base64,([A-Za-z0-9+/=]+)"')
"""The bytes of a picture in one of our reports."""

MAX_REPORT_FILE_SIZE = 32 * 1024**2
"""Largest report whose pictures are shown separately [bytes]; ours are below 5 MB."""

MAX_JSON_FILE_SIZE = 4 * 1024**2
"""Largest JSON file that a page reads [bytes]; ours are below 100 kB."""


@dataclass(frozen=True)
class Picture:
    """Describe one picture of a report: its title, `png` or `gif`, and its bytes."""

    title: str
    kind: str
    content: bytes


def find_file(services: Services, job: str, name: str) -> Artifact | None:
    """Return a file of a job by its name, or None if it has none."""
    return next((Artifact.from_row(row) for row in list_files(services.database, job) if row.name == name), None)


def read_bytes(services: Services, file: Artifact) -> bytes:
    """Return a file's content, checked against its hash."""
    return services.store.get_bytes(file.sha256)


def read_json(services: Services, job: str, name: str) -> Any:
    """Return the content of a JSON file of a result, or None if there is no readable one."""
    file = find_file(services, job, name)
    if file is None or file.size > MAX_JSON_FILE_SIZE:
        return None
    try:
        return json.loads(read_bytes(services, file))
    except (ValueError, GarmentqError):
        return None


def list_pictures(services: Services, job: str) -> tuple[Picture, ...]:
    """Return the pictures of a result's report; none if there is no report, or it is damaged or too large."""
    file = find_file(services, job, REPORT)
    if file is None or file.size > MAX_REPORT_FILE_SIZE:
        return ()
    with suppress(ArtifactMissing, ArtifactDamaged):
        return _read_pictures(services.store, file.sha256)
    return ()


@lru_cache(maxsize=16)
def _read_pictures(store: Store, sha256: str) -> tuple[Picture, ...]:
    """Return the pictures of a stored report; a hash always has the same content."""
    text = store.get_bytes(sha256).decode("utf-8", "replace")
    return tuple(Picture(title, kind, base64.b64decode(data)) for title, kind, data in PICTURE.findall(text))


def read_picture(report: bytes, title: str) -> bytes | None:
    """Return the first picture of a report whose title begins with some words; no other one is decoded."""
    start = report.find(f'alt="{title}'.encode())
    found = PICTURE_DATA.search(report, start) if start >= 0 else None
    return base64.b64decode(found[1]) if found else None


def pack_files(store: Store, files: tuple[tuple[str, str], ...]) -> bytes:
    """Return files of a result, each a name and a hash, as `pack_shown` packs them for a view."""
    from .shown_meshes import WORN, pack_shown

    content = {name: store.get_bytes(sha256) for name, sha256 in files}
    worn = content.pop(WORN, None)
    return pack_shown({name.removesuffix(".ply"): mesh for name, mesh in content.items()}, worn)
