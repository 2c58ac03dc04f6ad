"""Share links: whoever has one sees one result, read-only, for some days. Only the hash of its token is stored."""

from __future__ import annotations

import secrets
import uuid

from sqlalchemy import delete, func, select, update

from ..core.run.errors import BadInput, NotFound
from .database import Database, change_rows, clock
from .keys import TOKEN_BYTES, KeyBad, authenticate_key, hash_token
from .models import JobRow, ShareRow
from .share_records import DEFAULT_SHARE_DAYS, SHARE_DAYS, Share
from .states import State

MAX_JOB_SHARES = 50
"""Largest number of valid links of one result: a link for each person of a large team."""


class ShareUnknown(NotFound):
    """The link is not valid, or not any more; ask whoever sent it for a new one."""

    code = "share.unknown"


class SharesFull(BadInput):
    """The result has the largest number of valid links; revoke one that is not needed."""

    code = "share.full"


class ResultUnshared(BadInput):
    """Only a job that has succeeded can be shared; wait until it has ended."""

    code = "share.not_ended"


def create_share(database: Database, job: str, days: int = DEFAULT_SHARE_DAYS, key: str = "") -> tuple[Share, str]:
    """Make a link to the result of a job, and return it with its token, which is returned only here.

    Args:
        database: The jobs' database.
        job: Id of the job.
        days: Validity [d], one of `SHARE_DAYS`.
        key: Id of the key that makes it; the link is valid no longer than the key.

    Raises:
        BadInput: if `days` is not a choice.
        ResultUnshared: if the job has not succeeded.
        SharesFull: if the result has too many links.
    """
    if days not in SHARE_DAYS:
        raise ShareDaysBad()
    token = secrets.token_urlsafe(TOKEN_BYTES)
    with database.write() as session:
        if session.scalar(select(JobRow.state).where(JobRow.id == job).with_for_update()) != State.SUCCEEDED:
            raise ResultUnshared()
        session.execute(delete(ShareRow).where(ShareRow.expires <= clock()))
        if (session.scalar(select(func.count()).where(ShareRow.job == job)) or 0) >= MAX_JOB_SHARES:
            raise SharesFull()
        row = ShareRow(
            id=uuid.uuid4().hex[:12], hash=hash_token(token), job=job, key=key, created=clock(),
            expires=clock() + days * 86400.0, opened=0,
        )  # fmt: skip
        session.add(row)
        session.flush()
        session.refresh(row)
        return Share.from_row(row), token


class ShareDaysBad(BadInput):
    """A link is valid for 1, 7 or 30 days; choose one of them."""

    code = "share.days_bad"


def list_shares(database: Database, job: str, key: str | None = None) -> list[Share]:
    """Return the valid links to a job's result, oldest first; with `key` only those that it made."""
    statement = select(ShareRow).where(ShareRow.job == job, ShareRow.expires > clock())
    statement = statement if key is None else statement.where(ShareRow.key == key)
    with database.read() as session:
        return [Share.from_row(row) for row in session.scalars(statement.order_by(ShareRow.created, ShareRow.id))]


def revoke_share(database: Database, job: str, share: str, key: str | None = None) -> Share:
    """Revoke a link to a job's result, and return it; with `key` only one that it made.

    Raises:
        ShareUnknown: if there is none of that id.
    """
    condition = (ShareRow.job == job) & (ShareRow.id == share)
    condition = condition if key is None else condition & (ShareRow.key == key)
    with database.write() as session:
        row = session.scalars(select(ShareRow).where(condition)).one_or_none()
        if row is None:
            raise ShareUnknown(f"the result has no link '{share[:20]}'.")
        session.delete(row)
        return Share.from_row(row)


def find_share(database: Database, token: str) -> Share:
    """Return the link of a token.

    Raises:
        ShareUnknown: if there is none, it has expired or was revoked, or its key is no longer valid; all look alike.
    """
    with database.read() as session:
        statement = select(ShareRow).where(ShareRow.hash == hash_token(token), ShareRow.expires > clock())
        row = session.scalars(statement).one_or_none()
        share = None if row is None else Share.from_row(row)
    if share is None:
        raise ShareUnknown()
    if share.key:
        try:
            authenticate_key(database, share.key)
        except KeyBad:
            raise ShareUnknown() from None
    return share


def note_opened(database: Database, share: str) -> None:
    """Count that the page of a link was shown."""
    with database.write() as session:
        change_rows(session, update(ShareRow).where(ShareRow.id == share).values(opened=ShareRow.opened + 1))
