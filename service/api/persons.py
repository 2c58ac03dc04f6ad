"""`/v1/persons`: what is kept of a person is listed, and goes, all at once."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Path, Query

from ..persons import Person, PersonDeleted, delete_person, find_person
from .access import AppStateDependency, Reader, Submitter
from .jobs import DELETED
from .problems import show_answer

router = APIRouter(prefix="/persons", tags=["jobs"])

PersonName = Annotated[str, Path(min_length=1, max_length=255, description="Exact name of a job, a scan or an upload.")]
DryRun = Annotated[bool, Query(description="Delete nothing; answer what would go in `found`.")]

FOUND = {
    "name": "anna", "names": ["anna", "anna.ply"], "keys": ["5b0c7d1e"],
    "jobs": [{"job": "3685ecfd4f81", "name": "anna", "kind": "person", "keys": ["5b0c7d1e"]}],
    "uploads": [{"sha256": "9f86" + 60 * "0", "name": "anna.ply", "key": "5b0c7d1e"}], "files": ["9f86" + 60 * "0"],
}  # fmt: skip


@router.get(
    "/{name}", name="show_person", summary="List a person's data.", responses=show_answer(FOUND, model=Person)
)  # fmt: skip
def show_one(name: PersonName, rooms: AppStateDependency, caller: Reader) -> Any:
    """Return what `DELETE` would delete: jobs and uploads of a name, and all that was made of the same files.

    Names are compared exactly: a job is called so, a file is called so, or so with one ending. Of a key only its own;
    to the scope `admin` those of all keys, which `keys` names.
    """
    return find_person(rooms.database, name, "" if caller.sees_all else caller.key)


@router.delete(
    "/{name}", name="delete_person", summary="Delete a person's data.",
    responses=show_answer(
        DELETED | {"uploads": 1, "found": FOUND, "dry_run": False}, model=PersonDeleted, refusals=(409,)
    ),
)  # fmt: skip
def delete_one(name: PersonName, rooms: AppStateDependency, caller: Submitter, dry_run: DryRun = False) -> Any:
    """Delete the scans and uploads of a name, and all that was made of them; `found` says what that was.

    They are found by the exact name of a job, a scan or an upload, then by the files themselves, whatever these were
    called elsewhere; of a key only its own, with the scope `admin` those of all keys. A job that has not ended, or
    that another key has too, forbids it: then nothing is deleted, and the refusal names the job. Backups keep what
    they hold.
    """
    return delete_person(rooms.database, rooms.store, name, "" if caller.sees_all else caller.key, dry_run)
