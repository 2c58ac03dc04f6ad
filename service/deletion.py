"""Delete jobs and uploads with all that was made of them: rows, uploads, and the files that no other row names."""

from __future__ import annotations

import logging
from collections.abc import Collection, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from time import time

from sqlalchemy import delete, exists, or_, select

from ..core.run.errors import BadInput
from .columns import RowDamaged
from .database import Database, clock
from .families import JobInUse, JobNotEnded, find_below
from .families import delete as delete_families
from .garbage import find_named
from .models import (
    ArtifactRow,
    IdempotencyRow,
    JobFileRow,
    JobInputRow,
    JobRow,
    JobTagRow,
    OwnerRow,
    ScanRow,
    UploadRow,
)
from .records import JsonRecord
from .states import ENDED
from .store import ArtifactMissing, Store

log = logging.getLogger(__name__)

YOUNG_SECONDS = 60.0
"""Age below which a file may be about to be named by another order [s]; `gc` deletes it a day later."""


FAMILIES_AT_ONCE = 50
"""Number of families that one transaction deletes: a worker waits no longer than a tenth of a second for it."""


class JobShared(BadInput):
    """Another key has the same job, so it stays; ask the operator to delete it."""

    code = "job.shared"


@dataclass(frozen=True)
class Deleted(JsonRecord):
    """Describe what was deleted.

    Attributes:
        jobs: Ids of the jobs.
        uploads: Uploads that can no longer be used.
        files: Deleted stored files.
        size: Their size [bytes].
        young: Files that `gc` deletes later, because they are new, or a damaged row may name them.
    """

    jobs: tuple[str, ...] = ()
    uploads: int = 0
    files: int = 0
    size: int = 0
    young: int = 0


def find_old_families(database: Database, seconds: float) -> list[str]:
    """Return the roots of the families that ended longer ago than some seconds, oldest first."""
    member = JobRow.__table__.alias()
    fresh = or_(member.c.state.not_in(ENDED), member.c.finished > clock() - seconds)
    is_old = ~exists().where(member.c.family == JobRow.family, fresh)
    with database.read() as session:
        old = select(JobRow.id).where(JobRow.parent.is_(None), is_old).order_by(JobRow.created, JobRow.id)
        return list(session.scalars(old))


def find_tagged_families(database: Database, tag: str) -> list[str]:
    """Return the roots of the families with a tag, oldest first."""
    with database.read() as session:
        tagged = select(JobRow.id).join(JobTagRow, JobTagRow.job == JobRow.id)
        tagged = tagged.where(JobTagRow.tag == tag, JobRow.parent.is_(None))
        return list(session.scalars(tagged.order_by(JobRow.created, JobRow.id)))


def find_dependent_jobs(database: Database, jobs: Sequence[str]) -> list[str]:
    """Return some jobs with all that is deleted with them: all that read their results, and all below each."""
    roots = _add_readers(database, jobs)
    return [*roots, *(row.id for row in find_below(database, roots))]


def delete_jobs(database: Database, store: Store, jobs: Sequence[str], key: str = "") -> Deleted:
    """Delete ended jobs, all jobs below them, all that read their results, then the files that no row names any more.

    Args:
        database: The jobs' database.
        store: The store of their files.
        jobs: Ids of the jobs.
        key: The caller's API key; empty: the operator.

    Raises:
        JobNotEnded: if one of them, or a job made from it, has not ended; then nothing is deleted.
        JobShared: if another key owns one of them too.
    """
    started = time()
    left = _add_readers(database, jobs)
    files = _find_files(database, left)
    _check_owners(database, left, key)
    _check_ended(database, left)
    deleted: list[str] = []
    try:
        _delete_all(database, left, deleted)
    finally:  # a job may have been requeued meanwhile: clean up after the deleted ones
        _forget_scans(database, files)
        done = remove_files(database, store, files, Deleted(tuple(deleted)), started)
    return done


def _delete_all(database: Database, left: list[str], deleted: list[str]) -> None:
    """Delete families, readers of results first; append the ids of deleted jobs to `deleted`."""
    for start in range(0, len(left), FAMILIES_AT_ONCE):
        chosen = [job for job in left[start : start + FAMILIES_AT_ONCE] if job not in deleted]
        with suppress(JobInUse):  # by one of the others, or by another job: then one by one
            deleted += delete_families(database, chosen)
    left = [job for job in left if job not in deleted]
    while left:
        waiting: list[str] = []
        for job in left:
            try:
                deleted += delete_families(database, [job])
            except JobInUse:
                waiting.append(job)
        if len(waiting) == len(left):
            raise JobInUse(f"job {left[0]} is used by another one; delete that one first.")
        left = [job for job in waiting if job not in deleted]


