"""`/v1/match`: compare the patterns of two jobs, or of a job and a template."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request

from ...core.run.errors import NotFound
from ...core.run.sandbox import IsStopped
from ..matching import match_files
from ..results import export_files
from ..templates import read_template
from ..uploads import find_upload
from .access import AppState, AppStateDependency, Reader, find_own
from .answers import Match
from .problems import RequestBad, show_answer

router = APIRouter(tags=["results"])

PAIR = {
    "first": "front", "second": "front", "paired_by": "name", "turning": 0.012, "area_percent": -1.4, "outline_mm": 3.1,
    "turned_over": False, "angle": 0.02, "shift": [0.001, -0.003],
}  # fmt: skip


@router.get(
    "/match", summary="Compare two patterns panel by panel.",
    responses=show_answer({"pairs": [PAIR], "only_first": [], "only_second": ["pocket"]}, model=Match),
)  # fmt: skip
async def match_patterns(
    first: Annotated[str, Query(max_length=64, examples=["3685ecfd4f81"])],
    second: Annotated[str, Query(max_length=64, examples=["tshirt"])],
    request: Request,
    rooms: AppStateDependency,
    caller: Reader,
    pair: Annotated[list[str], Query(max_length=200, examples=[["front:back"]])] = [],  # noqa: B006
    only_given: bool = False,
    outlines: bool = False,
) -> Any:
    """Compare the patterns of two jobs, templates or uploads to /v1/patterns (by their sha256).

    `pair=A:B` pairs panel A of the first with B of the second; the others are paired by name, then by shape, or not at
    all with `only_given`. With `outlines` the response has every panel's outline [m].
    """
    named_pairs = {}
    for words in pair:
        first_name, colon, second_name = words[:600].partition(":")
        if not colon or first_name in named_pairs:
            raise RequestBad(f"'{words[:60]}' pairs no two panels; write PANEL:PANEL, each panel once.")
        named_pairs[first_name] = second_name

    def work(is_stopped: IsStopped) -> Any:
        with rooms.copying() as folder:
            files = [_find_file(rooms, caller, word, folder / str(at)) for at, word in enumerate((first, second))]
            return match_files(files[0], files[1], named_pairs, only_given, outlines, is_stopped)

    return await rooms.limited.run(request, caller.key, work)


def _find_file(rooms: AppState, caller: Reader, word: str, folder: Path) -> Path:
    """Write the pattern of a job, an upload or a template of the caller into a folder, and return the file."""
    folder.mkdir()
    if re.fullmatch("[0-9a-f]{64}", word):
        kept = find_upload(rooms.database, caller.key, word, "patterns")
        return rooms.store.copy(kept.sha256, folder / "pattern.json")
    try:
        job = find_own(rooms, caller, word).id
    except NotFound:
        path = folder / "template.json"
        path.write_bytes(read_template(rooms, word))
        return path
    return export_files(rooms.database, rooms.store, job, folder, ["pattern.json"])[0]
