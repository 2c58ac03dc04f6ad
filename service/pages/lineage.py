"""The person and the garment that a result belongs to, as far as its visitor may see them."""

from __future__ import annotations

from ..api.access import AppState, find_own
from ..jobs import JobUnknown
from ..kinds.dress_request import RESULT
from ..kinds.recover_request import PERSON
from ..models import JobRow
from ..records import JobReport
from ..results import report_jobs
from .shell import Visitor

MAX_LINEAGE_DEPTH = 8
"""Largest number of results, each made from the one before, that are searched for a person; an edit of an edit of a
dressed garment has four."""


def find_origin(rooms: AppState, job: JobReport, visitor: Visitor) -> JobReport | None:
    """Return the result that a result was made from (an export, a dressed or edited garment), or None."""
    row = find_visible(rooms, job.inputs.get(RESULT, ""), visitor)
    return report_jobs(rooms.database, [row], rooms.settings)[0] if row else None


def find_person(rooms: AppState, job: JobReport, visitor: Visitor) -> JobRow | None:
    """Return the job of the person whose garment a result is, or None."""
    one: JobReport | None = job
    for _ in range(MAX_LINEAGE_DEPTH):
        if one is None or PERSON in one.inputs:
            break
        one = find_origin(rooms, one, visitor)
    return find_visible(rooms, one.inputs.get(PERSON, ""), visitor) if one else None


def find_visible(rooms: AppState, job: str, visitor: Visitor) -> JobRow | None:
    """Return a job that the visitor may see, or None."""
    try:
        return find_own(rooms, visitor.caller, job)
    except JobUnknown:
        return None