def delete_upload(database: Database, store: Store, sha256: str, key: str = "") -> Deleted:
    """Delete a key's upload of a file, and the file if no job names it."""
    started = time()
    count = forget_uploads(database, {sha256}, key)
    return remove_files(database, store, {sha256}, Deleted(uploads=count), started)


def _add_readers(database: Database, jobs: Sequence[str]) -> list[str]:
    """Return the roots of all jobs that read results of some jobs or of those below them, then the jobs themselves."""
    found, level = list(dict.fromkeys(jobs)), list(jobs)
    while level:
        below = [*level, *(row.id for row in find_below(database, level))]
        with database.read() as session:
            readers = select(JobRow.family).join(JobInputRow, JobInputRow.job == JobRow.id)
            families = session.scalars(readers.where(JobInputRow.input.in_(below)).distinct()).all()
            own_families = set(session.scalars(select(JobRow.family).where(JobRow.id.in_(below))))
        level = [job for job in sorted(families) if job not in found and job not in own_families]
        found = level + found
    return found


def _find_files(database: Database, jobs: Sequence[str]) -> set[str]:
    ids = [*jobs, *(row.id for row in find_below(database, jobs))]
    with database.read() as session:
        files = set(session.scalars(select(ArtifactRow.sha256).where(ArtifactRow.job.in_(ids))))
        files |= set(session.scalars(select(JobFileRow.sha256).where(JobFileRow.job.in_(ids))))
        files |= set(session.scalars(select(JobRow.scan).where(JobRow.id.in_(ids))))
    return files


def _check_owners(database: Database, jobs: Sequence[str], key: str) -> None:
    if not key:
        return
    with database.read() as session:
        others = select(OwnerRow.job).where(OwnerRow.job.in_(jobs), OwnerRow.key != key).limit(1)
        shared = session.scalar(others)
    if shared is not None:
        raise JobShared(f"another key has job {shared} too, so it stays; ask the operator to delete it.")


def _check_ended(database: Database, jobs: Sequence[str]) -> None:
    """Refuse, before anything is deleted, if a job or one below it has not ended."""
    ids = [*jobs, *(row.id for row in find_below(database, jobs))]
    with database.read() as session:
        open_job = session.scalar(select(JobRow.id).where(JobRow.id.in_(ids), JobRow.state.not_in(ENDED)).limit(1))
    if open_job is not None:
        raise JobNotEnded(f"job {open_job} has not ended, so nothing was deleted; cancel it first, or wait.")


def _forget_scans(database: Database, files: Iterable[str]) -> None:
    with database.write() as session:
        unused = ~exists().where(JobRow.scan == ScanRow.sha256)
        session.execute(delete(ScanRow).where(ScanRow.sha256.in_(list(files)), unused))


def forget_uploads(database: Database, files: Collection[str], key: str) -> int:
    """Delete the rows of a key's (empty: any key's) uploads of some files; return how many."""
    with database.write() as session:
        matches = UploadRow.sha256.in_(files)
        rows = session.scalars(select(UploadRow).where(matches & (UploadRow.key == key) if key else matches)).all()
        for row in rows:
            session.delete(row)
        if key:
            session.execute(delete(IdempotencyRow).where(IdempotencyRow.key == key, IdempotencyRow.job.is_(None)))
        return len(rows)


def remove_files(database: Database, store: Store, files: set[str], done: Deleted, started: float) -> Deleted:
    """Delete those of some files that no row names; none where one of the rows that name them is damaged."""
    count = size = young = 0
    try:
        with database.read() as session:
            named = find_named(session, files)
    except RowDamaged as error:
        log.warning("no file is deleted: %s", error)
        return Deleted(done.jobs, done.uploads, young=len(files))
    for key in sorted(files - named):
        try:
            bytes_ = store.size(key)
            if store.remove(key, started - YOUNG_SECONDS):
                count, size = count + 1, size + bytes_
            else:
                young += 1
        except ArtifactMissing:
            continue
    return Deleted(done.jobs, done.uploads, count, size, young)
