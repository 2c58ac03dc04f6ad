"""Files that clients upload before they create a job with them."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

from sqlalchemy import func, select
from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session

from ..core.run.errors import BadInput, GarmentqError, NotFound
from .database import Database, clock
from .keys import lock_key
from .models import IdempotencyRow, UploadRow
from .store import Store, StoredFile

DAY_SECONDS = 86400.0
"""Period over which uploads are summed [s]."""


class UploadUnknown(NotFound):
    """This key has not uploaded such a file; upload it first."""

    code = "upload.unknown"


class DayFull(GarmentqError):
    """The key has reached its number of uploaded bytes in 24 hours; wait until the first are a day old."""

    code = "key.day_bytes"

    def __init__(self, message: str, seconds: float) -> None:
        """Refuse for some seconds."""
        super().__init__(message)
        self.retry_seconds = max(1.0, seconds)


class DayFilesFull(DayFull):
    """The key has reached its number of uploaded files in 24 hours; wait until the first are a day old."""

    code = "key.day_files"


class UploadsFull(BadInput):
    """The key has reached its number of stored uploads; delete some (`DELETE /v1/scans/SHA256`)."""

    code = "key.uploads_full"


@dataclass(frozen=True)
class UploadBounds:
    """Describe what a key may upload.

    Attributes:
        day_bytes: Bytes in 24 hours.
        day_files: Files in 24 hours.
        files: Files in all.
    """

    day_bytes: int
    day_files: int
    files: int


class IdempotencyMismatch(BadInput):
    """The Idempotency-Key was used for another request; send a new one."""

    code = "request.idempotency_mismatch"


def keep_upload(
    database: Database,
    store: Store,
    key: str,
    path: Path,
    name_and_kind: tuple[str, str],
    bounds: UploadBounds | None = None,
) -> StoredFile:
    """Store an uploaded file, and that this key may use it as its kind; a new name replaces an older one.

    Args:
        database: The database for the row.
        store: The store for the file.
        key: Id of the API key, or empty.
        path: The file.
        name_and_kind: Its name, and its kind, `scans` for example.
        bounds: What the key may upload; None: unlimited.

    Raises:
        DayFull, DayFilesFull, UploadsFull: if the file would exceed them.
    """
    kept = store.put(path)
    with database.write() as session:
        if bounds is not None:
            lock_key(session, key)
            _check_bounds(session, key, kept.size, bounds, kept.sha256)
        known = session.get(UploadRow, (key, kept.sha256))
        kinds = sorted({name_and_kind[1], *(known.kinds if known is not None else ())})
        row = UploadRow(key=key, sha256=kept.sha256, name=_printable(name_and_kind[0]), size=kept.size, kinds=kinds)
        row.created = clock()
        session.merge(row)
    return kept


def check_bounds(database: Database, key: str, size: int, bounds: UploadBounds | None) -> None:
    """Check whether a key may upload a file of a size [bytes] before it is sent; the same file again does not count.

    Raises:
        DayFull, DayFilesFull, UploadsFull: if it may not.
    """
    if bounds is not None:
        with database.read() as session:
            _check_bounds(session, key, size, bounds)


def _printable(name: str) -> str:
    """Return a file's name without folders and unprintable characters; it is cleaned further when used as a path."""
    return "".join(filter(str.isprintable, Path(name).name))[-255:]


def _check_bounds(session: Session, key: str, size: int, bounds: UploadBounds, sha256: str = "") -> None:
    """Sum what the key uploaded within a day; a file uploaded again counts once, by its latest time."""
    others = (UploadRow.key == key) & (UploadRow.sha256 != sha256)
    latest = others & (UploadRow.created > clock() - DAY_SECONDS)
    sums = (func.coalesce(func.sum(UploadRow.size), 0), func.count(), clock() - func.min(UploadRow.created))
    used, count, age = session.execute(select(*sums).where(latest)).one()
    left = DAY_SECONDS - float(age or 0.0)
    if used + max(size, 1) > bounds.day_bytes:
        most = bounds.day_bytes
        raise DayFull(f"the key uploaded {used} of {most} bytes a day; wait until the first are a day old.", left)
    if count >= bounds.day_files:
        raise DayFilesFull(f"the key uploaded {count} files in a day; wait until the first are a day old.", left)
    if (session.scalar(select(func.count()).select_from(UploadRow).where(others)) or 0) >= bounds.files:
        raise UploadsFull(f"the key has {bounds.files} uploads, its limit; delete some.")


def find_upload(database: Database, key: str, sha256: str, kind: str | None = None) -> UploadRow:
    """Return an upload of a key; with `kind` only one of that kind.

    Raises:
        UploadUnknown: if this key did not upload it, or as another kind.
    """
    with database.read() as session:
        row = session.get(UploadRow, (key, sha256))
    if row is None:
        raise UploadUnknown(f"no file {sha256[:12]} was uploaded with this key; upload it first.")
    if kind is not None and row.kinds and kind not in row.kinds:  # uploads of earlier versions have no kind
        was = ", ".join(row.kinds)
        raise UploadUnknown(f"file {sha256[:12]} was uploaded to /v1/{was}; upload it to /v1/{kind} too.")
    return row


def begin_idempotent(database: Database, key: str, token: str, request: str) -> str | None:
    """Record the request of an Idempotency-Key.

    Returns:
        The job that it created before, or None.

    Raises:
        IdempotencyMismatch: if it was used for another request.
    """
    fingerprint = hashlib.sha256(request.encode()).hexdigest()
    with database.write() as session:
        try:
            with session.begin_nested():
                session.add(IdempotencyRow(key=key, token=token, fingerprint=fingerprint, job=None, created=clock()))
            return None
        except IntegrityError:
            condition = (IdempotencyRow.key == key) & (IdempotencyRow.token == token)
            row = session.scalars(select(IdempotencyRow).where(condition)).one()
    if row.fingerprint != fingerprint:
        raise IdempotencyMismatch()
    return row.job


def end_idempotent(database: Database, key: str, token: str, job: str) -> None:
    """Record the job that an Idempotency-Key created."""
    with database.write() as session:
        row = session.get(IdempotencyRow, (key, token))
        if row is not None:
            row.job = job
