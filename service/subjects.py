"""Subjects: a record for each person who was scanned, with the person's jobs. Each belongs to one API key."""

from __future__ import annotations

import math
import re
import secrets
from collections.abc import Sequence
from dataclasses import asdict, fields
from typing import Any

from sqlalchemy import delete, func, or_, select
from sqlalchemy.orm import Session

from ..core.run.errors import BadInput, NotFound
from .database import Database, clock, skip_damaged_rows, take_advisory_lock
from .families import find_tree
from .jobs import IDS_AT_ONCE, JobUnknown
from .models import BodyRow, JobRow, MetricRow, OwnerRow, ScanRow, SubjectJobRow, SubjectRow
from .records import Child
from .subject_records import (
    Subject,
    SubjectFamily,
    SubjectFields,
    SubjectReport,
    SubjectScan,
    SubjectWearer,
    read_row,
)

SUBJECT_ID = re.compile(r"[0-9a-f]{12}")
"""Form of a subject's id; no name has it, so that a text is either."""

MAX_SUBJECT_NAME_LENGTH, MAX_SUBJECT_NOTE_LENGTH = 255, 10_000
"""Largest numbers of letters of a subject's name or consent, and of its note."""

MAX_KEEP_DAYS = 36_500.0
"""Longest retention [d]: a hundred years, as an API key's."""

MAX_SUBJECT_PAGE = 1000
"""Largest number of subjects of one list."""

MAX_SUBJECT_FAMILIES = 200
"""Largest number of families of a subject's report; `query` lists all its jobs."""

WEARER_PREFIX = "wearer."
"""Beginning of the names of metrics that are a body's measures."""


class SubjectUnknown(NotFound):
    """There is no such subject; `garmentq subjects list` shows them."""

    code = "subject.unknown"


class SubjectBad(BadInput):
    """A subject needs a printable name of at most 255 letters, valid times, and a retention of at most 36500 days."""

    code = "subject.bad"


class SubjectTaken(BadInput):
    """There is a subject of this name; use that one, or another name."""

    code = "subject.name_taken"


class SubjectJobShared(BadInput):
    """Another key has the job too, so it cannot belong to a subject; submit the scan again with the subject."""

    code = "subject.job_shared"


def create_subject(database: Database, fields: SubjectFields, key: str = "") -> Subject:
    """Create a subject of an API key (empty: the local user).

    Raises:
        SubjectBad: if a field cannot be used.
        SubjectTaken: if the key has a subject of this name.
    """
    check_fields(fields)
    with database.write() as session:
        return _describe(session, [_add(session, key, fields)])[0]


def update_subject(database: Database, subject: str, fields: SubjectFields, key: str | None = None) -> Subject:
    """Replace what is said of a subject; with a key only one of its own.

    Raises:
        SubjectUnknown: if there is none.
        SubjectBad, SubjectTaken: as for a new one.
    """
    check_fields(fields)
    with database.write() as session:
        row = find_row(session, subject, key)
        take_advisory_lock(session, f"subject {row.key} {fields.name}")
        if fields.name != row.name and _find_by_name(session, row.key, fields.name) is not None:
            raise SubjectTaken(f"there is a subject '{fields.name[:80]}'; use that one, or another name.")
        for name, value in asdict(fields).items():
            setattr(row, name, value)
        session.flush()
        return _describe(session, [row])[0]


@skip_damaged_rows
def list_subjects(
    database: Database, name: str = "", limit: int = 50, before: str = "", key: str | None = None
) -> list[Subject]:
    """Return the newest subjects.

    Args:
        database: The subjects' database.
        name: Only those of exactly this name; empty: all.
        limit: Largest number.
        before: Only those after this one in the list, by its id; empty: from the newest on.
        key: Only those of this API key; None: of all.
    """
    statement = select(SubjectRow).order_by(SubjectRow.created.desc(), SubjectRow.id.desc())
    if key is not None:
        statement = statement.where(SubjectRow.key == key)
    if name:
        statement = statement.where(SubjectRow.name == name)
    with database.read() as session:
        last = session.get(SubjectRow, before) if before else None
        if last is not None and key in (None, last.key):
            older = (SubjectRow.created == last.created) & (SubjectRow.id < last.id)
            statement = statement.where(or_(SubjectRow.created < last.created, older))
        return _describe(session, session.scalars(statement.limit(limit)).all())


