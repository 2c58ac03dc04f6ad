"""API keys: who may ask, for what, and how much at a time. Only the hash of a token is kept."""

from __future__ import annotations

import hashlib
import hmac
import secrets
from dataclasses import dataclass

from sqlalchemy import exists, func, select
from sqlalchemy.orm import Session

from ..core.errors import BadInput, GarmentqError, NotFound
from .database import Database, clock
from .models import ApiKeyRow, JobRow, OwnerRow
from .states import OPEN

SCOPES = ("read", "submit", "admin")
"""`read`: see own jobs and the libraries; `submit`: upload, queue, cancel; `admin`: all jobs, templates and keys."""

TOKEN_BYTES = 32
"""Random bytes of a token: beyond any guessing, so that a plain hash of it is safe to keep."""

QUOTA = 100
"""Jobs that a new key may have queued or running; a studio's day, and less than what hides the jobs of others
for hours."""


class KeyMissing(GarmentqError):
    """This service asks for a key; send `Authorization: Bearer TOKEN`, or set GARMENTQ_API_KEY."""

    code = "key.missing"


class KeyBad(GarmentqError):
    """The key is not known or was revoked; ask for a new one (`garmentq keys create`)."""

    code = "key.bad"


class ScopeMissing(GarmentqError):
    """The key may not do this; ask for one with a wider scope (`garmentq keys create --scope`)."""

    code = "key.scope_missing"


class QueueFull(GarmentqError):
    """The key has as many jobs queued or running as it may; wait until some have run, or cancel them."""

    code = "key.queue_full"


class KeyUnknown(NotFound):
    """There is no such key; `garmentq keys list` shows them."""

    code = "key.unknown"


class KeySpecBad(BadInput):
    """A key needs a name of at most 255 letters, scopes among read, submit and admin, and a quota from 1 to 1000000."""

    code = "key.spec_bad"


@dataclass(frozen=True)
class Caller:
    """Describe who asks.

    Attributes:
        key: The key's id; empty for the local user of a service without keys.
        scopes: What is allowed, of `SCOPES`.
        quota: Jobs that may be queued or running at a time; 0: any number.
    """

    key: str
    scopes: tuple[str, ...]
    quota: int

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


LOCAL = Caller("", SCOPES, 0)
"""The user of a service that listens on this machine only and has no keys."""


def create_key(database: Database, name: str, scopes: tuple[str, ...], quota: int = QUOTA) -> tuple[ApiKeyRow, str]:
    """Make a key; its token is given here and never again.

    Raises:
        KeySpecBad: where name, scopes or quota cannot be used.
    """
    is_named = 0 < len(name) <= 255 and name.isprintable()
    if not is_named or not scopes or not set(scopes) <= set(SCOPES) or not 1 <= quota <= 1_000_000:
        raise KeySpecBad()
    token = "gq_" + secrets.token_hex(TOKEN_BYTES)
    row = ApiKeyRow(
        id=secrets.token_hex(6),
        name=name,
        hash=_hash(token),
        scopes=sorted(set(scopes)),
        quota=quota,
        created=clock(),
        revoked=None,
    )
    with database.write() as session:
        session.add(row)
        session.flush()
        session.refresh(row)
    return row, token


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


def admit(database: Database, token: str | None, is_open: bool) -> Caller:
    """Authenticate a token. Without one, return the local user if the service is open and has no keys.

    Raises:
        KeyMissing, KeyBad: where nobody of that token is known.
    """
    if not token:
        if is_open and not has_keys(database):
            return LOCAL
        raise KeyMissing()
    wanted = _hash(token)
    with database.read() as session:
        row = session.scalars(select(ApiKeyRow).where(ApiKeyRow.hash == wanted)).one_or_none()
    if row is None or row.revoked is not None or not hmac.compare_digest(row.hash, wanted):
        raise KeyBad()
    return Caller(row.id, tuple(row.scopes), row.quota)


def own(session: Session, key: str, job: str) -> None:
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


def _hash(token: str) -> str:
    return hashlib.sha256(token.encode("utf-8", "surrogatepass")).hexdigest()
