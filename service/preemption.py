"""Preemption: a running job of the batch lane gives way to a job that somebody waits for.

The dispatcher marks the job; its worker returns it to the queue at its next checkpoint or soon after.
"""

from __future__ import annotations

from sqlalchemy import ColumnElement, exists, func, or_, select
from sqlalchemy.orm import Session

from .database import Database, clock, skip_damaged_rows
from .fairness import is_in_queue
from .lanes import Lane
from .models import JobRow
from .reaper import list_workers
from .states import QUEUES, State

MAX_PREEMPTIONS = 10
"""Number of times that a job gives way; afterwards it runs to its end. Each time it loses what it has computed since
its last checkpoint, at most one stage's work: ten times as a user edits for minutes beside it."""

NEAR_END_SECONDS = 5.0
"""Time to the expected end of a job below which it is not preempted [s]: with what giving way takes at worst (9 s), an
edit waits 14 s where the expectation is right."""


@skip_damaged_rows
def preempt(database: Database) -> int:
    """Mark as many running batch jobs of each queue as urgent jobs wait for which no worker is free.

    Marks for which no urgent job waits any more are removed.

    Returns:
        How many marks were set or removed.
    """
    with database.read() as session:
        is_marked = (JobRow.state == State.RUNNING) & JobRow.preempt
        if not session.scalar(select(or_(exists().where(is_marked), *(exists().where(_waits(q)) for q in QUEUES)))):
            return 0
    workers = [(set(worker.queues.split(",")), worker.concurrency) for worker in list_workers(database)]
    with database.write() as session:
        return sum(_mark(session, queue, workers) for queue in QUEUES)


def _waits(queue: str) -> ColumnElement[bool]:
    """Return the condition of a job for which another one is preempted."""
    return is_in_queue(queue) & (JobRow.lane < Lane.BATCH)


def _mark(session: Session, queue: str, workers: list[tuple[set[str], int]]) -> int:
    served = [one for one in workers if queue in one[0]]
    queues = set().union(*(names for names, _ in served))
    size = sum(number for names, number in workers if names & queues)
    is_running = (JobRow.state == State.RUNNING) & JobRow.queue.in_(queues)
    running = session.scalar(select(func.count()).where(is_running)) or 0
    some = select(JobRow.id).where(_waits(queue)).limit(size)
    waiting = session.scalar(select(func.count()).select_from(some.subquery())) or 0
    is_own = (JobRow.state == State.RUNNING) & (JobRow.queue == queue)
    marked = session.scalars(select(JobRow).where(is_own, JobRow.preempt).order_by(JobRow.id).with_for_update()).all()
    needed = waiting - max(0, size - running) - len(marked)
    for row in marked[: max(0, -needed)]:
        row.preempt = False
    if needed <= 0:
        return min(len(marked), -needed)
    is_near_end = JobRow.expected_end.between(clock(), clock() + NEAR_END_SECONDS)
    may = (JobRow.lane == Lane.BATCH) & (JobRow.preemptions < MAX_PREEMPTIONS) & JobRow.cancel.is_(False)
    may &= JobRow.preempt.is_(False) & or_(JobRow.expected_end.is_(None), ~is_near_end)
    latest = select(JobRow).where(is_own, may).order_by(JobRow.started.desc(), JobRow.id).limit(needed)
    chosen = session.scalars(latest.with_for_update(skip_locked=True)).all()
    for row in chosen:
        row.preempt = True
    return len(chosen)
