"""Choice of the next queued job: first lane, highest priority, payer served longest ago, that payer's oldest family.

A family's jobs stand at the time of its root: the garments of a person go before the next person.

A payer is the API key that a job counts for, or empty: a thousand jobs of one payer do not delay all others. Each step
reads the first entries of the index `ix_jobs_urgency`, so the cost does not grow with the queue.
"""

from __future__ import annotations

from dataclasses import dataclass

from sqlalchemy import ColumnElement, func, or_, select, update
from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session, aliased

from .database import change_rows, clock
from .models import JobRow, PayerRow
from .outage import MAX_OUTAGE_PAUSE
from .states import State


def is_due() -> ColumnElement[bool]:
    """Return the condition of a job whose pause is over; an overlong pause is of a clock that was set back."""
    return or_(
        JobRow.not_before.is_(None), JobRow.not_before <= clock(), JobRow.not_before > clock() + MAX_OUTAGE_PAUSE
    )


@dataclass(frozen=True)
class Front:
    """Describe the first lane and priority of some waiting jobs: the conditions of those jobs, and of all behind."""

    condition: ColumnElement[bool]
    behind: ColumnElement[bool]


def is_in_queue(queue: str) -> ColumnElement[bool]:
    """Return the condition of a job that a worker of a queue may claim."""
    return (JobRow.state == State.QUEUED) & (JobRow.queue == queue) & JobRow.cancel.is_(False) & is_due()


def find_front(session: Session, waits: ColumnElement[bool]) -> Front | None:
    """Return the first lane, and in it the highest priority, of the jobs that meet a condition; None without any."""
    order = JobRow.lane, JobRow.priority.desc()
    first = session.execute(select(JobRow.lane, JobRow.priority).where(waits).order_by(*order).limit(1)).one_or_none()
    if first is None:
        return None
    is_lane = JobRow.lane == first.lane
    behind = (JobRow.lane > first.lane) | (is_lane & (JobRow.priority < first.priority))
    return Front(is_lane & (JobRow.priority == first.priority), behind)


def choose_job(session: Session, wakeup: str) -> str | None:
    """Return the id of the next job in the queue of a woken job, locked; None if that queue is empty."""
    queue = session.scalar(select(JobRow.queue).where(JobRow.id == wakeup))
    waits = is_in_queue(queue or "")
    front = find_front(session, waits)
    if front is None:
        return None
    waits &= front.condition
    for payer in rank_payers(session, waits):
        age = JobRow.family_created, JobRow.created, JobRow.id
        oldest = select(JobRow.id).where(waits, JobRow.payer == payer).order_by(*age).limit(1)
        if (job := session.scalar(oldest.with_for_update(skip_locked=True))) is not None:
            _note_served(session, payer)
            return job
    return None


def rank_payers(session: Session, waits: ColumnElement[bool]) -> list[str]:
    """Return the payers that have waiting jobs, the one served longest ago first; one index lookup for each."""
    first = select(func.min(JobRow.payer).label("payer")).where(waits).cte("waiting", recursive=True)
    before = aliased(first)
    after = select(func.min(JobRow.payer)).where(waits, JobRow.payer > before.c.payer).scalar_subquery()
    payers = first.union_all(select(after).where(before.c.payer.is_not(None)))
    served = func.coalesce(PayerRow.served, 0.0)
    ranked = select(payers.c.payer).outerjoin(PayerRow, PayerRow.payer == payers.c.payer)
    return list(session.scalars(ranked.where(payers.c.payer.is_not(None)).order_by(served, payers.c.payer)))


def _note_served(session: Session, payer: str) -> None:
    if change_rows(session, update(PayerRow).where(PayerRow.payer == payer).values(served=clock())):
        return
    try:
        with session.begin_nested():
            session.add(PayerRow(payer=payer, served=clock()))
            session.flush()
    except IntegrityError:
        pass  # another worker has just added the payer
