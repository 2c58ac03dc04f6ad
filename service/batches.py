"""Batches: the jobs with a tag, their progress and their failures."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import fields, replace
from typing import Any

from sqlalchemy import ColumnElement, case, delete, exists, func, select
from sqlalchemy.orm import Session

from ..core.run.errors import NotFound
from .batch_records import Batch, BatchFailure, BatchReport, FamilyCount
from .clocks import AHEAD_SECONDS
from .database import Database, clock, skip_damaged_rows
from .models import BatchRow, JobRow, JobTagRow, OwnerRow, WorkerRow
from .pace import find_mean_seconds
from .reaper import FORGET_SECONDS
from .records import Failure
from .states import OPEN, UNSUCCESSFUL, State

MAX_BATCH_PAGE = 200
"""Largest number of batches of one list."""

MAX_BATCH_FAILURES = 100
"""Largest number of failures of a batch's report; `query` lists all."""

FAILED_STATES = (State.FAILED, State.DEAD)
"""States of the jobs of which a batch's report says why they ended."""

PERSON, RECOVER = "person", "recover"
"""Kind of the jobs that find garments, and of those that recover them."""


class BatchUnknown(NotFound):
    """No job has this tag; the list of batches has every tag in use."""

    code = "batch.unknown"


def note_tags(session: Session, key: str, tags: Collection[str]) -> None:
    """Store that a key (empty: the local user) orders a job with some tags now."""
    for tag in sorted(set(tags)):  # in one order: two transactions cannot wait for each other
        row = session.get(BatchRow, (key, tag))
        if row is None:
            row = session.merge(BatchRow(key=key, tag=tag, latest=0.0))
        row.latest = clock()
        session.flush()


def forget_tags(session: Session, tags: Collection[str]) -> None:
    """Forget those of some tags that no job has any more."""
    unused = ~exists().where(JobTagRow.tag == BatchRow.tag)
    session.execute(delete(BatchRow).where(BatchRow.tag.in_(list(tags)), unused))


@skip_damaged_rows
def list_batches(database: Database, limit: int = 50, before: str = "", owner: str | None = None) -> list[Batch]:
    """Return the batches whose jobs were ordered last.

    Args:
        database: The jobs' database.
        limit: Largest number.
        before: Only those after this tag in the list; empty: from the newest on.
        owner: Only tags and jobs of this API key; None: of all.
    """
    latest: ColumnElement[float] = func.max(BatchRow.latest)
    statement = select(BatchRow.tag, latest).group_by(BatchRow.tag).order_by(latest.desc(), BatchRow.tag.desc())
    if owner is not None:
        statement = select(BatchRow.tag, BatchRow.latest).where(BatchRow.key == owner)
        statement = statement.order_by(BatchRow.latest.desc(), BatchRow.tag.desc())
        latest = BatchRow.latest.expression
    with database.read() as session:
        if before:
            known = select(func.max(BatchRow.latest)).where(BatchRow.tag == before)
            last = session.scalar(known if owner is None else known.where(BatchRow.key == owner))
            if last is not None:
                is_older = (latest < last) | ((latest == last) & (BatchRow.tag < before))
                statement = statement.having(is_older) if owner is None else statement.where(is_older)
        times = {row[0]: row[1] for row in session.execute(statement.limit(limit))}
        return [one for one in _describe(session, times, owner) if one.jobs]


@skip_damaged_rows
def find_batch(database: Database, tag: str, owner: str | None = None) -> BatchReport:
    """Return a batch with its failures; with an owner only the jobs of this API key.

    Raises:
        BatchUnknown: if no job has the tag.
    """
    with database.read() as session:
        known = select(func.max(BatchRow.latest)).where(BatchRow.tag == tag)
        latest = session.scalar(known if owner is None else known.where(BatchRow.key == owner))
        (found,) = _describe(session, {tag: latest or 0.0}, owner)
        if not found.jobs:
            raise BatchUnknown(f"no job has the tag '{tag[:64]}'; the list of batches has every tag in use.")
        failures = _list_failures(session, tag, owner) if set(FAILED_STATES) & found.states.keys() else ()
        return BatchReport(**{one.name: getattr(found, one.name) for one in fields(Batch)}, failures=failures)


def _describe(session: Session, times: dict[str, float], owner: str | None) -> list[Batch]:
    """Return the batches of some tags."""
    is_root = func.sum(case((JobRow.parent.is_(None), 1), else_=0))
    groups = (JobTagRow.tag, JobRow.state, JobRow.kind, JobRow.verdict, JobRow.garment)
    counted = (
        select(*groups, func.count(), is_root, func.sum(func.coalesce(JobRow.cpu_seconds, 0.0)))
        .join(JobRow, JobRow.id == JobTagRow.job)
        .where(JobTagRow.tag.in_(list(times)), *_is_own(owner))
        .group_by(*groups)
    )
    rows: dict[str, list[Any]] = {tag: [] for tag in times}
    for row in session.execute(counted):
        rows[row[0]].append(row[1:])
    running = _find_running(session, list(times))
    lives = (WorkerRow.seen > clock() - FORGET_SECONDS) & (WorkerRow.seen < clock() + AHEAD_SECONDS)
    capacity = session.scalar(select(func.coalesce(func.sum(WorkerRow.concurrency), 0)).where(lives)) or 0
    families = _count_families(session, list(times), owner)
    return [
        replace(_sum_up(session, tag, at, rows[tag], running.get(tag, []), int(capacity)), families=families[tag])
        for tag, at in times.items()
    ]


