"""`/v1/subjects`: the persons who were scanned, with their jobs."""

from __future__ import annotations

from dataclasses import fields
from typing import Annotated, Any

from fastapi import APIRouter, Path, Query, Response

from ..keys import Caller
from ..persons import PersonDeleted, delete_subject
from ..subject_records import SubjectFields
from ..subjects import MAX_SUBJECT_PAGE, assign_jobs, create_subject, find_subject, list_subjects, update_subject
from .access import AppStateDependency, Reader, Submitter
from .answers import Subject, SubjectReport, Subjects
from .jobs import DELETED
from .persons import FOUND, DryRun
from .problems import show_answer
from .schemas import SubjectIn, SubjectJobsIn, Text

router = APIRouter(prefix="/subjects", tags=["subjects"])

EXAMPLE = {
    "subject": "8b1d0c9b7a3e", "key": "5b0c7d1e", "name": "Anna Müller", "note": "customer 4711",
    "created": 1795250000.1, "consented": 1795219200.0, "consent": "form 2026-11-22, folder A", "consent_until": None,
    "keep_days": 90.0, "keep_until": None, "expires": 1803026071.9, "jobs": 3,
}  # fmt: skip
REPORT = {
    **EXAMPLE,
    "scans": [{"sha256": "9f86" + 60 * "0", "name": "anna.ply", "size": 512034, "created": 1795250000.1}],
    "families": [
        {
            "job": "3685ecfd4f81", "name": "anna", "kind": "person", "state": "succeeded", "verdict": None,
            "garment": None, "created": 1795250000.1,
            "children": [{"job": "5f1d0c9b7a3e", "name": "upper", "kind": "recover", "state": "running"}],
        }
    ],
    "wearers": [
        {
            "job": "3685ecfd4f81", "created": 1795250000.1, "source": "builtin:female", "fit_rms": 0.0061,
            "measures": {"bust_girth": 921.5},
        }
    ],
}  # fmt: skip

SubjectId = Annotated[str, Path(pattern="^[0-9a-f]{12}$", description="Id of the subject.")]
Name = Annotated[Text, Query(description="Only the subject of exactly this name; empty: all.")]
Before = Annotated[str, Query(pattern="^([0-9a-f]{12})?$", description="Only those after this one in the list.")]


@router.post(
    "", status_code=201, name="create_subject", summary="Create a subject.",
    responses=show_answer(EXAMPLE, 201, Subject, (408, 409)),
)  # fmt: skip
def create(payload: SubjectIn, response: Response, rooms: AppStateDependency, caller: Submitter) -> Any:
    """Create the record of a person who was scanned; a job names it by id or name (`subject`).

    A job that names a new subject creates it too. Only the key sees it, and administrators.
    """
    made = create_subject(rooms.database, _read(payload), caller.key)
    response.headers["location"] = f"/v1/subjects/{made.id}"
    return made.as_json()


@router.get(
    "", name="list_subjects", summary="List the subjects.",
    responses=show_answer({"subjects": [EXAMPLE]}, model=Subjects),
)  # fmt: skip
def list_all(
    rooms: AppStateDependency,
    caller: Reader,
    name: Name = "",
    limit: Annotated[int, Query(ge=1, le=MAX_SUBJECT_PAGE)] = 50,
    before: Before = "",
) -> Any:
    """Return the caller's subjects, the newest first; the next page begins after the last one, `before`."""
    found = list_subjects(rooms.database, name, limit, before, _find_realm(caller))
    return {"subjects": [one.as_json() for one in found]}


@router.get(
    "/{subject}", name="show_subject", summary="Show a subject with its scans, jobs and bodies.",
    responses=show_answer(REPORT, model=SubjectReport),
)  # fmt: skip
def show_one(subject: SubjectId, rooms: AppStateDependency, caller: Reader) -> Any:
    """Return the subject with its scans, its families of jobs with their garments, and its body's measures [mm]."""
    return find_subject(rooms.database, subject, _find_realm(caller)).as_json()


@router.put(
    "/{subject}", name="update_subject", summary="Change a subject.",
    responses=show_answer(EXAMPLE, model=Subject, refusals=(408, 409)),
)  # fmt: skip
def update(subject: SubjectId, payload: SubjectIn, rooms: AppStateDependency, caller: Submitter) -> Any:
    """Replace all that is said of a subject; a field that is left out is emptied."""
    return update_subject(rooms.database, subject, _read(payload), _find_realm(caller)).as_json()


@router.post(
    "/{subject}/jobs", name="assign_jobs", summary="Make jobs a subject's.",
    responses=show_answer(EXAMPLE, 200, Subject, (408, 409)),
)  # fmt: skip
def assign(subject: SubjectId, payload: SubjectJobsIn, rooms: AppStateDependency, caller: Submitter) -> Any:
    """Make jobs, with all of their families, this subject's and no other's."""
    return assign_jobs(rooms.database, subject, payload.jobs, _find_realm(caller)).as_json()


@router.delete(
    "/{subject}", name="delete_subject", summary="Delete a subject with all its data.",
    responses=show_answer(
        DELETED | {"uploads": 1, "found": FOUND, "dry_run": False}, model=PersonDeleted, refusals=(409,)
    ),
)  # fmt: skip
def delete(subject: SubjectId, rooms: AppStateDependency, caller: Submitter, dry_run: DryRun = False) -> Any:
    """Delete the subject, its scans, bodies, labels and jobs, and all that was made of them; `found` lists them.

    If a job has not ended, nothing is deleted, and the refusal names the job. Backups are not changed.
    """
    return delete_subject(rooms.database, rooms.store, subject, _find_realm(caller), dry_run)


def _find_realm(caller: Caller) -> str | None:
    """Return the key whose subjects the caller sees; None: those of all keys."""
    return None if caller.sees_all else caller.key


def _read(payload: SubjectIn) -> SubjectFields:
    return SubjectFields(**{one.name: getattr(payload, one.name) for one in fields(SubjectFields)})
