"""The audit log: one row in the database for each request of a key that changed, downloaded or deleted something."""

from __future__ import annotations

from dataclasses import dataclass

from sqlalchemy import delete, select

from .database import Database, change_rows, clock, skip_damaged_rows
from .models import AuditRow


@dataclass(frozen=True)
class Access:
    """Describe one recorded request: time [s since 1970], key, action, subject, client address, request id."""

    at: float
    key: str
    action: str
    subject: str
    address: str
    request: str


KEPT_DAYS = 400
"""How long rows are kept [d]: just over a year, as most rules on the protection of personal data require."""

DOWNLOADS = ("/artifacts/", "/result.zip")
"""Parts of the paths by which results are downloaded; every request that changes something is recorded as well."""

PERSONS = "/v1/persons/"
"""Beginning of the paths that end in a person's name; the log must not keep that name."""

READ_ONLY_ENDINGS = ("/states", "/patterns/check", "/patterns/edit")
"""Ends of the paths of POST requests that change nothing."""


def is_recorded(method: str, path: str, status: int) -> bool:
    """Return whether the log keeps a request: it changed something, or downloaded a file."""
    if status >= 400 or path.endswith(READ_ONLY_ENDINGS):
        return False
    return method in ("POST", "PUT", "PATCH", "DELETE") or (method == "GET" and any(part in path for part in DOWNLOADS))


def record_access(database: Database, key: str, action: str, subject: str, origin: tuple[str, str]) -> None:
    """Add one row.

    Args:
        database: The log's database.
        key: Id of the API key; empty: the local user.
        action: Method and status.
        subject: The path; a person's name in it is not kept.
        origin: Address of the client, and the request's id.
    """
    subject = f"{PERSONS}{{name}}" if subject.startswith(PERSONS) else subject
    clean = "".join(letter if letter.isprintable() else "?" for letter in subject)[:255]
    with database.write() as session:
        session.add(
            AuditRow(at=clock(), key=key, action=action, subject=clean, address=origin[0][:64], request=origin[1])
        )


@skip_damaged_rows
def list_accesses(database: Database, limit: int = 100, key: str | None = None) -> list[Access]:
    """Return the newest rows, newest first; with `key` only those of one API key."""
    statement = select(AuditRow).order_by(AuditRow.id.desc()).limit(limit)
    with database.read() as session:
        rows = session.scalars(statement if key is None else statement.where(AuditRow.key == key)).all()
    return [Access(row.at, row.key, row.action, row.subject, row.address, row.request) for row in rows]


def forget_accesses(database: Database) -> int:
    """Delete rows older than `KEPT_DAYS`; return how many."""
    with database.write() as session:
        return change_rows(session, delete(AuditRow).where(AuditRow.at < clock() - KEPT_DAYS * 86400.0))