def _count_families(session: Session, tags: Sequence[str], owner: str | None) -> dict[str, FamilyCount]:
    """Return for each tag how far the families of its jobs are."""
    is_open, is_unsuccessful = (
        func.max(case((JobRow.state.in_(states), 1), else_=0)) for states in (OPEN, UNSUCCESSFUL)
    )
    families = (
        select(JobTagRow.tag, is_open.label("is_open"), is_unsuccessful.label("is_unsuccessful"))
        .join(JobRow, JobRow.id == JobTagRow.job)
        .where(JobTagRow.tag.in_(tags), *_is_own(owner))
        .group_by(JobTagRow.tag, JobRow.family)
        .subquery()
    )
    groups = (families.c.tag, families.c.is_open, families.c.is_unsuccessful)
    counts: dict[str, dict[str, int]] = {tag: {} for tag in tags}
    for tag, has_open, has_failed, number in session.execute(select(*groups, func.count()).group_by(*groups)):
        name = "open" if has_open else "failed" if has_failed else "succeeded"
        counts[tag][name] = counts[tag].get(name, 0) + number
    return {tag: FamilyCount(**found) for tag, found in counts.items()}


def _is_own(owner: str | None) -> tuple[ColumnElement[bool], ...]:
    return () if owner is None else (exists().where(OwnerRow.job == JobTagRow.job, OwnerRow.key == owner),)


def _find_running(session: Session, tags: Sequence[str]) -> dict[str, list[tuple[str, float, float | None]]]:
    """Return kind, progress and remaining time [s] of the running jobs by tag; there are as many as workers can run."""
    left = JobRow.expected_end - clock()
    known = select(JobRow.id, JobRow.kind, JobRow.overall, left).where(JobRow.state == State.RUNNING)
    jobs = {job: (kind, overall, rest) for job, kind, overall, rest in session.execute(known)}
    found: dict[str, list[tuple[str, float, float | None]]] = {}
    statement = select(JobTagRow.tag, JobTagRow.job).where(JobTagRow.job.in_(list(jobs)), JobTagRow.tag.in_(tags))
    for tag, job in session.execute(statement):
        found.setdefault(tag, []).append(jobs[job])
    return found


def _sum_up(
    session: Session, tag: str, latest: float, rows: Sequence[Any], running: Sequence[Any], capacity: int
) -> Batch:
    """Return a batch from the counts of its jobs by state, kind, verdict and garment."""
    states, verdicts, garments = dict[State, int](), dict[str, int](), dict[str, int]()
    jobs, scans, cpu_seconds = 0, 0, 0.0
    for state, kind, verdict, garment, count, roots, seconds in rows:
        states[state] = states.get(state, 0) + count
        jobs, scans, cpu_seconds = jobs + count, scans + roots, cpu_seconds + seconds
        if verdict is not None:
            verdicts[verdict] = verdicts.get(verdict, 0) + count
        if garment is not None and kind == RECOVER and state == State.SUCCEEDED:
            garments[garment] = garments.get(garment, 0) + count
    ended = jobs - sum(states.get(state, 0) for state in OPEN)
    share = (ended + sum(overall for _, overall, _ in running)) / jobs if jobs else 0.0
    left = _estimate(session, rows, running, capacity) if ended < jobs and capacity else None
    left = 0.0 if ended == jobs else left
    found_states = dict(sorted(states.items()))
    found_verdicts, found_garments = (dict(sorted(one.items())) for one in (verdicts, garments))
    return Batch(
        tag, latest, jobs, scans, found_states, min(1.0, round(share, 4)), left, found_verdicts, found_garments,
        round(cpu_seconds, 1),
    )  # fmt: skip


def _estimate(session: Session, rows: Sequence[Any], running: Sequence[Any], capacity: int) -> float | None:
    """Return the time until all open jobs of a batch have ended [s], by the latest jobs of their kinds; None: unknown.

    A person that has not ended is expected to wear as many garments as those of the batch that have.
    """
    waiting, found = dict[str, float](), {"persons": 0, "garments": 0}
    for state, kind, _, _, count, roots, _ in rows:
        if state in OPEN:
            waiting[kind] = waiting.get(kind, 0.0) + count
        if kind == PERSON and state == State.SUCCEEDED:
            found["persons"] += count
        if kind == RECOVER:
            found["garments"] += count - roots
    if waiting.get(PERSON) and found["persons"]:
        expected = waiting[PERSON] * found["garments"] / found["persons"]
        waiting[RECOVER] = waiting.get(RECOVER, 0.0) + expected
    total, longest = 0.0, 0.0
    for kind, count in waiting.items():
        mean = find_mean_seconds(session, kind)
        if mean is None:
            return None
        lefts = [max(0.0, left) for own_kind, _, left in running if own_kind == kind and left is not None]
        total += (count - len(lefts)) * mean + sum(lefts)
        longest = max(longest, *lefts, 0.0)
    return max(total / capacity, longest)


def _list_failures(session: Session, tag: str, owner: str | None) -> tuple[BatchFailure, ...]:
    statement = (
        select(JobRow)
        .join(JobTagRow, JobTagRow.job == JobRow.id)
        .where(JobTagRow.tag == tag, JobRow.state.in_(FAILED_STATES), *_is_own(owner))
        .order_by(JobRow.finished.desc(), JobRow.id)
        .limit(MAX_BATCH_FAILURES)
    )
    return tuple(
        BatchFailure(
            row.id, row.family or row.id, row.name, row.kind, row.state,
            Failure(row.error_code, row.error_message or "") if row.error_code else None,
        )
        for row in session.scalars(statement)
    )  # fmt: skip
