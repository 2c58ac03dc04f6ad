"""API keys: who may ask, for what, and how much at a time. Only the hash of a token is kept."""

from __future__ import annotations

import hashlib
import hmac
import secrets
from dataclasses import dataclass

from sqlalchemy import ColumnElement, exists, func, select, update
from sqlalchemy.orm import Session

from ..core.run.errors import BadInput, GarmentqError, NotFound
from .database import Database, clock, skip_damaged_rows
from .models import ApiKeyRow, JobRow, OwnerRow
from .states import OPEN

SCOPES = ("read", "submit", "metrics", "admin")
"""`read`: see own jobs and the libraries; `submit`: upload, queue, cancel, delete; `metrics`: numbers of the whole
service; `admin`: all jobs, templates and keys."""

USED_SECONDS = 60.0
"""How exactly a key's last use is noted [s]: more often would be a write for each request."""

MAX_JOB_PRIORITY = 100
"""Highest priority of any job."""

TOKEN_BYTES = 32
"""Random bytes of a token: beyond any guessing, so that a plain hash of it is safe to keep."""

DEFAULT_JOB_QUOTA = 100
"""Number of jobs that a new key may have queued or running; a studio's day, and less than what delays the jobs of
others for hours."""


class KeyMissing(GarmentqError):
    """The service needs a key; send `Authorization: Bearer TOKEN` (docs/reference/http.md), or set GARMENTQ_API_KEY."""

    code = "key.missing"


class KeyBad(GarmentqError):
    """The key is not known, was revoked or has expired; ask for a new one (`garmentq keys create`)."""

    code = "key.bad"


class ScopeMissing(GarmentqError):
    """The key may not do this; ask for one with a wider scope (`garmentq keys create --scope`)."""

    code = "key.scope_missing"


class QueueFull(GarmentqError):
    """The key has as many jobs queued or running as it may; wait until some have run, or cancel them."""

    code = "key.queue_full"


class PriorityTooHigh(GarmentqError):
    """The key may not ask for so high a priority; leave it out, or ask the operator for a key that may."""

    code = "key.priority"


class KeyUnknown(NotFound):
    """There is no such key; `garmentq keys list` shows them."""

    code = "key.unknown"


class KeySpecBad(BadInput):
    """A key needs a name of at most 255 letters, known scopes, a quota from 1 to 1000000 and a priority of 0 to 100."""

    code = "key.spec_bad"


@dataclass(frozen=True)
class Caller:
    """Describe who asks.

    Attributes:
        key: The key's id; empty for the local user of a service without keys.
        scopes: What is allowed, of `SCOPES`.
        quota: Jobs that may be queued or running at a time; 0: any number.
        priority: Highest priority that its jobs may have.
    """

    key: str
    scopes: tuple[str, ...]
    quota: int
    priority: int = MAX_JOB_PRIORITY

    @property
    def sees_all(self) -> bool:
        """Return whether every job is shown, not only the key's own."""
        return "admin" in self.scopes

    def must(self, scope: str) -> None:
        """Check one scope.

        Raises:
            ScopeMissing: where the key lacks it.
        """
        if scope not in self.scopes and "admin" not in self.scopes:
            raise ScopeMissing(f"the key lacks the scope '{scope}'; ask for one that has it.")

    def may_hurry(self, priority: int) -> None:
        """Check the priority of a job.

        Raises:
            PriorityTooHigh: where the key may not ask for it.
        """
        if priority > self.priority:
            raise PriorityTooHigh(f"the key's highest priority is {self.priority}; ask for that, or for another key.")


LOCAL_CALLER = Caller("", SCOPES, 0)
"""The user of a service that listens on this machine only and has no keys."""


def create_key(
    database: Database,
    name: str,
    scopes: tuple[str, ...],
    quota: int = DEFAULT_JOB_QUOTA,
    priority: int = 0,
    days: float | None = None,
) -> tuple[ApiKeyRow, str]:
    """Make a key; its token is given here and never again.

    Args:
        database: Where it is kept.
        name: Whose it is.
        scopes: What it may, of `SCOPES`.
        quota: Jobs that it may have open at a time.
        priority: Highest priority that its jobs may have.
        days: After so long it expires [d]; None: never.

    Raises:
        KeySpecBad: where one of them cannot be used.
    """
    is_named = 0 < len(name) <= 255 and name.isprintable()
    is_bounded = 0 <= priority <= MAX_JOB_PRIORITY and (days is None or 0 < days <= 36500)
    if not is_named or not is_bounded or not scopes or not set(scopes) <= set(SCOPES) or not 1 <= quota <= 1_000_000:
        raise KeySpecBad()
    token = "gq_" + secrets.token_hex(TOKEN_BYTES)
    row = ApiKeyRow(
        id=secrets.token_hex(6),
        name=name,
        hash=hash_token(token),
        scopes=sorted(set(scopes)),
        quota=quota,
        created=clock(),
        revoked=None,
        priority=priority,
        expires=None if days is None else clock() + days * 86400.0,
    )
    with database.write() as session:
        session.add(row)
        session.flush()
        session.refresh(row)
    return row, token


