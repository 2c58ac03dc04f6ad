"""Refinement of a preview: the recovery of the same files at standard quality, so that nothing is uploaded again."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from ..core.recover.settings import QUALITIES
from ..core.run.errors import BadInput
from .kinds import find_kind, pack_request, read_request
from .results import report_jobs
from .states import State
from .submission import PERSON_KIND, InputNotEnded, JobRequest, SubmissionResult, add_job
from .terms import JobTerms

if TYPE_CHECKING:
    from .models import JobRow
    from .services import Services

REFINABLE_KINDS = ("recover", PERSON_KIND)
"""Kinds of jobs whose requests have the settings of a recovery."""


class NotPreview(BadInput):
    """The job is no preview; name a recovery by the method `deform`."""

    code = "job.not_preview"


def is_preview(kind: str, settings: Mapping[str, Any]) -> bool:
    """Return whether a job of a kind with these settings fits no pattern, so that it can be refined."""
    return kind in REFINABLE_KINDS and settings.get("method") == QUALITIES["preview"]["method"]


def submit_refinement(services: Services, row: JobRow, owner: JobTerms | None = None) -> SubmissionResult:
    """Queue the recovery at standard quality of a preview's files, with all its other settings; the preview stays.

    It is the job that an order of these files at that quality makes, so that an equal one is returned. The garment of a
    person is recovered from the labels and the body that were found for the preview.

    Args:
        services: Database and store.
        row: The preview.
        owner: Key, quota and realm of who orders it; None: the local user.

    Raises:
        NotPreview: if the job is not a preview.
        InputNotEnded: if it has not succeeded.
        QueueFull: if the key has reached its number of open jobs.
    """
    if not is_preview(row.kind, row.request.get("settings", {})):
        raise NotPreview(f"job {row.id} is no preview. {NotPreview().message}")
    if row.state != State.SUCCEEDED:
        raise InputNotEnded(f"job {row.id} is {row.state}; it can be refined once it has succeeded.")
    preview = read_request(find_kind(services.settings, row.kind).request, row.request)
    request = pack_request(replace(preview, settings=replace(preview.settings, **QUALITIES["standard"])))
    (report,) = report_jobs(services.database, [row], services.settings)
    terms = replace(owner or JobTerms(), name=row.name, tags=tuple(report.tags), queue=row.queue)
    with services.database.write() as session:
        return add_job(session, JobRequest(row.kind, request, row.scan, report.inputs, terms, row.id))
