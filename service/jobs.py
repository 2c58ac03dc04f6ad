"""The only functions that write a job's state; `states.py` has the states and transitions.

A worker owns a job from `claim` until the row's fence differs from that of its claim. Every write of a worker checks
the fence, so a worker that lost its lease changes nothing. Times are the database's.
"""

from __future__ import annotations

import uuid
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar

from sqlalchemy import ColumnElement, Update, and_, select, update
from sqlalchemy.orm import Session

from .. import __version__
from ..core.run.errors import BadInput, GarmentqError, NotFound
from ..core.run.verdict import Verdict, worst_verdict
from .database import Database, change_rows, clock, skip_damaged_rows, starts_with
from .fairness import choose_job
from .listed import RESULT_FIELDS, list_request, read_listed_settings
from .models import EventRow, JobInputRow, JobRow, JobTagRow, JobWaitRow, OutboxRow
from .new_job import NewJob
from .shown_errors import show_message
from .states import ENDED, TRANSITIONS, State
from .webhooks import queue_messages

T = TypeVar("T")

IDS_AT_ONCE = 500
"""Number of values bound in one query; SQLite's limit is 32 766."""
WORKER_LOST_CODE, WORKER_LOST_EVENT = "job.worker_lost", "worker_lost"
"""Code of a job whose workers died too often; event of a worker process that died while it ran a job."""
RETRY_DEFAULTS = {
    "attempts": 0, "cancel": False, "finished": None, "stage": "", "progress": 0.0, "overall": 0.0,
    "bad_input": False, "error_code": None, "error_message": None, "verdict": None, "result": None,
    "preemptions": 0, "delays": 0, "delay_code": None, "not_before": None, **dict.fromkeys(RESULT_FIELDS),
}  # fmt: skip
"""Values that are reset when an ended job is retried."""


class JobUnknown(NotFound):
    """There is no such job; `garmentq status` lists them all."""

    code = "job.unknown"


class FenceLost(GarmentqError):
    """Another worker has taken the job over; this one's result is discarded."""

    code = "job.fence_lost"


class MoveForbidden(GarmentqError):
    """A job cannot change from its state to the requested one; this is a fault of garmentq, please report it."""

    code = "job.move_forbidden"


@dataclass(frozen=True)
class Claim:
    """Describe a worker's claim of one job.

    Attributes:
        job: The job's id.
        fence: Number of this claim; a later claim has a larger one.
        owner: Name of the worker process.
        attempt: Which attempt this is, from 1.
        request: The job's request, as it was stored at submission.
        name: Name of the job.
        kind: Name of its kind.
        inputs: Ids of the jobs whose results it reads, by name.
    """

    job: str
    fence: int
    owner: str
    attempt: int
    request: dict[str, Any]
    name: str
    kind: str = "recover"
    inputs: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class HeartbeatResult:
    """Describe the result of a heartbeat.

    Attributes:
        is_owner: False if another worker has claimed the job since.
        is_cancelled: True if the job was cancelled.
        is_preempted: True if the job is to give way to a more urgent one.
    """

    is_owner: bool
    is_cancelled: bool
    is_preempted: bool = False


def record(session: Session, job: str, kind: str, /, **data: Any) -> None:
    """Add one event."""
    session.add(EventRow(job=job, at=clock(), kind=kind, data=data))


def create(session: Session, new: NewJob) -> JobRow:
    """Add a job with its first event: queued, or waiting if it waits for siblings."""
    job = uuid.uuid4().hex[:12]
    columns = ("dedup", "kind", "request", "scan", "name", "priority", "queue", "payer", "lane")
    parent, family = new.parent or (None, job)
    since = clock() if parent is None else select(JobRow.family_created).where(JobRow.id == parent).scalar_subquery()
    row = JobRow(
        id=job,
        parent=parent,
        family=family,
        version=__version__,
        state=State.WAITING if new.waits else State.QUEUED,
        touched=clock(),
        created=clock(),
        family_created=since,
        **{name: getattr(new, name) for name in columns},
        **read_listed_settings(new.request),
    )
    session.add(row)
    list_request(session, job, new.request)
    session.add_all(JobTagRow(job=job, tag=tag) for tag in new.tags)
    session.add_all(JobInputRow(job=job, name=name, input=read) for name, read in new.inputs.items())
    session.add_all(JobWaitRow(job=job, awaited=other) for other in new.waits)
    record(session, job, row.state.value)
    if row.state == State.QUEUED:
        session.add(OutboxRow(job=job, created=clock()))
    return row