@skip_damaged_rows
def list_keys(database: Database) -> list[ApiKeyRow]:
    """Return every key, oldest first."""
    with database.read() as session:
        return list(session.scalars(select(ApiKeyRow).order_by(ApiKeyRow.created, ApiKeyRow.id)))


def revoke_key(database: Database, key: str) -> ApiKeyRow:
    """Take a key back; its jobs stay.

    Raises:
        KeyUnknown: where there is none of that id.
    """
    with database.write() as session:
        row = session.get(ApiKeyRow, key)
        if row is None:
            raise KeyUnknown()
        if row.revoked is None:
            row.revoked = clock()
            session.flush()
            session.refresh(row)
        return row


def has_keys(database: Database) -> bool:
    """Return whether a key was ever made, revoked ones too: a service that had keys never becomes open again."""
    with database.read() as session:
        return bool(session.execute(select(exists().where(ApiKeyRow.id != ""))).scalar())


def authenticate_token(database: Database, token: str | None, local_token: str = "") -> Caller:
    """Authenticate a token.

    Args:
        database: Whose keys count.
        token: What the caller sent.
        local_token: Makes its bearer the local user while the service has no keys; empty: there is no local user.

    Raises:
        KeyMissing, KeyBad: where nobody of that token is known.
    """
    if not token:
        raise KeyMissing()
    if local_token and hmac.compare_digest(token.encode("utf-8", "replace"), local_token.encode()):
        if has_keys(database):
            raise KeyBad("this service has keys by now; the token of its home is for one without.")
        return LOCAL_CALLER
    return _authenticate(database, ApiKeyRow.hash == hash_token(token))


def authenticate_key(database: Database, key: str) -> Caller:
    """Return who has a key, by its id; whoever calls this knows already that it is them who ask.

    Raises:
        KeyBad: where it was revoked or has expired.
    """
    return _authenticate(database, ApiKeyRow.id == key)


def _authenticate(database: Database, is_meant: ColumnElement[bool]) -> Caller:
    old = ApiKeyRow.used.is_(None) | (ApiKeyRow.used < clock() - USED_SECONDS)
    with database.read() as session:
        asked = select(ApiKeyRow, old, ApiKeyRow.expires <= clock()).where(is_meant)
        row, is_old, is_over = session.execute(asked).one_or_none() or (None, False, False)
    if row is None or row.revoked is not None or is_over:
        raise KeyBad()
    if is_old:
        with database.write() as session:
            session.execute(update(ApiKeyRow).where(ApiKeyRow.id == row.id).values(used=clock()))
    return Caller(row.id, tuple(row.scopes), row.quota, row.priority)


def grant_job(session: Session, key: str, job: str) -> None:
    """Make a key an owner of a job; an empty key is the local user, who sees all."""
    if key and session.get(OwnerRow, (key, job)) is None:
        session.flush()
        session.add(OwnerRow(key=key, job=job))
        session.flush()


def check_quota(session: Session, key: str, quota: int) -> None:
    """Count a key's open jobs, with the key's row locked so that two requests at once cannot both pass.

    A job counts for the key that queued it last, its payer; no more than the quota's entries of an index are read.

    Raises:
        QueueFull: where it has as many as it may.
    """
    if not key:
        return
    lock_key(session, key)
    jobs = select(func.count()).select_from(JobRow).where(JobRow.payer == key, JobRow.state.in_(OPEN))
    if (session.execute(jobs).scalar() or 0) >= quota:
        raise QueueFull(f"the key has {quota} jobs queued or running, as many as it may; wait, or cancel some.")


def lock_key(session: Session, key: str) -> None:
    """Block other transactions of this key from here until this one ends."""
    session.execute(select(ApiKeyRow.id).where(ApiKeyRow.id == key).with_for_update())


def hash_token(token: str) -> str:
    """Return what is kept of a token."""
    return hashlib.sha256(token.encode("utf-8", "surrogatepass")).hexdigest()
