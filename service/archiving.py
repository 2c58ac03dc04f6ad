"""Archive some families: a backup that holds only them, from which a home of their own is restored."""

from __future__ import annotations

import sqlite3
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path

from sqlalchemy import Column, Connection, Table, column, delete, insert, or_, select, table, text

from ..core.run.errors import BadInput
from .backup import BackupContents, make_backup, read_backup
from .database import Database, upgrade
from .deletion import find_dependent_jobs
from .model_base import Base
from .models import (
    FabricRow,
    JobInputRow,
    JobRow,
    JobTagRow,
    MaterialRow,
    PatternRow,
    ScanRow,
    TemplateRow,
)
from .services import Services
from .settings import ServiceSettings
from .states import ENDED
from .subject_models import BatchRow, SubjectJobRow, SubjectRow

LEFT_OUT = (
    "api_keys", "audit", "deliveries", "event_counts", "idempotency", "locks", "outages", "outbox", "owners", "payers",
    "sessions", "shares", "uploads", "webhooks", "workers",
)  # fmt: skip
"""Tables of the service and its users, of which an archive has no row."""

KEPT = table("kept_jobs", column("id"))
"""Temporary table of the jobs that stay."""


class ArchiveRefused(BadInput):
    """These jobs cannot be archived; the message says why and what to do."""

    code = "archive.refused"


def archive_jobs(
    services: Services, settings: ServiceSettings, jobs: Sequence[str], destination: Path, is_overwrite: bool = False
) -> tuple[str, ...]:
    """Write families, all that read their results, and all that they read, into one tar file, and read it back.

    The file is a backup without any other job, user, key or log entry: `restore_backup` makes a home of it.

    Args:
        services: The open home.
        settings: Its settings.
        jobs: Roots of the families.
        destination: The tar file.
        is_overwrite: Replace the file if it exists.

    Returns:
        The ids of the jobs in it.

    Raises:
        ArchiveRefused: if a job has not ended, or a file of one is missing or damaged; then there is no tar file.
        BackupRefused: if the tar file exists.
        BackupDamaged: if what is read back is not what was written.
    """
    kept = _find_all(services.database, jobs)
    made = make_backup(settings, destination, is_overwrite, keep=lambda copied: _keep_only(copied, kept))
    if made.missing or made.damaged or made.rows:
        destination.unlink()
        lost = len(made.missing) + len(made.damaged) + len(made.rows)
        raise ArchiveRefused(f"{lost} files or rows are missing or damaged; `garmentq verify` names their jobs.")
    _check(read_backup(destination), made)
    return kept


def _check(found: BackupContents, made: BackupContents) -> None:
    """Check that a backup has what was written into it."""
    if found.missing or (found.files, found.size) != (made.files, made.size):
        raise ArchiveRefused(f"{made.path} does not hold what was written; is the disk full? Archive them again.")


def _find_all(database: Database, jobs: Sequence[str]) -> tuple[str, ...]:
    """Return some families, all that read them and, with their families, all that those read.

    Raises:
        ArchiveRefused: if one of them has not ended.
    """
    with database.read() as session:
        family = select(JobRow.id).where(JobRow.family.in_(select(JobRow.family).where(JobRow.id.in_(jobs))))
        found = set(find_dependent_jobs(database, list(session.scalars(family))))
        new = found
        while new:
            read = select(JobInputRow.input).where(JobInputRow.job.in_(new))
            families = select(JobRow.family).where(or_(JobRow.id.in_(new), JobRow.id.in_(read)))
            new = set(session.scalars(select(JobRow.id).where(JobRow.family.in_(families)))) - found
            found |= new
        open_jobs = select(JobRow.id).where(JobRow.id.in_(found), JobRow.state.not_in(ENDED)).order_by(JobRow.id)
        running = list(session.scalars(open_jobs))
    if running:
        raise ArchiveRefused(f"job {running[0]} has not ended; wait for it, or cancel it.")
    return tuple(sorted(found))


def _keep_only(path: Path, jobs: Sequence[str]) -> None:
    """Delete from a copy of the database, an SQLite file, what is not some jobs' or of use for them."""
    database = Database(f"sqlite:///{path}", pooled=False)
    upgrade(database)
    try:
        with database.engine.connect() as connection:
            connection.execute(text("create temporary table kept_jobs (id text primary key)"))
            connection.execute(insert(KEPT), [{"id": job} for job in jobs])
            for one in reversed(Base.metadata.sorted_tables):
                _delete_rows(connection, one)
            _delete_unused(connection)
            connection.commit()
    finally:
        database.dispose()
    with closing(sqlite3.connect(path, isolation_level=None)) as copied:
        copied.execute("vacuum")  # else the file still has the bytes of what was deleted


def _delete_rows(connection: Connection, rows: Table) -> None:
    """Delete the rows of one table that belong to other jobs, or to users."""
    kept = select(KEPT.c.id)
    if rows.name in LEFT_OUT:
        connection.execute(delete(rows))
    elif rows.name == JobRow.__tablename__:
        connection.execute(delete(rows).where(rows.c.id.not_in(kept)))
    else:
        for one in _list_jobs_of(rows):
            connection.execute(delete(rows).where(one.is_not(None), one.not_in(kept)))


def _list_jobs_of(rows: Table) -> list[Column[str]]:
    """Return the columns of a table that name a job."""
    owners = (JobRow.__tablename__, PatternRow.__tablename__)
    return [one for one in rows.columns if any(key.column.table.name in owners for key in one.foreign_keys)]


def _delete_unused(connection: Connection) -> None:
    """Delete scans, subjects, batches, patterns and fabrics that no job left is of."""
    for rows, name, used in (
        (ScanRow, ScanRow.sha256, select(JobRow.scan)),
        (SubjectRow, SubjectRow.id, select(SubjectJobRow.subject)),
        (BatchRow, BatchRow.tag, select(JobTagRow.tag)),
        (TemplateRow, TemplateRow.name, select(JobRow.template).where(JobRow.template.is_not(None))),
        (FabricRow, FabricRow.name, select(JobRow.fabric).where(JobRow.fabric.is_not(None))),
        (MaterialRow, MaterialRow.id, select(PatternRow.material)),
    ):
        connection.execute(delete(rows).where(name.not_in(used)))
