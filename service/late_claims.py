"""A worker whose lease ran out although it was alive: the attempt does not count, because the job did not end it."""

from __future__ import annotations

from sqlalchemy import func, select, update

from .database import Database, change_rows
from .jobs import Claim, record
from .models import EventRow, JobRow
from .states import State

RETURNED_EVENT = "attempt_returned"
"""Event of a worker that reported after its lease had run out."""

MAX_RETURNED_ATTEMPTS = 5
"""Largest number of attempts of one job that are returned: a job that always outlasts its lease is to end, too."""


def return_attempt(database: Database, claim: Claim) -> bool:
    """Take back the count of an attempt whose lease ran out while its worker lived; return whether it was.

    The fence tells the claim: the job is queued again, or a later claim runs it. A job that has ended is not changed.
    """
    with database.write() as session:
        events = (EventRow.job == claim.job) & (EventRow.kind == RETURNED_EVENT)
        if (session.scalar(select(func.count()).where(events)) or 0) >= MAX_RETURNED_ATTEMPTS:
            return False
        is_over = (JobRow.state == State.QUEUED) | ((JobRow.state == State.RUNNING) & (JobRow.fence > claim.fence))
        row = (JobRow.id == claim.job) & (JobRow.fence >= claim.fence) & is_over & (JobRow.attempts > 0)
        if change_rows(session, update(JobRow).where(row).values(attempts=JobRow.attempts - 1)) == 0:
            return False
        record(session, claim.job, RETURNED_EVENT, owner=claim.owner, attempt=claim.attempt)
        return True
