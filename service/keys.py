"""API keys: authentication, scopes and quotas. Only the hash of a token is stored."""

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
"""`read`: see own jobs and the libraries; `submit`: upload, queue, cancel, delete; `metrics`: metrics of the whole
service; `admin`: all jobs, templates and keys."""

USED_SECONDS = 60.0
"""Resolution of a key's last use [s]: finer would be a write for each request."""

MAX_JOB_PRIORITY = 100
"""Largest number for a job's priority."""

TOKEN_BYTES = 32
"""Number of random bytes of a token: it cannot be guessed, so its plain hash is safe to store."""

DEFAULT_JOB_QUOTA = 100
"""Number of jobs that a new key may have queued or running; a studio's day, and too few to delay the jobs of others for
hours."""


DEFAULT_GRACE_HOURS, MAX_GRACE_HOURS = 24.0, 168.0
"""Usual and longest time for which a token or a secret stays valid beside its successor [h]: a day to write the new one
to every place that has the old one, and a week at most, because the old one may have leaked."""


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
    """The key has reached its number of queued and running jobs; wait until some have run, or cancel them."""

    code = "key.queue_full"


class PriorityTooHigh(GarmentqError):
    """The key may not use so high a priority; leave it out, or ask the operator for a key that may."""

    code = "key.priority"


class KeyUnknown(NotFound):
    """There is no such key; `garmentq keys list` shows them."""

    code = "key.unknown"


class KeyRevoked(BadInput):
    """The key was revoked, so it has no new token; `garmentq keys create` makes another key."""

    code = "key.revoked"


class GraceBad(BadInput):
    """A token or secret stays valid for 0 to 168 hours beside its successor; choose a number between."""

    code = "key.grace_bad"


class KeySpecBad(BadInput):
    """A key needs a name of at most 255 letters, known scopes, a quota from 1 to 1000000 and a priority of 0 to 100."""

    code = "key.spec_bad"


@dataclass(frozen=True)
class Caller:
    """Describe the caller of a request.

    Attributes:
        key: The key's id; empty for the local user of a service without keys.
        scopes: Its permissions, of `SCOPES`.
        quota: Jobs that may be queued or running at a time; 0: any number.
        priority: Highest priority that its jobs may have.
    """

    key: str
    scopes: tuple[str, ...]
    quota: int
    priority: int = MAX_JOB_PRIORITY

    @property
    def sees_all(self) -> bool:
        """Return whether the caller sees every job, not only the key's own."""
        return "admin" in self.scopes

    def check_scope(self, scope: str) -> None:
        """Check one scope.

        Raises:
            ScopeMissing: if the key lacks it.
        """
        if scope not in self.scopes and "admin" not in self.scopes:
            raise ScopeMissing(f"the key lacks the scope '{scope}'; ask for one that has it.")

    def check_priority(self, priority: int) -> None:
        """Check the priority of a job.

        Raises:
            PriorityTooHigh: if it exceeds the key's.
        """
        if priority > self.priority:
            raise PriorityTooHigh(f"the key's highest priority is {self.priority}; use that, or another key.")


LOCAL_CALLER = Caller("", SCOPES, 0)
"""The user of a service that listens on a loopback address and has no keys."""


def create_key(
    database: Database,
    name: str,
    scopes: tuple[str, ...],
    quota: int = DEFAULT_JOB_QUOTA,
    priority: int = 0,
    days: float | None = None,
) -> tuple[ApiKeyRow, str]:
    """Create a key and return it with its token, which is returned only here.

    Args:
        database: The keys' database.
        name: Name of its holder.
        scopes: Its permissions, of `SCOPES`.
        quota: Number of jobs that it may have open at a time.
        priority: Highest priority that its jobs may have.
        days: Time until it expires [d]; None: never.

    Raises:
        KeySpecBad: if one of them cannot be used.
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
    """Revoke a key; its jobs stay.

    Raises:
        KeyUnknown: if there is none of that id.
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


