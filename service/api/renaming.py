"""`PATCH /v1/jobs/{job}`: change the name and the tags of a family."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter

from ..jobs import find_job
from ..priority import change_priority
from ..renaming import rename_family
from .access import AppStateDependency, Submitter, find_own
from .answers import Job
from .jobs import EXAMPLE, show_job
from .problems import show_answer
from .schemas import RenamingIn

router = APIRouter(prefix="/jobs", tags=["jobs"])


@router.patch(
    "/{job}", name="change_job", summary="Change a family's name, tags or priority.",
    responses=show_answer(EXAMPLE, model=Job, refusals=(408, 409)),
)  # fmt: skip
def change(job: str, payload: RenamingIn, rooms: AppStateDependency, caller: Submitter) -> Any:
    """Write another name of the family, or other tags or another priority of all its jobs; what is null stays as it is.

    The priority is at most the key's highest; it orders the jobs of a lane: edits, exports and previews go before
    batches. If other keys have the same job, it is only raised. Running jobs continue.
    """
    row = find_own(rooms, caller, job)
    key = "" if caller.sees_all else caller.key
    if payload.priority is not None:
        caller.check_priority(payload.priority)
    if payload.name is not None or payload.tags is not None:
        rename_family(rooms.database, row.id, payload.name, payload.tags, key)
    if payload.priority is not None:
        change_priority(rooms.database, row.id, payload.priority, key)
    return show_job(rooms, find_job(rooms.database, row.id))
