"""Labelling of a person again, with corrected labels or in another outfit: a new job for the same scan."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from .derived import InputWrong
from .kinds import FileRef, pack_request, read_request
from .kinds.person_request import PersonRequest
from .results import ResultMissing, export_files, list_files, report_jobs
from .submission import PERSON_KIND, JobRequest, SubmissionResult, add_job, check_wearing
from .terms import JobTerms

if TYPE_CHECKING:
    from .models import JobRow
    from .services import Services

LABELS = "labels.npz"
"""Name of the file of labels in a person's result, and of the corrected one that the new job reads."""


@dataclass(frozen=True)
class RelabelOrder:
    """Describe an order to label a person again: one of `points` and `wearing` is given.

    Attributes:
        points: A `.npy` file with the number of a part for each point of the result's `segmented.ply`.
        wearing: Exactly these garments, `upper,lower`, or `nothing`.
        key: Id of the caller's API key, or empty.
        quota: Jobs that the key may have open at a time.
        realm: Whose equal orders are one job: a key's id; empty: everybody's.
    """

    points: Path | None = None
    wearing: str | None = None
    key: str = ""
    quota: int = 0
    realm: str = ""


def submit_relabelling(services: Services, row: JobRow, order: RelabelOrder) -> SubmissionResult:
    """Queue a job that labels a person's scan again; all other options are as before.

    Corrected labels replace the options about worn garments and marked points, an outfit replaces given labels.

    Raises:
        InputWrong: if the job is not a person's.
        HintBad: if the outfit is none.
        ResultMissing: if it stored no labels to correct.
        LabelsUnreadable, LabelsMismatch, LabelsOld: if the labels do not fit its scan.
        QueueFull: if the key has reached its number of open jobs.
    """
    if row.kind != PERSON_KIND:
        raise InputWrong(f"job {row.id} is a job '{row.kind}'; only a job '{PERSON_KIND}' has labels.")
    before = read_request(PersonRequest, row.request)
    if order.wearing is not None:
        again = replace(before, wearing=order.wearing, labels=None)
        check_wearing(again)
    else:
        again = replace(before, labels=_correct_labels(services, row, order.points), wearing=None, marks=())
    request = pack_request(replace(again, given_as="person"))
    (report,) = report_jobs(services.database, [row], services.settings)
    terms = JobTerms(row.name, tuple(report.tags), queue=row.queue)
    terms = replace(terms, key=order.key, quota=order.quota, realm=order.realm)
    with services.database.write() as session:
        return add_job(session, JobRequest(PERSON_KIND, request, row.scan, terms=terms))


def _correct_labels(services: Services, row: JobRow, points: Path | None) -> FileRef:
    """Store the labels of a result with those of some points corrected."""
    from ..core.people.mend import apply_corrected_labels, read_corrected_labels

    if points is None or LABELS not in {file.name for file in list_files(services.database, row.id)}:
        raise ResultMissing(f"job {row.id} has no labels; `garmentq status {row.id}` shows why.")
    with services.copying() as folder:
        (stored,) = export_files(services.database, services.store, row.id, folder, [LABELS])
        corrected = apply_corrected_labels(stored, read_corrected_labels(points), folder / "mended.npz")
        return FileRef(services.store.put(corrected).sha256, LABELS)
