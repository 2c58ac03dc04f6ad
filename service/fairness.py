"""Which queued job is next: the most urgent; of equally urgent ones that of the payer who waited longest; its oldest.

A payer is the API key that a job counts for, or empty: who hands in a thousand jobs does not stand before everybody
else. Each step reads the first entries of the index `ix_jobs_urgency`, however long the queue is.
"""

from __future__ import annotations

from sqlalchemy import ColumnElement, func, or_, select, update
from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session, aliased

from .database import change_rows, clock
from .models import JobRow, PayerRow
from .outage import MAX_OUTAGE_PAUSE
from .states import State


def is_due() -> ColumnElement[bool]:
    """Return the condition of a job that does not rest; a rest longer than any is of a clock that was set back."""
    return or_(
        JobRow.not_before.is_(None), JobRow.not_before <= clock(), JobRow.not_before > clock() + MAX_OUTAGE_PAUSE
    )


def choose_job(session: Session, wakeup: str) -> str | None:
    """Return the id of the job that is next in the queue of a woken job, locked; None where that queue is empty."""
    queue = session.scalar(select(JobRow.queue).where(JobRow.id == wakeup))
    waits = (JobRow.state == State.QUEUED) & (JobRow.queue == queue) & JobRow.cancel.is_(False) & is_due()
    urgency = session.scalar(select(JobRow.priority).where(waits).order_by(JobRow.priority.desc()).limit(1))
    if urgency is None:
        return None
    waits &= JobRow.priority == urgency
    for payer in _rank_payers(session, waits):
        first = select(JobRow.id).where(waits, JobRow.payer == payer).order_by(JobRow.created, JobRow.id).limit(1)
        if (job := session.scalar(first.with_for_update(skip_locked=True))) is not None:
            _note_served(session, payer)
            return job
    return None


def _rank_payers(session: Session, waits: ColumnElement[bool]) -> list[str]:
    """Return who has jobs that wait, the one served longest ago first; one look into the index for each."""
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
        pass  # another worker serves the same payer for the first time just now
