"""`/v1/persons`: what is kept of a person goes, all at once."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Path

from ..deletion import Deleted, delete_person
from .access import RoomsOf, Submitter
from .jobs import DELETED
from .problems import show_answer

router = APIRouter(prefix="/persons", tags=["jobs"])

PersonName = Annotated[str, Path(min_length=1, max_length=255, description="Name of a job, a scan or an upload.")]


@router.delete(
    "/{name}", summary="Delete a person's data.",
    responses=show_answer(DELETED | {"uploads": 2}, model=Deleted, refusals=(409,)),
)  # fmt: skip
def delete_one(name: PersonName, rooms: RoomsOf, caller: Submitter) -> Any:
    """Delete the scans and uploads of a name, and all that was made of them.

    They are found by the name of a job, a scan or an upload, then by the files themselves, whatever these were called
    elsewhere; of a key only its own. A job that has not ended, or that another key has too, forbids it: then nothing
    is deleted, and the refusal names the job. Backups keep what they hold.
    """
    return delete_person(rooms.database, rooms.store, name, "" if caller.sees_all else caller.key)
