"""Families of jobs: operations that pass from a parent to its children, and jobs that wait for siblings.

A job's children are made with its result, so a job with children has succeeded; only jobs below it can be retried. Rows
are locked from the parent down, one level at a time: while a job's row is locked, it gets no children.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence

from sqlalchemy import ColumnElement, exists, select
from sqlalchemy import delete as delete_rows
from sqlalchemy.orm import Session, aliased

from ..core.run.errors import BadInput, GarmentqError
from .batches import forget_tags
from .database import Database, skip_damaged_rows
from .jobs import IDS_AT_ONCE, JobUnknown, change_state, create, record
from .keys import check_quota, grant_job
from .kinds.kind import PARENT, ChildRequest
from .lanes import Lane
from .models import IdempotencyRow, JobInputRow, JobRow, JobTagRow, JobWaitRow, OwnerRow, SubjectJobRow
from .new_job import NewJob
from .states import OPEN, UNSUCCESSFUL, State

AWAITED_FAILED_CODE = "job.awaited_failed"
"""Code of a job whose sibling did not succeed."""

WAITING_JOB_BATCH_SIZE = 50
"""Number of waiting jobs that one transaction checks."""


class JobNotEnded(BadInput):
    """The job has not ended; cancel it first, or wait."""

    code = "job.not_ended"


class JobSucceeded(BadInput):
    """The job succeeded and cannot be retried; submit it with --force to compute it again."""

    code = "job.succeeded"


class JobInUse(BadInput):
    """Another job reads this one's result, or waits for it; delete that one first."""

    code = "job.in_use"


class ChildrenBad(GarmentqError):
    """A job requests invalid children; this is a fault of its kind, please report it."""

    code = "job.children_bad"


def find_tree(session: Session, row: JobRow, is_locked: bool = False) -> list[JobRow]:
    """Return a job and all below it, parents before their children; if they are to be locked, `row` must be locked."""
    tree, level = [row], [row.id]
    while level:
        below = select(JobRow).where(JobRow.parent.in_(level)).order_by(JobRow.created, JobRow.id)
        found = session.scalars(below.with_for_update() if is_locked else below).all()
        tree += found
        level = [one.id for one in found]
    return tree


def find_below(database: Database, jobs: Sequence[str]) -> list[JobRow]:
    """Return all jobs below some others, without those themselves, level by level, each in order of creation."""
    known, level, found = set(jobs), list(jobs), list[JobRow]()
    with database.read() as session:
        while level:
            below: list[JobRow] = []
            for start in range(0, len(level), IDS_AT_ONCE):
                chunk = level[start : start + IDS_AT_ONCE]
                below += session.scalars(select(JobRow).where(JobRow.parent.in_(chunk)))
            new = sorted((row for row in below if row.id not in known), key=lambda row: (row.created, row.id))
            found += new
            level = [row.id for row in new]
            known.update(level)
    return found


def cancel(database: Database, job: str, key: str = "") -> State:
    """Stop a job and all below it: queued and waiting jobs end at once, running ones at their worker's next check.

    If other API keys requested the job too, it continues for them, and `key` no longer sees it.

    Returns:
        The job's own state after this call: `cancelled`, `running`, or the state it had ended in before.

    Raises:
        JobUnknown: if there is none of that id.
    """
    with database.write() as session:
        row = _lock(session, job)
        tree = find_tree(session, row, is_locked=True)
        ids = [one.id for one in tree]
        if key and session.scalar(select(exists().where(OwnerRow.job == job, OwnerRow.key != key))):
            session.execute(delete_rows(OwnerRow).where(OwnerRow.key == key, OwnerRow.job.in_(ids)))
            return row.state
        for one in tree:
            _cancel(session, one)
        return row.state


def retry(database: Database, job: str, key: str = "", quota: int = 0) -> State:
    """Queue all unsuccessful jobs of a job and those below it again, with all attempts; checkpoints are reused.

    A job that waits for an unsuccessful sibling requeues that sibling too.

    Returns:
        The job's own state after this call.

    Raises:
        JobUnknown: if there is none of that id.
        JobNotEnded: if it is queued or running, or nothing below it has ended without success.
        JobSucceeded: if it and all below it succeeded.
        QueueFull: if the caller's API key has reached its number of open jobs.
    """
    with database.write() as session:
        parent = session.scalar(select(JobRow.parent).where(JobRow.id == job))
        if parent is not None:
            _lock(session, parent)  # several siblings may only be locked with their parent
        row = _lock(session, job)
        tree = find_tree(session, row, is_locked=True)
        stuck = [one for one in tree if one.state in UNSUCCESSFUL]
        unended = next((one for one in tree if one.state in OPEN), None)
        if unended is not None and (unended is row or not stuck):
            raise JobNotEnded(f"job {unended.id} is {unended.state}; cancel it first, or wait.")
        if not stuck:
            raise JobSucceeded()
        requeue_jobs(session, stuck, "retried", key, quota)
        return row.state