def change_state(
    session: Session, job: JobRow | Claim, to: State, event: str, note: dict[str, Any] | None = None, **values: Any
) -> None:
    """Write a job's new state, all columns that change with it, and the event that reports it.

    Args:
        session: A writing transaction.
        job: The row, locked in this transaction; or the claim of the worker that runs the job.
        to: The new state.
        event: Kind of the event.
        note: Data of the event.
        values: Further columns of the row.

    Raises:
        MoveForbidden: if `TRANSITIONS` does not have the change.
        FenceLost: if the claim is no longer valid.
    """
    source, key = (State.RUNNING, job.job) if isinstance(job, Claim) else (State(job.state), job.id)
    if to not in TRANSITIONS[source]:
        raise MoveForbidden(f"job {key} cannot change from {source} to {to}.")
    values = {"state": to, "touched": clock(), "owner": None, "lease_until": None, "expected_end": None, **values}
    if source in ENDED:
        values |= RETRY_DEFAULTS
    if to in ENDED:
        values["finished"] = clock()
    if isinstance(job, Claim):
        write_fenced(session, job, **values)
    else:
        for name, value in values.items():
            setattr(job, name, value)
    record(session, key, event, **(note or {}))
    if to in ENDED:
        queue_messages(session, key, to)
    if to == State.QUEUED:
        session.add(OutboxRow(job=key, created=clock()))


def claim(database: Database, job: str, owner: str, lease_seconds: float) -> Claim | None:
    """Claim a queued job, or return None if it is not available: one statement writes the whole claim."""
    with database.write() as session:
        return _claim(session, job, owner, lease_seconds)


@skip_damaged_rows
def claim_next(database: Database, wakeup: str, owner: str, lease_seconds: float) -> Claim | None:
    """Claim the most urgent job of the woken job's queue, or return None if that queue is empty.

    A wake-up permits one claim, not the claim of a certain job: priorities hold whatever order the broker keeps.
    """
    with database.write() as session:
        best = choose_job(session, wakeup)
        return None if best is None else _claim(session, best, owner, lease_seconds)


def renew(database: Database, claim: Claim, lease_seconds: float) -> HeartbeatResult:
    """Renew the lease and read the cancel flag in one statement."""
    with database.write() as session:
        row = session.execute(
            _update_claimed(claim)
            .values(lease_until=clock() + lease_seconds, touched=clock())
            .returning(JobRow.cancel, JobRow.preempt)
            .execution_options(synchronize_session=False)
        ).one_or_none()
    return _read_flags(row)


def read_flags(database: Database, claim: Claim) -> HeartbeatResult:
    """Read the flags of a claimed job without renewing the lease."""
    with database.read() as session:
        row = session.execute(select(JobRow.cancel, JobRow.preempt).where(matches_claim(claim))).one_or_none()
    return _read_flags(row)


def _read_flags(row: Any) -> HeartbeatResult:
    return HeartbeatResult(False, False) if row is None else HeartbeatResult(True, bool(row.cancel), bool(row.preempt))


def write_fenced(session: Session, claim: Claim, **values: Any) -> None:
    """Change the job's row if the claim is still valid; call it first in a transaction that writes anything for a job.

    Raises:
        FenceLost: if it is not; the transaction must be abandoned.
    """
    if change_rows(session, _update_claimed(claim).values(**values)) != 1:
        raise FenceLost()


def succeed(session: Session, claim: Claim, result: dict[str, Any]) -> None:
    """End a job as succeeded, with the worst verdict of its result's gates, in the transaction that stores its result.

    Raises:
        FenceLost: if another worker has claimed the job.
    """
    verdict = judge_result(result)
    change_state(
        session, claim, State.SUCCEEDED, "succeeded", progress=1.0, overall=1.0, result=result, verdict=verdict
    )


def judge_result(result: Mapping[str, Any]) -> str | None:
    """Return the worst verdict of a result's gates, or None if it has none."""
    gates = result.get("gates")
    return worst_verdict(Verdict(gate["verdict"]) for gate in gates) if gates else None


@skip_damaged_rows
def fail(database: Database, claim: Claim, code: str, message: str, bad_input: bool) -> None:
    """End a job with an error.

    Raises:
        FenceLost: if another worker has claimed the job.
    """
    with database.write() as session:
        error = {"error_code": code, "error_message": message, "bad_input": bad_input}
        change_state(session, claim, State.FAILED, "failed", {"code": code, "message": message}, **error)


def fail_with_result(session: Session, claim: Claim, error: GarmentqError, result: dict[str, Any]) -> None:
    """End a job with an error and a result that can be viewed, in the transaction that stores the result.

    Raises:
        FenceLost: if another worker has claimed the job.
    """
    message = show_message(error)
    note = {"code": error.code, "message": message}
    error_columns = {"error_code": error.code, "error_message": message, "bad_input": isinstance(error, BadInput)}
    change_state(session, claim, State.FAILED, "failed", note, result=result, **error_columns)


