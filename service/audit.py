"""The log of what keys changed, took and deleted: one row for each such request, kept in the database."""

from __future__ import annotations

from dataclasses import dataclass

from sqlalchemy import delete, select

from .database import Database, change_rows, clock, skip_damaged_rows
from .models import AuditRow


@dataclass(frozen=True)
class Access:
    """Describe one request that changed or took something: when [s since 1970], whose key, what, from where."""

    at: float
    key: str
    action: str
    subject: str
    address: str
    request: str


KEPT_DAYS = 400
"""How long rows are kept [d]: a year and a little, as most rules on the protection of personal data ask."""

DOWNLOADS = ("/artifacts/", "/result.zip")
"""Parts of the paths by which results leave the service; every request that changes something is recorded as well."""

PERSONS = "/v1/persons/"
"""Beginning of the paths that end in a person's name, which must not outlive the person's data here."""

READ_ONLY_ENDINGS = ("/states", "/patterns/check", "/patterns/edit")
"""Ends of the paths that are asked by POST and change nothing."""


def is_recorded(method: str, path: str, status: int) -> bool:
    """Return whether a request is one that the log keeps: it changed something, or took a file."""
    if status >= 400 or path.endswith(READ_ONLY_ENDINGS):
        return False
    return method in ("POST", "PUT", "DELETE") or (method == "GET" and any(part in path for part in DOWNLOADS))


def record_access(database: Database, key: str, action: str, subject: str, came: tuple[str, str]) -> None:
    """Add one row.

    Args:
        database: Where it is kept.
        key: Id of the API key; empty: the local user.
        action: Method and status.
        subject: The path; of a person's the log keeps no name.
        came: Address of the client, and the request's id.
    """
    subject = f"{PERSONS}{{name}}" if subject.startswith(PERSONS) else subject
    clean = "".join(letter if letter.isprintable() else "?" for letter in subject)[:255]
    with database.write() as session:
        session.add(AuditRow(at=clock(), key=key, action=action, subject=clean, address=came[0][:64], request=came[1]))


@skip_damaged_rows
def list_accesses(database: Database, limit: int = 100, key: str | None = None) -> list[Access]:
    """Return the newest rows, newest first; with `key` those of one API key."""
    asked = select(AuditRow).order_by(AuditRow.id.desc()).limit(limit)
    with database.read() as session:
        rows = session.scalars(asked if key is None else asked.where(AuditRow.key == key)).all()
    return [Access(row.at, row.key, row.action, row.subject, row.address, row.request) for row in rows]


def forget_accesses(database: Database) -> int:
    """Remove what is older than `KEPT_DAYS`; return how many rows."""
    with database.write() as session:
        return change_rows(session, delete(AuditRow).where(AuditRow.at < clock() - KEPT_DAYS * 86400.0))