def requeue_jobs(session: Session, rows: Sequence[JobRow], event: str, payer: str, quota: int) -> None:
    """Queue locked jobs that ended without success, with the siblings they wait for.

    Raises:
        QueueFull: if the payer has reached its number of open jobs.
    """
    left, chosen = {row.id: row for row in rows}, dict[str, tuple[JobRow, State]]()
    while left:
        _, row = left.popitem()
        waits = select(JobWaitRow.awaited).where(JobWaitRow.job == row.id)
        siblings = select(JobRow).where(JobRow.id.in_(waits)).order_by(JobRow.id)
        awaited = session.scalars(siblings.with_for_update()).all()
        chosen[row.id] = row, State.WAITING if awaited else State.QUEUED
        left |= {one.id: one for one in awaited if one.state in UNSUCCESSFUL and one.id not in chosen}
    check_quota(session, payer, quota)  # it locks the key's row last: workers lock job rows first
    for row, state in chosen.values():
        change_state(session, row, state, event, payer=payer)


def delete(database: Database, jobs: Sequence[str]) -> tuple[str, ...]:
    """Delete ended jobs and all below them, with events and results; `gc` deletes the files that no row names then.

    Returns:
        The ids of the deleted jobs.

    Raises:
        JobUnknown: if there is none of an id; nothing is deleted then, as after every other refusal.
        JobNotEnded: if one of them has not ended.
        JobInUse: if another job reads one's result or waits for it.
    """
    with database.write() as session:
        tree = _lock_trees(session, jobs)
        ids = [one.id for one in tree]
        if missing := set(jobs) - set(ids):
            raise JobUnknown(f"there is no job '{min(missing)}'; `garmentq status` lists them all.")
        for one in tree:
            if one.state in OPEN:
                raise JobNotEnded(f"job {one.id} is {one.state}; cancel it first, or wait.")
        for table, column in ((JobInputRow, JobInputRow.input), (JobWaitRow, JobWaitRow.awaited)):
            users = select(table.job, column).where(column.in_(ids), table.job.not_in(ids)).limit(1)
            if (user := session.execute(users).one_or_none()) is not None:
                raise JobInUse(f"job {user[0]} uses the result of {user[1]}; delete that one first.")
        session.execute(delete_rows(IdempotencyRow).where(IdempotencyRow.job.in_(ids)))
        tags = session.scalars(select(JobTagRow.tag).where(JobTagRow.job.in_(ids)).distinct()).all()
        for table in (JobInputRow, JobWaitRow):
            session.execute(delete_rows(table).where(table.job.in_(ids)))
        session.execute(delete_rows(JobRow).where(JobRow.id.in_(ids)))
        forget_tags(session, tags)
        return tuple(ids)


def _lock_trees(session: Session, jobs: Sequence[str]) -> list[JobRow]:
    """Return some jobs and all below them, locked, parents before their children."""
    known: dict[str, JobRow] = {}
    is_next = JobRow.id.in_(jobs)
    while True:
        statement = select(JobRow).where(is_next).order_by(JobRow.created, JobRow.id).with_for_update()
        level = [row for row in session.scalars(statement) if row.id not in known]
        if not level:
            return list(known.values())
        known |= {row.id: row for row in level}
        is_next = JobRow.parent.in_([row.id for row in level])


@skip_damaged_rows
def release_waiting_jobs(database: Database) -> int:
    """Queue the waiting jobs whose siblings have succeeded, and end those with a sibling that ended otherwise.

    Returns:
        How many jobs were queued or ended.
    """
    with database.read() as session:
        if not session.execute(select(exists().where(_is_ready()))).scalar():
            return 0
    with database.write() as session:
        ready = (
            select(JobRow)
            .where(_is_ready())
            .order_by(JobRow.id)
            .limit(WAITING_JOB_BATCH_SIZE)
            .with_for_update(skip_locked=True)
        )
        rows = session.scalars(ready).all()
        for row in rows:
            _release_waiting_job(session, row)
        return len(rows)