@skip_damaged_rows
def end_cancelled(database: Database, claim: Claim) -> None:
    """End a running job that was cancelled.

    Raises:
        FenceLost: if another worker has claimed the job.
    """
    with database.write() as session:
        change_state(session, claim, State.CANCELLED, "cancelled")


def expire(session: Session, row: JobRow, max_attempts: int) -> None:
    """End the claim of an expired lease: requeue the job, or end it if it was cancelled or lost too often."""
    note = {"owner": row.owner, "attempt": row.attempts}
    if row.cancel:
        change_state(session, row, State.CANCELLED, "cancelled")
    elif row.attempts >= max_attempts:
        message = (
            f"the worker died in each of {row.attempts} attempts, last in stage "
            f"'{row.stage or 'start'}'{_describe_loss(session, row)}; "
            "see the worker's log, then `garmentq retry`."
        )
        change_state(session, row, State.DEAD, "dead", note, error_code=WORKER_LOST_CODE, error_message=message)
    else:
        change_state(session, row, State.QUEUED, "lease_expired", note)


def find_job(database: Database, job: str) -> JobRow:
    """Return a job by its id, or by a beginning of the id that no other job has.

    Raises:
        JobUnknown: if no job, or more than one, matches.
    """
    with database.read() as session:
        row = session.get(JobRow, job)
        if row is not None:
            return row
        rows = session.scalars(select(JobRow).where(starts_with(JobRow.id, job)).limit(2)).all()
    if len(rows) == 1 and len(job) >= 4:
        return rows[0]
    raise JobUnknown(f"there is no job '{job}'; `garmentq status` lists them all.")


def find_jobs_by_id(database: Database, jobs: Sequence[str]) -> list[JobRow]:
    """Return the jobs of some ids, in the order of the ids."""
    found: dict[str, JobRow] = {}
    with database.read() as session:
        for start in range(0, len(jobs), IDS_AT_ONCE):
            chunk = jobs[start : start + IDS_AT_ONCE]
            found |= {row.id: row for row in session.scalars(select(JobRow).where(JobRow.id.in_(chunk)))}
    return [found[job] for job in jobs if job in found]


def order_by_ids(ids: Sequence[str], found: Mapping[str, T]) -> list[T]:
    """Return the values of some ids, in the order of the ids.

    Raises:
        JobUnknown: if one is missing.
    """
    missing = [job for job in ids if job not in found]
    if missing:
        raise JobUnknown(f"there is no job '{missing[0]}'; `garmentq status` lists them all.")
    return [found[job] for job in ids]


def read_events(database: Database, job: str, after: int = 0, limit: int | None = None) -> list[EventRow]:
    """Return a job's events with an id above `after`, in order; with `limit` only the first."""
    with database.read() as session:
        statement = select(EventRow).where(EventRow.job == job, EventRow.id > after)
        return list(session.scalars(statement.order_by(EventRow.id).limit(limit)))


def _claim(session: Session, job: str, owner: str, lease_seconds: float) -> Claim | None:
    row = session.execute(
        update(JobRow)
        .where(JobRow.id == job, JobRow.state == State.QUEUED, JobRow.cancel.is_(False))
        .values(
            state=State.RUNNING,
            owner=owner,
            lease_until=clock() + lease_seconds,
            attempts=JobRow.attempts + 1,
            fence=JobRow.fence + 1,
            not_before=None,
            preempt=False,
            started=clock(),
            touched=clock(),
        )
        .returning(JobRow.fence, JobRow.attempts, JobRow.request, JobRow.name, JobRow.kind)
        .execution_options(synchronize_session=False)
    ).one_or_none()
    if row is None:
        return None
    reads = session.execute(select(JobInputRow.name, JobInputRow.input).where(JobInputRow.job == job))
    inputs = {one.name: one.input for one in reads}
    record(session, job, "started", owner=owner, attempt=row.attempts)
    return Claim(job, row.fence, owner, row.attempts, row.request, row.name, row.kind, inputs)


def matches_claim(claim: Claim) -> ColumnElement[bool]:
    """Return the condition of the claimed job's row while the claim is valid."""
    return and_(JobRow.id == claim.job, JobRow.fence == claim.fence, JobRow.state == State.RUNNING)


def _update_claimed(claim: Claim) -> Update:
    return update(JobRow).where(matches_claim(claim))


def _describe_loss(session: Session, row: JobRow) -> str:
    """Return what ended the last attempt, if it is known."""
    condition = (EventRow.job == row.id) & (EventRow.kind == WORKER_LOST_EVENT)
    last = session.scalars(select(EventRow).where(condition).order_by(EventRow.id.desc()).limit(1)).one_or_none()
    return f" ({last.data['reason']})" if last and last.data["attempt"] == row.attempts else ""
