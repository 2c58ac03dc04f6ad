"""Recovery of the queue after failures: expired leases, stalled jobs, and the outbox.

One process at a time does it (`acquire_leader_lease`), but two do no harm: a claim is compare-and-set, so a second
wake-up for the same job finds nothing to claim.
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
"""Number of wake-ups that are published at once: a hundred a second, which blocks the loop that also passes jobs to the
children for less than 0.1 s (with 200 the first jobs of a long queue waited up to 0.6 s)."""


DISPATCHER_LEASE = "dispatcher"
"""Name of the leader lease for dispatching and reaping."""

LEADER_LEASE_TIME = 5.0
"""Duration of a leader lease [s]: the longest delay of the queue after a dispatcher dies."""

LOST_LEASE_SECONDS = 86400.0
"""Time for which the lease of a process that is known to be dead counts as expired [s]: beyond any patience."""

FORGET_SECONDS = 30.0
"""Time without a heartbeat after which a worker counts as dead [s]; it sends one every 5 s."""


def acquire_leader_lease(database: Database, name: str, owner: str, seconds: float) -> bool:
    """Take or renew a leader lease for some seconds; return False if another process has it, after a read alone."""
    is_stale = (LockRow.until < clock()) | (LockRow.until > clock() + seconds + AHEAD_SECONDS)
    is_free = (LockRow.owner == owner) | is_stale
    with database.read() as session:
        if session.scalar(select(LockRow.name).where(LockRow.name == name, ~is_free)) is not None:
            return False
    with database.write() as session:
        statement = update(LockRow).where(LockRow.name == name, is_free).values(owner=owner, until=clock() + seconds)
        if change_rows(session, statement) == 1:
            return True
        try:
            with session.begin_nested():
                session.execute(insert(LockRow).values(name=name, owner=owner, until=clock() + seconds))
        except IntegrityError:
            return False
        return True


def release_leader_lease(database: Database, name: str, owner: str) -> None:
    """Release a leader lease, so that another process need not wait."""
    with database.write() as session:
        session.execute(delete(LockRow).where(LockRow.name == name, LockRow.owner == owner))


@skip_damaged_rows
def reap(database: Database, max_attempts: int, patience: float = 0.0) -> int:
    """Requeue the jobs whose lease has expired; one that was lost too often ends as `dead`.

    Args:
        database: The jobs' database.
        max_attempts: Number of attempts after which a lost job ends.
        patience: Time beyond the lease of a last attempt before it ends the job [s]: a worker on an overloaded machine
            may be alive and renew it. A worker that is known to be dead has no such time.

    Returns:
        How many jobs were requeued or ended.
    """
    may_live = (JobRow.attempts >= max_attempts) & ~JobRow.cancel & (JobRow.lease_until > clock() - patience)
    is_lost = _is_expired() & ~may_live
    with database.read() as session:
        if not session.execute(select(exists().where(is_lost))).scalar():
            return 0
    with database.write() as session:
        expired = session.scalars(select(JobRow).where(is_lost).with_for_update(skip_locked=True)).all()
        for row in expired:
            expire(session, row, max_attempts)
        return len(expired)


@skip_damaged_rows
def republish_stalled_jobs(database: Database, seconds: float, is_broker_empty: Callable[[], bool]) -> int:
    """Add a wake-up for each queued job without events for some time [s] if the broker has no message at all.

    A broker that still has messages is only busy: further ones would accumulate.

    Returns:
        How many jobs were republished.
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
    """Record a worker's heartbeat, and remove workers without one for some seconds."""
    with database.write() as session:
        session.execute(delete(WorkerRow).where(WorkerRow.seen < clock() - forget_seconds))
        seen = update(WorkerRow).where(WorkerRow.name == name).values(seen=clock())
        if change_rows(session, seen) == 0:
            row = {"name": name, "queues": queues, "concurrency": concurrency}
            session.execute(insert(WorkerRow).values(**row, started=clock(), seen=clock()))


def remove_worker(database: Database, name: str) -> None:
    """Remove a stopping worker from the list."""
    with database.write() as session:
        session.execute(delete(WorkerRow).where(WorkerRow.name == name))


@skip_damaged_rows
def list_workers(database: Database) -> list[WorkerRow]:
    """Return the live workers by name; one that died is removed after `FORGET_SECONDS`."""
    lives = (WorkerRow.seen > clock() - FORGET_SECONDS) & (WorkerRow.seen < clock() + AHEAD_SECONDS)
    with database.read() as session:
        return list(session.scalars(select(WorkerRow).where(lives).order_by(WorkerRow.name)))


@skip_damaged_rows
def release_lost_leases(database: Database, mark: str, reason: str) -> None:
    """Release the lease of a process that is known to be dead, so that its job need not wait for the lease to expire.

    Args:
        database: The jobs' database.
        mark: End of the dead owner's name, unique to it.
        reason: What ended it: the signal or the exit status.
    """
    with database.write() as session:
        is_running = (JobRow.state == State.RUNNING) & JobRow.owner.endswith(mark, autoescape=True)
        for row in session.scalars(select(JobRow).where(is_running).with_for_update()):
            row.lease_until = clock() - LOST_LEASE_SECONDS
            record(session, row.id, WORKER_LOST_EVENT, attempt=row.attempts, reason=reason[:200])


@skip_damaged_rows
def dispatch(database: Database, publish: Callable[[str, str], None]) -> int:
    """Publish the outbox; a row is deleted only after its message was accepted, so a crash in between repeats it.

    Args:
        database: The outbox's database.
        publish: Sends one job id to a queue of the broker; its exceptions are raised and leave the row for later.

    Returns:
        How many messages were published.
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
