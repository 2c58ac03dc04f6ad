"""Find and delete a person's data: a subject's, or jobs and uploads of a name, and all made of the same files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from time import time
from typing import Any, ClassVar

from sqlalchemy import Select, delete, or_, select
from sqlalchemy.orm import Session

from ..core.run.errors import NotFound
from .database import Database, starts_with
from .deletion import Deleted, delete_jobs, find_dependent_jobs, forget_uploads, remove_files
from .jobs import IDS_AT_ONCE, find_jobs_by_id
from .models import JobFileRow, JobRow, OwnerRow, ScanRow, SubjectJobRow, SubjectRow, UploadRow
from .query import FORBIDDEN_CHARACTERS
from .records import CLOSED, JsonRecord
from .store import Store
from .subjects import find_row

OWN_KINDS = frozenset({"scans", "bodies", "labels", "motions"})
"""Kinds of uploads that show a person; a pattern is made for one, and may serve others."""


class PersonUnknown(NotFound):
    """No job, scan or upload has exactly this name; `garmentq status` lists the jobs."""

    code = "person.unknown"


@dataclass(frozen=True)
class PersonJob(JsonRecord):
    """Describe a job of a person, and the API keys that see it; without keys it is the operator's own."""

    __pydantic_config__: ClassVar = CLOSED
    job: str
    name: str
    kind: str
    keys: tuple[str, ...] = ()


@dataclass(frozen=True)
class PersonUpload(JsonRecord):
    """Describe an uploaded file of a person: its hash, the name that it was given, and the API key or empty."""

    __pydantic_config__: ClassVar = CLOSED
    sha256: str
    name: str
    key: str = ""


@dataclass(frozen=True)
class Person(JsonRecord):
    """Describe the stored data of a person.

    Attributes:
        name: The requested name.
        names: Names of jobs, scans and uploads that were found by it or by the files, sorted.
        keys: Ids of all API keys that see one of the jobs or uploads, sorted; empty text: no key.
        jobs: The person's jobs: those of its files, all below them, and all that read their results.
        uploads: Uploads of its files.
        files: Hashes of the person's files.
        subjects: Ids of the subjects of this name.
    """

    __pydantic_config__: ClassVar = CLOSED
    name: str
    names: tuple[str, ...] = ()
    keys: tuple[str, ...] = ()
    jobs: tuple[PersonJob, ...] = ()
    uploads: tuple[PersonUpload, ...] = ()
    files: tuple[str, ...] = ()
    subjects: tuple[str, ...] = ()


@dataclass(frozen=True)
class PersonDeleted(Deleted):
    """Describe what was deleted of a person, and what was found before; a dry run deletes nothing."""

    found: Person = field(default_factory=lambda: Person(""))
    dry_run: bool = False


def find_person(database: Database, name: str, key: str = "") -> Person:
    """Find all data of a person: by the name of a subject, a job, a scan or an upload, then by the files themselves.

    Names are compared exactly. A job's name must equal `name`; a file's name must equal `name`, or `name` and one
    extension after the last dot: `anna` finds `anna.ply`, neither `Anna.ply` nor `anna.smith.ply`.

    Args:
        database: The database that is searched.
        name: Name of the subject, or of the person's jobs, scan or upload.
        key: Only what this API key may see; empty: everything, of all keys.

    Raises:
        PersonUnknown: if there is nothing of that name.
    """
    return _find_by_name(database, name, key)[0]


def find_subject_data(database: Database, subject: str, key: str | None = None) -> Person:
    """Find all data of a subject, by its id or exact name: its jobs and scans, and all that was made of the scans.

    Raises:
        SubjectUnknown: if there is none; with a key if it is not the key's own.
    """
    return _find_by_subject(database, subject, key)[0]


def delete_person(
    database: Database, store: Store, name: str, key: str = "", is_dry_run: bool = False
) -> PersonDeleted:
    """Delete a person's scans, uploads, jobs and all that was made of them, and return what was found.

    Raises:
        PersonUnknown: if there is nothing of that name.
        JobNotEnded, JobShared: with the job that prevents it.
    """
    return _delete(database, store, _find_by_name(database, name, key), key, is_dry_run)


def delete_subject(
    database: Database, store: Store, subject: str, key: str | None = None, is_dry_run: bool = False
) -> PersonDeleted:
    """Delete a subject with its scans, bodies and labels, uploads, jobs and all that was made of them.

    Args:
        database: The subject's database.
        store: The store of the files.
        subject: Its id or its exact name.
        key: Only a subject of this API key; None: of any, and what other keys have of the same files too.
        is_dry_run: Return what was found, and delete nothing.

    Raises:
        SubjectUnknown: if there is none.
        JobNotEnded, JobShared: with the job that prevents it.
    """
    return _delete(database, store, _find_by_subject(database, subject, key), key or "", is_dry_run)


def _delete(
    database: Database, store: Store, data: tuple[Person, list[str]], key: str, is_dry_run: bool
) -> PersonDeleted:
    found, roots = data
    if is_dry_run:
        return PersonDeleted(found=found, dry_run=True)
    started = time()
    own_files = _find_own_files(database, [one.job for one in found.jobs])
    done = delete_jobs(database, store, roots, key)
    going = {*found.files, *_find_unused(database, own_files)}
    uploads = forget_uploads(database, going, key)
    rest = remove_files(database, store, going, Deleted(done.jobs, uploads), started)
    with database.write() as session:
        session.execute(delete(SubjectRow).where(SubjectRow.id.in_(found.subjects)))
    files, size, young = done.files + rest.files, done.size + rest.size, done.young + rest.young
    return PersonDeleted(done.jobs, uploads, files, size, young, found)


