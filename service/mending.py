"""Labelling of a person again, with corrected labels or in another outfit: a new job for the same scan."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from .derived import InputWrong
from .kinds import FileRef, pack_request, read_request
from .kinds.person_request import PersonRequest
from .lanes import Lane
from .results import ResultMissing, export_files, list_files, report_jobs
from .submission import PERSON_KIND, JobRequest, SubmissionResult, add_job, check_wearing
from .terms import JobTerms

if TYPE_CHECKING:
    from .models import JobRow
    from .services import Services

LABELS = "labels.npz"
"""Name of the file of labels in a person's result, and of the corrected one that the new job reads."""


def submit_corrected(services: Services, row: JobRow, points: Path, owner: JobTerms) -> SubmissionResult:
    """Queue a job that labels a person's scan again with corrected labels; all other options are as before.

    The options about worn garments and marked points are dropped, because the labels replace them.

    Args:
        services: Database and store.
        row: The job of the person.
        points: A `.npy` file with the number of a part for each point of the result's `segmented.ply`.
        owner: Key, quota and realm of who orders it.

    Raises:
        InputWrong: if the job is not a person's.
        ResultMissing: if it stored no labels.
        LabelsUnreadable, LabelsMismatch, LabelsOld: if the labels do not fit its scan.
        QueueFull: if the key has reached its number of open jobs.
    """
    before = _read_person(row)
    labels = _correct_labels(services, row, points)
    return _queue(services, row, replace(before, labels=labels, wearing=None, marks=()), owner)


def submit_in_outfit(services: Services, row: JobRow, wearing: str, owner: JobTerms) -> SubmissionResult:
    """Queue a job that labels a person's scan again in another outfit, which replaces given labels.

    Args:
        services: Database and store.
        row: The job of the person.
        wearing: Exactly these garments, `upper,lower`, or `nothing`.
        owner: Key, quota and realm of who orders it.

    Raises:
        InputWrong: if the job is not a person's.
        HintBad: if a word is no garment.
        QueueFull: if the key has reached its number of open jobs.
    """
    request = replace(_read_person(row), wearing=wearing, labels=None)
    check_wearing(request)
    return _queue(services, row, request, owner)


def _read_person(row: JobRow) -> PersonRequest:
    if row.kind != PERSON_KIND:
        raise InputWrong(f"job {row.id} is a job '{row.kind}'; only a job '{PERSON_KIND}' has labels.")
    return read_request(PersonRequest, row.request)


def _queue(services: Services, row: JobRow, request: PersonRequest, owner: JobTerms) -> SubmissionResult:
    """Queue a request in place of a job's, under the job's name, with its tags, in its queue."""
    (report,) = report_jobs(services.database, [row], services.settings)
    terms = replace(owner, name=row.name, tags=tuple(report.tags), queue=row.queue)
    packed = pack_request(replace(request, given_as="person"))
    with services.database.write() as session:
        order = JobRequest(PERSON_KIND, packed, row.scan, terms=terms, before=row.id, lane=Lane.INTERACTIVE)
        return add_job(session, order)


def _correct_labels(services: Services, row: JobRow, points: Path) -> FileRef:
    """Store the labels of a result with those of some points corrected."""
    from ..core.people.mend import apply_corrected_labels, read_corrected_labels

    if LABELS not in {file.name for file in list_files(services.database, row.id)}:
        raise ResultMissing(f"job {row.id} has no labels; `garmentq status {row.id}` shows why.")
    with services.copying() as folder:
        (stored,) = export_files(services.database, services.store, row.id, folder, [LABELS])
        corrected = apply_corrected_labels(stored, read_corrected_labels(points), folder / "mended.npz")
        return FileRef(services.store.put(corrected).sha256, LABELS)