def find_subject(database: Database, subject: str, key: str | None = None) -> SubjectReport:
    """Return a subject with all that is known of it, by its id or its exact name; with a key only one of its own.

    Raises:
        SubjectUnknown: if there is none.
    """
    with database.read() as session:
        row = find_row(session, subject, key)
        (found,) = _describe(session, [row])
        families = _list_families(session, row.id)
        shown = {one.name: getattr(found, one.name) for one in fields(Subject)}
        return SubjectReport(
            **shown, scans=_list_scans(session, row.id), families=families, wearers=_list_wearers(session, row.id)
        )


def assign_jobs(database: Database, subject: str, jobs: Sequence[str], key: str | None = None) -> Subject:
    """Make jobs, with all of their families, a subject's; with a key only its own jobs and subject.

    Raises:
        SubjectUnknown: if there is no such subject.
        JobUnknown: if there is no job of an id.
        SubjectJobShared: if another key owns one of them.
    """
    with database.write() as session:
        row = find_row(session, subject, key)
        for job in jobs:
            found = session.get(JobRow, job)
            owners = set(session.scalars(select(OwnerRow.key).where(OwnerRow.job == job)))
            if found is None or (key is not None and key and key not in owners):
                raise JobUnknown(f"there is no job '{job[:40]}'; `garmentq status` lists them all.")
            if owners - {row.key}:
                raise SubjectJobShared(f"another key has job {job} too. {SubjectJobShared().message}")
            root = session.get_one(JobRow, found.family or found.id, with_for_update=True)
            set_subject(session, row.id, [one.id for one in find_tree(session, root, is_locked=True)])
        session.flush()
        return _describe(session, [row])[0]


def choose_subject(session: Session, key: str, text: str) -> str:
    """Return the id of a key's subject by its id or its exact name; one of a new name is created.

    Raises:
        SubjectUnknown: if the text is an id that the key does not have.
        SubjectBad: if it is no name.
    """
    if SUBJECT_ID.fullmatch(text):
        return find_row(session, text, key).id
    fields = SubjectFields(text)
    check_fields(fields)
    take_advisory_lock(session, f"subject {key} {text}")
    row = _find_by_name(session, key, text)
    return (row or _add(session, key, fields)).id


def set_subject(session: Session, subject: str, jobs: Sequence[str]) -> None:
    """Make jobs a subject's, and no other's."""
    session.flush()
    for start in range(0, len(jobs), IDS_AT_ONCE):
        session.execute(delete(SubjectJobRow).where(SubjectJobRow.job.in_(jobs[start : start + IDS_AT_ONCE])))
    session.add_all(SubjectJobRow(job=job, subject=subject) for job in jobs)


def find_row(session: Session, subject: str, key: str | None = None) -> SubjectRow:
    """Return a subject's row by its id or its exact name; with a key only one of its own.

    Raises:
        SubjectUnknown: if there is none, or several keys have one of this name.
    """
    is_named = SubjectRow.id == subject if SUBJECT_ID.fullmatch(subject) else SubjectRow.name == subject
    statement = select(SubjectRow).where(is_named)
    rows = session.scalars((statement if key is None else statement.where(SubjectRow.key == key)).limit(2)).all()
    if len(rows) == 2:
        rows = [row for row in rows if not row.key] or rows
        if len(rows) == 2:
            raise SubjectUnknown(f"several API keys have a subject '{subject[:80]}'; name it by its id.")
    if not rows:
        raise SubjectUnknown()
    return rows[0]


def check_fields(fields: SubjectFields) -> None:
    """Check what is said of a subject.

    Raises:
        SubjectBad: if it cannot be used.
    """
    is_named = 0 < len(fields.name) <= MAX_SUBJECT_NAME_LENGTH and fields.name.isprintable()
    if not is_named or SUBJECT_ID.fullmatch(fields.name) or fields.name != fields.name.strip():
        raise SubjectBad()
    is_short = len(fields.consent) <= MAX_SUBJECT_NAME_LENGTH and len(fields.note) <= MAX_SUBJECT_NOTE_LENGTH
    times = (fields.consented, fields.consent_until, fields.keep_until)
    is_timed = all(one is None or (math.isfinite(one) and 0.0 <= one < 1e11) for one in times)
    if not is_short or not is_timed or not (fields.keep_days is None or 0.0 < fields.keep_days <= MAX_KEEP_DAYS):
        raise SubjectBad()


