"""A person taken apart anew with labels that were mended by hand: a new job for the same scan."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from .derived import InputWrong
from .kinds import FileRef, pack_request, read_request
from .kinds.person_request import PersonRequest
from .results import ResultMissing, export_files, list_files, report_jobs
from .submission import PERSON_KIND, JobRequest, SubmissionResult, add_job
from .terms import JobTerms

if TYPE_CHECKING:
    from .models import JobRow
    from .services import Services

LABELS = "labels.npz"
"""Name of the file of labels in a person's result, and of the mended one that the new job is given."""


@dataclass(frozen=True)
class RelabelOrder:
    """Ask for a person to be taken apart with mended labels.

    Attributes:
        points: A `.npy` file with the number of a part for each point of the result's `segmented.ply`.
        key: Id of the API key that asks, or empty.
        quota: Jobs that the key may have open at a time.
        realm: Whose equal orders are one job: a key's id; empty: everybody's.
    """

    points: Path
    key: str = ""
    quota: int = 0
    realm: str = ""


def submit_relabelling(services: Services, row: JobRow, wanted: RelabelOrder) -> SubmissionResult:
    """Queue a job that takes a person's scan apart by mended labels, all else asked for as before.

    What was said to be worn, and at single places, is left out: the labels say it now.

    Raises:
        InputWrong: where the job took no person apart.
        ResultMissing: where it left no labels.
        LabelsUnreadable, LabelsMismatch, LabelsOld: where the labels are none for its scan.
        QueueFull: where the key has as many open jobs as it may.
    """
    from ..core.people.mend import apply_corrected_labels, read_corrected_labels

    if row.kind != PERSON_KIND:
        raise InputWrong(f"job {row.id} is a job '{row.kind}'; labels are of a job '{PERSON_KIND}'.")
    if LABELS not in {file.name for file in list_files(services.database, row.id)}:
        raise ResultMissing(f"job {row.id} left no labels; `garmentq status {row.id}` tells why.")
    with services.copying() as folder:
        (stored,) = export_files(services.database, services.store, row.id, folder, [LABELS])
        mended = apply_corrected_labels(stored, read_corrected_labels(wanted.points), folder / "mended.npz")
        file = FileRef(services.store.put(mended).sha256, LABELS)
    before = read_request(PersonRequest, row.request)
    request = pack_request(replace(before, labels=file, wearing=None, marks=(), given_as="person"))
    (report,) = report_jobs(services.database, [row], services.settings)
    terms = JobTerms(row.name, tuple(report.tags), queue=row.queue)
    terms = replace(terms, key=wanted.key, quota=wanted.quota, realm=wanted.realm)
    with services.database.write() as session:
        return add_job(session, JobRequest(PERSON_KIND, request, row.scan, terms=terms))