def _find_own_files(database: Database, jobs: Sequence[str]) -> set[str]:
    """Return the bodies and label files that the requests of some jobs name; patterns are the studio's."""
    found = set[str]()
    with database.read() as session:
        for start in range(0, len(jobs), IDS_AT_ONCE):
            chunk = jobs[start : start + IDS_AT_ONCE]
            named = select(UploadRow).join(JobFileRow, JobFileRow.sha256 == UploadRow.sha256)
            rows = session.scalars(named.where(JobFileRow.job.in_(chunk)))
            found.update(row.sha256 for row in rows if OWN_KINDS.intersection(row.kinds))
    return found


def _find_unused(database: Database, files: set[str]) -> set[str]:
    """Return those of some files that no job names."""
    with database.read() as session:
        named = set(session.scalars(select(JobFileRow.sha256).where(JobFileRow.sha256.in_(files)).distinct()))
    return files - named


def _find_by_name(database: Database, name: str, key: str) -> tuple[Person, list[str]]:
    """Return the data of a name, and the root jobs that use one of its files or are of its subject."""
    with database.read() as session:
        files, subjects = set[str](), list[str]()
        if not FORBIDDEN_CHARACTERS.search(name):
            files = _find_files(session, name, key)
            people = select(SubjectRow.id).where(SubjectRow.name == name)
            subjects = list(session.scalars(people.where(SubjectRow.key == key) if key else people))
        if not files and not subjects:
            raise PersonUnknown(f"nothing has exactly the name '{name[:80]}'; `garmentq status` lists the jobs.")
        files |= _find_scans(session, subjects)
    return _collect(database, name, files, subjects, key)


def _find_by_subject(database: Database, subject: str, key: str | None) -> tuple[Person, list[str]]:
    """Return a subject's data, and the root jobs that use one of its scans or are its own."""
    with database.read() as session:
        row = find_row(session, subject, key)
        files = _find_scans(session, [row.id])
    return _collect(database, row.name, files, [row.id], key or "")


def _find_scans(session: Session, subjects: Sequence[str]) -> set[str]:
    scans = select(JobRow.scan).join(SubjectJobRow, SubjectJobRow.job == JobRow.id)
    return set(session.scalars(scans.where(SubjectJobRow.subject.in_(subjects))))


def _collect(
    database: Database, name: str, files: set[str], subjects: Sequence[str], key: str
) -> tuple[Person, list[str]]:
    """Return all data of some files and subjects, and the root jobs that use one of the files or are a subject's."""
    with database.read() as session:
        uses = or_(
            JobRow.scan.in_(files),
            JobRow.id.in_(select(JobFileRow.job).where(JobFileRow.sha256.in_(files))),
            JobRow.id.in_(select(SubjectJobRow.job).where(SubjectJobRow.subject.in_(subjects))),
        )
        statement = _of_key(select(JobRow.id).where(JobRow.parent.is_(None), uses), key)
        roots = list(session.scalars(statement.order_by(JobRow.created, JobRow.id)))
    dependent = find_dependent_jobs(database, roots)
    jobs = describe_jobs(database, dependent, key)
    with database.read() as session:
        statement_of_uploads = (
            select(UploadRow).where(UploadRow.sha256.in_(files)).order_by(UploadRow.created, UploadRow.sha256)
        )
        rows_of_uploads = session.scalars(
            statement_of_uploads.where(UploadRow.key == key) if key else statement_of_uploads
        ).all()
        scans = [] if key else session.scalars(select(ScanRow.name).where(ScanRow.sha256.in_(files))).all()
    uploads = tuple(PersonUpload(row.sha256, row.name, row.key) for row in rows_of_uploads)
    names = {*(one.name for one in jobs), *(one.name for one in uploads), *scans} or {name}
    keys = {one.key for one in uploads}.union(*(one.keys or ("",) for one in jobs))
    shown = (tuple(sorted(names)), tuple(sorted(keys)), jobs, uploads, tuple(sorted(files)), tuple(sorted(subjects)))
    return Person(name, *shown), roots


def _find_files(session: Session, name: str, key: str) -> set[str]:
    """Return the hashes of the files of a name."""
    named = _of_key(select(JobRow.scan).where(JobRow.name == name, JobRow.parent.is_(None)), key)
    files = set(session.scalars(named))
    for table in (UploadRow,) if key else (UploadRow, ScanRow):  # a scan's row has the name that the first key gave it
        statement = select(table.sha256, table.name).where(or_(table.name == name, starts_with(table.name, f"{name}.")))
        found = session.execute(statement.where(UploadRow.key == key) if key else statement)
        files.update(sha256 for sha256, stored_name in found if name in (stored_name, stored_name.rpartition(".")[0]))
    return files


def _of_key(statement: Select[Any], key: str) -> Select[Any]:
    """Restrict a query for jobs to those that an API key may see; empty: all."""
    return statement.join(OwnerRow, OwnerRow.job == JobRow.id).where(OwnerRow.key == key) if key else statement


def describe_jobs(database: Database, jobs: Sequence[str], key: str = "") -> tuple[PersonJob, ...]:
    """Describe those of some jobs that an API key may see; empty: all, with the keys that see them."""
    keys = dict[str, list[str]]()
    with database.read() as session:
        for start in range(0, len(jobs), IDS_AT_ONCE):
            owners = select(OwnerRow.job, OwnerRow.key).where(OwnerRow.job.in_(jobs[start : start + IDS_AT_ONCE]))
            for job, owner in session.execute(owners.where(OwnerRow.key == key) if key else owners):
                keys.setdefault(job, []).append(owner)
    rows = find_jobs_by_id(database, [job for job in jobs if not key or job in keys])
    return tuple(PersonJob(row.id, row.name, row.kind, tuple(sorted(keys.get(row.id, ())))) for row in rows)
