"""`/v1/batches`: the jobs with a tag, their progress and their failures."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Path, Query

from ..batch_records import BatchReport
from ..batches import MAX_BATCH_PAGE, find_batch, list_batches
from ..keys import Caller
from .access import AppStateDependency, Reader
from .answers import Batches
from .problems import show_answer

router = APIRouter(prefix="/batches", tags=["jobs"])

EXAMPLE = {
    "tag": "2026-11", "latest": 1795250000.1, "jobs": 12, "scans": 5,
    "states": {"failed": 2, "queued": 6, "running": 1, "succeeded": 3}, "share": 0.45, "left_seconds": 840.0,
    "verdicts": {"doubtful": 1, "pass": 2}, "garments": {"skirt": 1, "tshirt": 2}, "cpu_seconds": 213.4,
    "families": {"succeeded": 1, "failed": 2, "open": 2},
}  # fmt: skip
FAILURE = {
    "job": "3685ecfd4f81", "family": "3685ecfd4f81", "name": "anna", "kind": "person", "state": "failed",
    "error": {"code": "scan.truncated", "message": "The file ends too early; copy it again."},
}  # fmt: skip

TagPath = Annotated[str, Path(min_length=1, max_length=64, description="The tag.")]


@router.get(
    "", name="list_batches", summary="List the batches.", responses=show_answer({"batches": [EXAMPLE]}, model=Batches)
)
def list_all(
    rooms: AppStateDependency,
    caller: Reader,
    limit: Annotated[int, Query(ge=1, le=MAX_BATCH_PAGE)] = 20,
    before: Annotated[str, Query(max_length=64, description="Only those after this tag in the list.")] = "",
) -> Any:
    """Return the tags of the caller's jobs with their progress, those ordered last first."""
    found = list_batches(rooms.database, limit, before, _find_owner(caller))
    return {"batches": [one.as_json() for one in found]}


@router.get(
    "/{tag:path}", name="show_batch", summary="Show a batch with its failures.",
    responses=show_answer(EXAMPLE | {"failures": [FAILURE]}, model=BatchReport),
)  # fmt: skip
def show_one(tag: TagPath, rooms: AppStateDependency, caller: Reader) -> Any:
    """Return the progress of the caller's jobs with a tag, and why some of them failed."""
    return find_batch(rooms.database, tag, _find_owner(caller)).as_json()


def _find_owner(caller: Caller) -> str | None:
    """Return the key whose jobs the caller sees; None: those of all keys."""
    return None if caller.sees_all else caller.key