def _add(session: Session, key: str, fields: SubjectFields) -> SubjectRow:
    take_advisory_lock(session, f"subject {key} {fields.name}")
    if _find_by_name(session, key, fields.name) is not None:
        raise SubjectTaken(f"there is a subject '{fields.name[:80]}'; use that one, or another name.")
    row = SubjectRow(id=secrets.token_hex(6), key=key, created=clock(), **asdict(fields))
    session.add(row)
    session.flush()
    session.refresh(row)
    return row


def _find_by_name(session: Session, key: str, name: str) -> SubjectRow | None:
    return session.scalars(select(SubjectRow).where(SubjectRow.key == key, SubjectRow.name == name)).one_or_none()


def _describe(session: Session, rows: Sequence[SubjectRow]) -> list[Subject]:
    """Return the records of some rows."""
    last = func.max(func.coalesce(JobRow.finished, JobRow.created))
    counted = (
        select(SubjectJobRow.subject, func.count(), last)
        .join(JobRow, JobRow.id == SubjectJobRow.job)
        .where(SubjectJobRow.subject.in_([row.id for row in rows]))
        .group_by(SubjectJobRow.subject)
    )
    found: dict[str, tuple[int, float | None]] = {one[0]: (one[1], one[2]) for one in session.execute(counted)}
    return [Subject(**read_row(row, *found.get(row.id, (0, None)))) for row in rows]


def _of_subject(statement: Any, subject: str) -> Any:
    return statement.join(SubjectJobRow, SubjectJobRow.job == JobRow.id).where(SubjectJobRow.subject == subject)


def _list_families(session: Session, subject: str) -> tuple[SubjectFamily, ...]:
    roots = _of_subject(select(JobRow), subject).where(JobRow.parent.is_(None))
    rows = session.scalars(roots.order_by(JobRow.created.desc(), JobRow.id.desc()).limit(MAX_SUBJECT_FAMILIES)).all()
    children: dict[str, list[Child]] = {}
    names = (JobRow.family, JobRow.id, JobRow.name, JobRow.kind, JobRow.state)
    below = select(*names).where(JobRow.family.in_([row.id for row in rows]), JobRow.parent.is_not(None))
    for row in session.execute(below.order_by(JobRow.created, JobRow.id)):
        children.setdefault(row.family, []).append(Child(row.id, row.name, row.kind, row.state))
    return tuple(
        SubjectFamily(
            row.id, row.name, row.kind, row.state, row.verdict, row.garment, row.created,
            tuple(children.get(row.id, ())),
        )
        for row in rows
    )  # fmt: skip


def _list_scans(session: Session, subject: str) -> tuple[SubjectScan, ...]:
    scans = _of_subject(select(JobRow.scan), subject)
    statement = select(ScanRow).where(ScanRow.sha256.in_(scans)).order_by(ScanRow.created.desc(), ScanRow.sha256)
    rows = session.scalars(statement.limit(MAX_SUBJECT_FAMILIES))
    return tuple(SubjectScan(row.sha256, row.name, row.size, row.created) for row in rows)


def _list_wearers(session: Session, subject: str) -> tuple[SubjectWearer, ...]:
    bodies = _of_subject(select(BodyRow, JobRow.created).join(JobRow, JobRow.id == BodyRow.job), subject)
    bodies = bodies.where(BodyRow.source != "").order_by(JobRow.created.desc(), JobRow.id.desc())
    rows = session.execute(bodies.limit(MAX_SUBJECT_FAMILIES)).all()
    statement = select(MetricRow).where(
        MetricRow.job.in_([row[0].job for row in rows]), MetricRow.name.startswith(WEARER_PREFIX, autoescape=True)
    )
    measures: dict[str, dict[str, float]] = {}
    for metric in session.scalars(statement):
        if metric.value is not None and metric.name.endswith("_mm"):
            name = metric.name.removeprefix(WEARER_PREFIX).removesuffix("_mm")
            measures.setdefault(metric.job, {})[name] = metric.value
    return tuple(
        SubjectWearer(body.job, created, body.source, body.fit_rms, dict(sorted(measures.get(body.job, {}).items())))
        for body, created in rows
    )
