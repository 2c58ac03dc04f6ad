"""A running job returns to the queue, and its attempt does not count: by a worker's stop, an outage, or preemption."""

from __future__ import annotations

from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from ..core.run.errors import Unavailable
from .database import Database, clock, skip_damaged_rows
from .jobs import Claim, change_state, matches_claim
from .models import JobRow
from .outage import find_pause
from .shown_errors import show_message
from .states import State

PREEMPTED_EVENT = "preempted"
"""Kind of the event of a job that gave way to a more urgent one."""


@skip_damaged_rows
def release(database: Database, claim: Claim) -> None:
    """Return a running job to the queue, because the worker was stopped.

    Raises:
        FenceLost: if another worker has claimed the job.
    """
    with database.write() as session:
        _requeue(session, claim, "released")


@skip_damaged_rows
def give_way(database: Database, claim: Claim) -> None:
    """Return a running job to the queue, because a more urgent one waits.

    Raises:
        FenceLost: if another worker has claimed the job.
    """
    with database.write() as session:
        _requeue(session, claim, PREEMPTED_EVENT, preemptions=JobRow.preemptions + 1)


@skip_damaged_rows
def reschedule(database: Database, claim: Claim, outage: Unavailable, first_seconds: float) -> None:
    """Return a running job to the queue with a pause, because a resource is unavailable.

    Raises:
        FenceLost: if another worker has claimed the job.
    """
    with database.write() as session:
        delays = session.scalar(select(JobRow.delays).where(matches_claim(claim))) or 0
        pause = find_pause(first_seconds, delays)
        rest = {"delays": delays + 1, "delay_code": outage.code, "not_before": clock() + pause}
        note = {"code": outage.code, "message": show_message(outage), "seconds": pause}
        _requeue(session, claim, "put_off", note, **rest)


def _requeue(session: Session, claim: Claim, event: str, note: dict[str, Any] | None = None, **values: Any) -> None:
    """Queue a running job whose attempt does not count."""
    if session.scalar(select(JobRow.cancel).where(matches_claim(claim)).with_for_update()):
        change_state(session, claim, State.CANCELLED, "cancelled")  # no worker claims a cancelled job from the queue
    else:
        change_state(session, claim, State.QUEUED, event, note, attempts=JobRow.attempts - 1, **values)