def make_children(session: Session, parent: str, children: Sequence[ChildRequest]) -> dict[str, str]:
    """Create the children that a result requests, in the transaction that stores it.

    They have their parent's priority or a lower one, its tags, subject, payer and owners. If the parent was cancelled
    meanwhile, they are created as cancelled, so that a retry finds them.

    Returns:
        Their ids by name.

    Raises:
        ChildrenBad: if a name is repeated, or `waits` names no earlier sibling.
    """
    if not children:
        return {}
    row = session.get_one(JobRow, parent, populate_existing=True)
    tags = tuple(session.scalars(select(JobTagRow.tag).where(JobTagRow.job == parent)))
    owners = session.scalars(select(OwnerRow.key).where(OwnerRow.job == parent)).all()
    subject = session.scalar(select(SubjectJobRow.subject).where(SubjectJobRow.job == parent))
    made: dict[str, JobRow] = {}
    for child in children:
        if child.name in made or not set(child.waits) <= set(made):
            raise ChildrenBad(f"the child '{child.name[:40]}' of job {parent} is repeated or waits for no earlier one.")
        dedup = hashlib.sha256(f"{parent} {child.name}".encode()).hexdigest()
        known = session.scalars(select(JobRow).where(JobRow.dedup == dedup)).one_or_none()
        made[child.name] = known or create(session, _describe(row, child, dedup, tags, made))
        if subject is not None and known is None:
            session.add(SubjectJobRow(job=made[child.name].id, subject=subject))
        for key in owners:
            grant_job(session, key, made[child.name].id)
        if row.cancel:
            _cancel(session, made[child.name])
    return {name: one.id for name, one in made.items()}


def grant_family(session: Session, key: str, row: JobRow) -> None:
    """Make a key an owner of a locked job and of all below it; a later child copies its parent's owners."""
    for one in find_tree(session, row, is_locked=True):
        grant_job(session, key, one.id)


def _lock(session: Session, job: str) -> JobRow:
    row = session.get(JobRow, job, with_for_update=True)
    if row is None:
        raise JobUnknown(f"there is no job '{job}'; `garmentq status` lists them all.")
    return row


def _cancel(session: Session, row: JobRow) -> None:
    if row.state in (State.WAITING, State.QUEUED):
        change_state(session, row, State.CANCELLED, "cancelled")
    elif row.state == State.RUNNING and not row.cancel:
        row.cancel = True
        record(session, row.id, "cancel_requested")


def _is_ready() -> ColumnElement[bool]:
    """Return the condition of a waiting job without open siblings that it waits for."""
    awaited = aliased(JobRow)
    on = (JobWaitRow.job == JobRow.id) & (JobWaitRow.awaited == awaited.id) & awaited.state.in_(OPEN)
    return (JobRow.state == State.WAITING) & ~exists().where(on)


def _release_waiting_job(session: Session, row: JobRow) -> None:
    awaited = select(JobRow.id, JobRow.state).join(JobWaitRow, JobWaitRow.awaited == JobRow.id)
    left = session.execute(
        awaited.where(JobWaitRow.job == row.id, JobRow.state != State.SUCCEEDED).order_by(JobRow.id)
    ).all()
    if any(one.state in OPEN for one in left):
        return  # retried since it was found ready
    failed = next(iter(left), None)
    if failed is None:
        change_state(session, row, State.QUEUED, "queued")
        return
    message = f"it waited for job {failed.id}, which is {failed.state}; `garmentq retry {row.id}` retries both."
    note = {"code": AWAITED_FAILED_CODE, "message": message}
    change_state(session, row, State.FAILED, "failed", note, error_code=AWAITED_FAILED_CODE, error_message=message)


def _describe(
    parent: JobRow, child: ChildRequest, dedup: str, tags: tuple[str, ...], siblings: Mapping[str, JobRow]
) -> NewJob:
    places = {PARENT: parent.id, **{name: siblings[name].id for name in child.waits}}
    return NewJob(
        dedup,
        child.kind,
        child.request,
        parent.scan,
        child.name,
        priority=parent.priority if child.priority is None else min(parent.priority, child.priority),
        queue=child.queue or parent.queue,
        lane=Lane(parent.lane) if child.lane is None else child.lane,
        payer=parent.payer,
        tags=tags,
        inputs={name: places.get(read, read) for name, read in child.inputs.items()},
        parent=(parent.id, parent.family or parent.id),
        waits=tuple(siblings[name].id for name in child.waits),
    )
