"""What keeps the queue moving when something died: expired leases, forgotten jobs, and the outbox.

One process at a time does it (`acquire_leader_lease`), but nothing breaks where two do: a claim is compare-and-set, so
a second wake-up for the same job finds nothing to claim.
"""

from __future__ import annotations

from collections.abc import Callable

from sqlalchemy import ColumnElement, delete, exists, insert, select, update
from sqlalchemy.exc import IntegrityError

from .clocks import AHEAD_SECONDS
from .database import Database, change_rows, clock, skip_damaged_rows
from .fairness import is_due
from .jobs import WORKER_LOST_EVENT, expire, record
from .models import JobRow, LockRow, OutboxRow, WorkerRow
from .states import OPEN, State

WAKE_UP_BATCH_SIZE = 50
"""Number of wake-ups that are published at once: a hundred a second, and the loop that also hands jobs to the children
rests for less than 0.1 s (with 200 the first jobs of a long queue waited up to 0.6 s)."""


DISPATCHER_LEASE = "dispatcher"
"""Name of the duty to dispatch and reap."""

LEADER_LEASE_TIME = 5.0
"""How long the duty outlives its holder [s]: what a dead dispatcher delays the queue at most."""

FORGET_SECONDS = 30.0
"""A worker that has not said so for so long lives no more [s]; it says so every 5 s."""


def acquire_leader_lease(database: Database, name: str, owner: str, seconds: float) -> bool:
    """Take or renew a duty for some seconds; False where another process has it."""
    with database.write() as session:
        is_stale = (LockRow.until < clock()) | (LockRow.until > clock() + seconds + AHEAD_SECONDS)
        is_free = (LockRow.owner == owner) | is_stale
        held = update(LockRow).where(LockRow.name == name, is_free).values(owner=owner, until=clock() + seconds)
        if change_rows(session, held) == 1:
            return True
        try:
            with session.begin_nested():
                session.execute(insert(LockRow).values(name=name, owner=owner, until=clock() + seconds))
        except IntegrityError:
            return False
        return True


def release_leader_lease(database: Database, name: str, owner: str) -> None:
    """Drop a duty, so that another process need not wait."""
    with database.write() as session:
        session.execute(delete(LockRow).where(LockRow.name == name, LockRow.owner == owner))


@skip_damaged_rows
def reap(database: Database, max_attempts: int) -> int:
    """Take back the jobs whose owners no longer renew their lease; one that was lost too often ends as `dead`.

    Returns:
        How many jobs were taken back.
    """
    with database.read() as session:
        if not session.execute(select(exists().where(_is_expired()))).scalar():
            return 0
    with database.write() as session:
        expired = session.scalars(select(JobRow).where(_is_expired()).with_for_update(skip_locked=True)).all()
        for row in expired:
            expire(session, row, max_attempts)
        return len(expired)


@skip_damaged_rows
def republish_stalled_jobs(database: Database, seconds: float, is_broker_empty: Callable[[], bool]) -> int:
    """Owe a new wake-up to each queued job that saw nothing for so long [s] while the broker holds no message at all.

    A broker that still holds messages is only busy: publishing again would pile them up.

    Returns:
        How many jobs were forgotten.
    """
    with database.read() as session:
        if not session.execute(select(exists().where(_is_forgotten(seconds)))).scalar():
            return 0
    if not is_broker_empty():
        return 0
    with database.write() as session:
        statement = (
            select(JobRow).where(_is_forgotten(seconds)).limit(WAKE_UP_BATCH_SIZE).with_for_update(skip_locked=True)
        )
        forgotten = session.scalars(statement).all()
        for row in forgotten:
            row.touched = clock()
            session.add(OutboxRow(job=row.id, created=clock()))
            record(session, row.id, "republished")
        return len(forgotten)


def record_heartbeat(database: Database, name: str, queues: str, concurrency: int, forget_seconds: float) -> None:
    """Record that a worker lives, and forget those that have not said so for some seconds."""
    with database.write() as session:
        session.execute(delete(WorkerRow).where(WorkerRow.seen < clock() - forget_seconds))
        seen = update(WorkerRow).where(WorkerRow.name == name).values(seen=clock())
        if change_rows(session, seen) == 0:
            row = {"name": name, "queues": queues, "concurrency": concurrency}
            session.execute(insert(WorkerRow).values(**row, started=clock(), seen=clock()))


def remove_worker(database: Database, name: str) -> None:
    """Take a worker that stops off the list."""
    with database.write() as session:
        session.execute(delete(WorkerRow).where(WorkerRow.name == name))


@skip_damaged_rows
def list_workers(database: Database) -> list[WorkerRow]:
    """Return the living workers by name; whoever died without a word is off the list after `FORGET_SECONDS`."""
    lives = (WorkerRow.seen > clock() - FORGET_SECONDS) & (WorkerRow.seen < clock() + AHEAD_SECONDS)
    with database.read() as session:
        return list(session.scalars(select(WorkerRow).where(lives).order_by(WorkerRow.name)))


@skip_damaged_rows
def release_lost_leases(database: Database, mark: str, reason: str) -> None:
    """Release the lease of a process that is known to be dead, so that its job need not wait for the end of it.

    Args:
        database: Where the job is.
        mark: End of the dead owner's name, unique to it.
        reason: What ended it: the signal or the exit status.
    """
    with database.write() as session:
        held = (JobRow.state == State.RUNNING) & JobRow.owner.endswith(mark, autoescape=True)
        for row in session.scalars(select(JobRow).where(held).with_for_update()):
            row.lease_until = clock() - 1.0
            record(session, row.id, WORKER_LOST_EVENT, attempt=row.attempts, reason=reason[:200])


@skip_damaged_rows
def dispatch(database: Database, publish: Callable[[str, str], None]) -> int:
    """Publish what the outbox owes; a row goes only after its message was taken, so a crash between repeats it.

    Args:
        database: Where the outbox is.
        publish: Sends one job id to a queue of the broker; its exceptions pass through and leave the row for later.

    Returns:
        How many messages went out.
    """
    with database.read() as session:
        owed = session.execute(
            select(OutboxRow.id, OutboxRow.job, JobRow.queue)
            .join(JobRow, JobRow.id == OutboxRow.job)
            .where(is_due())
            .order_by(OutboxRow.id)
            .limit(WAKE_UP_BATCH_SIZE)
        ).all()
    sent: list[int] = []
    try:
        for row in owed:
            publish(row.job, row.queue)
            sent.append(row.id)
    finally:
        if sent:
            with database.write() as session:
                session.execute(delete(OutboxRow).where(OutboxRow.id.in_(sent)))
    return len(sent)


def is_idle(database: Database, seconds: float) -> bool:
    """Return whether nothing is queued or running, and nothing happened for some seconds."""
    busy = JobRow.state.in_(OPEN) | (JobRow.touched > clock() - seconds)
    with database.read() as session:
        return not session.execute(select(exists().where(busy))).scalar()


def _is_expired() -> ColumnElement[bool]:
    return (JobRow.state == State.RUNNING) & (JobRow.lease_until < clock())


def _is_forgotten(seconds: float) -> ColumnElement[bool]:
    owed = exists().where(OutboxRow.job == JobRow.id)
    return (JobRow.state == State.QUEUED) & (JobRow.touched < clock() - seconds) & ~owed
