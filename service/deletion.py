"""Delete jobs and persons with all that was made of them: rows, uploads, and the files that nobody else names."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from time import time

from sqlalchemy import delete, exists, or_, select

from ..core.errors import BadInput, NotFound
from .database import Database, clock
from .families import JobInUse, JobNotEnded, find_below
from .families import delete as delete_family
from .garbage import find_hashes, find_references
from .models import ArtifactRow, IdempotencyRow, JobInputRow, JobRow, OwnerRow, ScanRow, UploadRow
from .states import ENDED
from .store import ArtifactMissing, Store

YOUNG_SECONDS = 60.0
"""A file put so lately may be about to be named by another order [s]; `gc` removes it a day later."""


class PersonUnknown(NotFound):
    """No job, scan or upload has this name; `garmentq status` lists the jobs."""

    code = "person.unknown"


class JobShared(BadInput):
    """Another key has the same job, so it stays; ask the operator to delete it."""

    code = "job.shared"


@dataclass(frozen=True)
class Deleted:
    """Describe what is gone.

    Attributes:
        jobs: Ids of the jobs.
        uploads: Uploads that may not be used any more.
        files: Stored files that are gone.
        size: Their bytes.
        young: Files that `gc` removes later, since they were put a moment ago.
    """

    jobs: tuple[str, ...] = ()
    uploads: int = 0
    files: int = 0
    size: int = 0
    young: int = 0


def find_old(database: Database, seconds: float) -> list[str]:
    """Return the roots of the families that ended longer ago than some seconds, the oldest first."""
    member = JobRow.__table__.alias()
    fresh = or_(member.c.state.not_in(ENDED), member.c.finished > clock() - seconds)
    is_old = ~exists().where(member.c.family == JobRow.family, fresh)
    with database.read() as session:
        old = select(JobRow.id).where(JobRow.parent.is_(None), is_old).order_by(JobRow.created, JobRow.id)
        return list(session.scalars(old))


def find_person(database: Database, name: str, key: str = "") -> tuple[list[str], list[str]]:
    """Find everything of a person: by the name of a job, a scan or an upload, then by the files themselves.

    Args:
        database: Where to look.
        name: What the person's jobs, scan or upload are called.
        key: Only what this API key may see; empty: everything.

    Returns:
        Ids of all root jobs that go back to one of the person's files, and the hashes of those files.

    Raises:
        PersonUnknown: where there is nothing of that name.
    """
    with database.read() as session:
        named = select(JobRow.scan).where(JobRow.name == name, JobRow.parent.is_(None))
        uploads = select(UploadRow.sha256).where(or_(UploadRow.name == name, UploadRow.name.startswith(f"{name}.")))
        if key:
            named = named.join(OwnerRow, OwnerRow.job == JobRow.id).where(OwnerRow.key == key)
            uploads = uploads.where(UploadRow.key == key)
        files = {*session.scalars(named), *session.scalars(uploads)}
        if not files:
            raise PersonUnknown(f"nothing is called '{name[:80]}'; `garmentq status` lists the jobs.")
        asked = select(JobRow.id, JobRow.scan, JobRow.request).where(JobRow.parent.is_(None))
        if key:
            asked = asked.join(OwnerRow, OwnerRow.job == JobRow.id).where(OwnerRow.key == key)
        rows = session.execute(asked.order_by(JobRow.created, JobRow.id)).all()
    jobs = [job for job, scan, request in rows if scan in files or not files.isdisjoint(find_hashes(request))]
    return jobs, sorted(files)


def delete_jobs(database: Database, store: Store, jobs: Sequence[str], key: str = "") -> Deleted:
    """Delete ended jobs with all below them and all that reads their results, then the files that nobody names.

    Args:
        database: Where the jobs are.
        store: Where their files are.
        jobs: Ids of the jobs.
        key: The API key that asks; empty: the operator.

    Raises:
        JobNotEnded: where one of them, or what was made of it, has not ended; then nothing is deleted.
        JobShared: where another key owns one of them too.
    """
    begun = time()
    left = _add_readers(database, jobs)
    files = _find_files(database, left)
    _check_owners(database, left, key)
    _check_ended(database, left)
    gone: list[str] = []
    try:
        _delete_all(database, left, gone)
    finally:  # one may have been queued again meanwhile: what is gone leaves nothing behind
        _forget_scans(database, files)
        done = _remove_files(database, store, files, Deleted(tuple(gone)), begun)
    return done


def _delete_all(database: Database, left: list[str], gone: list[str]) -> None:
    """Delete families, readers of results before those; the ids of what is deleted are added to `gone`."""
    while left:
        waiting: list[str] = []
        for job in left:
            try:
                gone += delete_family(database, job)
            except JobInUse:
                waiting.append(job)
        if len(waiting) == len(left):
            raise JobInUse(f"job {left[0]} is used by another one; delete that one first.")
        left = [job for job in waiting if job not in gone]


def delete_person(database: Database, store: Store, name: str, key: str = "") -> Deleted:
    """Delete a person's scans, uploads, jobs and all that was made of them.

    Raises:
        PersonUnknown: where there is nothing of that name.
        JobNotEnded, JobShared: with the job that forbids it.
    """
    jobs, scans = find_person(database, name, key)
    begun = time()
    done = delete_jobs(database, store, jobs, key)
    uploads = sum(_forget_upload(database, one, key) for one in scans)
    rest = _remove_files(database, store, set(scans), Deleted(done.jobs, uploads), begun)
    return Deleted(done.jobs, uploads, done.files + rest.files, done.size + rest.size, done.young + rest.young)


def delete_upload(database: Database, store: Store, sha256: str, key: str = "") -> Deleted:
    """Forget that a key uploaded a file, and remove the file where no job names it."""
    begun = time()
    count = _forget_upload(database, sha256, key)
    return _remove_files(database, store, {sha256}, Deleted(uploads=count), begun)


def _add_readers(database: Database, jobs: Sequence[str]) -> list[str]:
    """Return jobs and the roots of all that read a result of theirs or of one below them, the readers first."""
    found, level = list(dict.fromkeys(jobs)), list(jobs)
    while level:
        below = [*level, *(row.id for row in find_below(database, level))]
        with database.read() as session:
            readers = select(JobRow.family).join(JobInputRow, JobInputRow.job == JobRow.id)
            families = session.scalars(readers.where(JobInputRow.input.in_(below)).distinct()).all()
            own = set(session.scalars(select(JobRow.family).where(JobRow.id.in_(below))))
        level = [job for job in sorted(families) if job not in found and job not in own]
        found = level + found
    return found


def _find_files(database: Database, jobs: Sequence[str]) -> set[str]:
    ids = [*jobs, *(row.id for row in find_below(database, jobs))]
    with database.read() as session:
        files = set(session.scalars(select(ArtifactRow.sha256).where(ArtifactRow.job.in_(ids))))
        for scan, request in session.execute(select(JobRow.scan, JobRow.request).where(JobRow.id.in_(ids))):
            files |= {scan, *find_hashes(request)}
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
    """Refuse before anything is deleted where one of some jobs or of those below them has not ended."""
    ids = [*jobs, *(row.id for row in find_below(database, jobs))]
    with database.read() as session:
        open_job = session.scalar(select(JobRow.id).where(JobRow.id.in_(ids), JobRow.state.not_in(ENDED)).limit(1))
    if open_job is not None:
        raise JobNotEnded(f"job {open_job} has not ended, so nothing was deleted; cancel it first, or wait.")


def _forget_scans(database: Database, files: Iterable[str]) -> None:
    with database.write() as session:
        unused = ~exists().where(JobRow.scan == ScanRow.sha256)
        session.execute(delete(ScanRow).where(ScanRow.sha256.in_(list(files)), unused))


def _forget_upload(database: Database, sha256: str, key: str) -> int:
    with database.write() as session:
        wanted = UploadRow.sha256 == sha256
        rows = session.scalars(select(UploadRow).where(wanted & (UploadRow.key == key) if key else wanted)).all()
        for row in rows:
            session.delete(row)
        if key:
            session.execute(delete(IdempotencyRow).where(IdempotencyRow.key == key, IdempotencyRow.job.is_(None)))
        return len(rows)


def _remove_files(database: Database, store: Store, files: set[str], done: Deleted, begun: float) -> Deleted:
    """Remove those of some files that no row names any more."""
    with database.read() as session:
        named = set(find_references(session))
    count = size = young = 0
    for key in sorted(files - named):
        try:
            bytes_ = store.size(key)
            if store.remove(key, begun - YOUNG_SECONDS):
                count, size = count + 1, size + bytes_
            else:
                young += 1
        except ArtifactMissing:
            continue
    return Deleted(done.jobs, done.uploads, count, size, young)