def rotate_key(database: Database, key: str, hours: float = DEFAULT_GRACE_HOURS) -> tuple[ApiKeyRow, str]:
    """Give a key a new token, and return both; the token before stays valid for some hours, one before that ends.

    Args:
        database: The keys' database.
        key: Id of the key; its jobs, webhooks and uploads stay its own.
        hours: How long the token before stays valid [h]; 0: it ends at once.

    Raises:
        KeyUnknown: if there is none of that id.
        KeyRevoked: if it was revoked.
        GraceBad: if `hours` is out of range.
    """
    check_grace(hours)
    token = "gq_" + secrets.token_hex(TOKEN_BYTES)
    with database.write() as session:
        lock_key(session, key)
        row = session.get(ApiKeyRow, key)
        if row is None:
            raise KeyUnknown()
        if row.revoked is not None:
            raise KeyRevoked()
        row.earlier_hash, row.earlier_until = row.hash, clock() + 3600.0 * hours
        row.hash = hash_token(token)
        session.flush()
        session.refresh(row)
    return row, token


def check_grace(hours: float) -> None:
    """Check how long a token or secret stays valid beside its successor [h].

    Raises:
        GraceBad: if it is out of range.
    """
    if not 0.0 <= hours <= MAX_GRACE_HOURS:
        raise GraceBad()


def has_keys(database: Database) -> bool:
    """Return whether a key was ever created, revoked ones too: a service that had keys never becomes open again."""
    with database.read() as session:
        return bool(session.execute(select(exists().where(ApiKeyRow.id != ""))).scalar())


def authenticate_token(database: Database, token: str | None, local_token: str = "") -> Caller:
    """Authenticate a token.

    Args:
        database: The keys' database.
        token: Token of the request.
        local_token: Token that authenticates the local user while no keys exist; empty: there is no local user.

    Raises:
        KeyMissing, KeyBad: if the token is missing, unknown or no longer valid.
    """
    if not token:
        raise KeyMissing()
    if local_token and hmac.compare_digest(token.encode("utf-8", "replace"), local_token.encode()):
        if has_keys(database):
            raise KeyBad("this service has keys; the token of its home is valid only without keys. Use a key.")
        return LOCAL_CALLER
    stored = hash_token(token)
    is_earlier = (ApiKeyRow.earlier_hash == stored) & (ApiKeyRow.earlier_until > clock())
    return _authenticate(database, (ApiKeyRow.hash == stored) | is_earlier)


def authenticate_key(database: Database, key: str) -> Caller:
    """Return the caller of a key by its id; the caller must have been authenticated before.

    Raises:
        KeyBad: if it was revoked or has expired.
    """
    return _authenticate(database, ApiKeyRow.id == key)


def _authenticate(database: Database, is_meant: ColumnElement[bool]) -> Caller:
    old = ApiKeyRow.used.is_(None) | (ApiKeyRow.used < clock() - USED_SECONDS)
    with database.read() as session:
        statement = select(ApiKeyRow, old, ApiKeyRow.expires <= clock()).where(is_meant)
        row, is_old, is_over = session.execute(statement).one_or_none() or (None, False, False)
    if row is None or row.revoked is not None or is_over:
        raise KeyBad()
    if is_old:
        with database.write() as session:
            session.execute(update(ApiKeyRow).where(ApiKeyRow.id == row.id).values(used=clock()))
    return Caller(row.id, tuple(row.scopes), row.quota, row.priority)


def grant_job(session: Session, key: str, job: str) -> None:
    """Make a key an owner of a job; an empty key is the local user, who sees all jobs."""
    if key and session.get(OwnerRow, (key, job)) is None:
        session.flush()
        session.add(OwnerRow(key=key, job=job))
        session.flush()


def check_quota(session: Session, key: str, quota: int) -> None:
    """Check a key's number of open jobs, with the key's row locked so that two requests at once cannot both pass.

    A job counts for the key that queued it last, its payer; at most `quota` entries of an index are read.

    Raises:
        QueueFull: if it has reached its quota.
    """
    if not key:
        return
    lock_key(session, key)
    jobs = select(func.count()).select_from(JobRow).where(JobRow.payer == key, JobRow.state.in_(OPEN))
    if (session.execute(jobs).scalar() or 0) >= quota:
        raise QueueFull(f"the key has {quota} jobs queued or running, its limit; wait, or cancel some.")


def lock_key(session: Session, key: str) -> None:
    """Block other transactions of this key until this one ends."""
    session.execute(select(ApiKeyRow.id).where(ApiKeyRow.id == key).with_for_update())


def hash_token(token: str) -> str:
    """Return the stored form of a token."""
    return hashlib.sha256(token.encode("utf-8", "surrogatepass")).hexdigest()
