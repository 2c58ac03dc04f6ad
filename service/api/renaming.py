"""`PATCH /v1/jobs/{job}`: change the name and the tags of a family."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter

from ..jobs import find_job
from ..renaming import rename_family
from .access import AppStateDependency, Submitter, find_own
from .answers import Job
from .jobs import EXAMPLE, show_job
from .problems import show_answer
from .schemas import RenamingIn

router = APIRouter(prefix="/jobs", tags=["jobs"])


@router.patch(
    "/{job}", name="change_job", summary="Change a family's name or tags.",
    responses=show_answer(EXAMPLE, model=Job, refusals=(408, 409)),
)  # fmt: skip
def change(job: str, payload: RenamingIn, rooms: AppStateDependency, caller: Submitter) -> Any:
    """Write another name of the family, or other tags of all its jobs; what is null stays as it is."""
    row = find_own(rooms, caller, job)
    rename_family(rooms.database, row.id, payload.name, payload.tags, "" if caller.sees_all else caller.key)
    return show_job(rooms, find_job(rooms.database, row.id))
