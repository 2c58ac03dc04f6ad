"""`/v1/persons`: list and delete all data of a person."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Path, Query

from ..persons import Person, PersonDeleted, delete_person, find_person
from .access import AppStateDependency, Reader, Submitter
from .jobs import DELETED
from .problems import show_answer

router = APIRouter(prefix="/persons", tags=["jobs"])

PersonName = Annotated[
    str, Path(min_length=1, max_length=255, description="Exact name of a subject, job, scan or upload.")
]
DryRun = Annotated[bool, Query(description="Delete nothing; `found` has what would be deleted.")]

FOUND = {
    "name": "anna", "names": ["anna", "anna.ply"], "keys": ["5b0c7d1e"],
    "jobs": [{"job": "3685ecfd4f81", "name": "anna", "kind": "person", "keys": ["5b0c7d1e"]}],
    "uploads": [{"sha256": "9f86" + 60 * "0", "name": "anna.ply", "key": "5b0c7d1e"}], "files": ["9f86" + 60 * "0"],
    "subjects": ["8b1d0c9b7a3e"],
}  # fmt: skip


@router.get(
    "/{name}", name="show_person", summary="List a person's data.", responses=show_answer(FOUND, model=Person)
)  # fmt: skip
def show_one(name: PersonName, rooms: AppStateDependency, caller: Reader) -> Any:
    """Return what `DELETE` would delete: the subject, jobs and uploads of a name, and all made of the same files.

    The name must equal the name of a job or of a file, with or without its extension. A key finds only its own data;
    the scope `admin` finds those of all keys, listed in `keys`.
    """
    return find_person(rooms.database, name, "" if caller.sees_all else caller.key)


@router.delete(
    "/{name}", name="delete_person", summary="Delete a person's data.",
    responses=show_answer(
        DELETED | {"uploads": 1, "found": FOUND, "dry_run": False}, model=PersonDeleted, refusals=(409,)
    ),
)  # fmt: skip
def delete_one(name: PersonName, rooms: AppStateDependency, caller: Submitter, dry_run: DryRun = False) -> Any:
    """Delete the subject, scans and uploads of a name, and all that was made of them; `found` lists them.

    They are found by the exact name of a job, a scan or an upload, then by the files' content under any other name. A
    key deletes only its own data; the scope `admin` deletes those of all keys. If a job has not ended, or belongs to
    another key too, nothing is deleted, and the refusal names the job. Backups are not changed.
    """
    return delete_person(rooms.database, rooms.store, name, "" if caller.sees_all else caller.key, dry_run)
