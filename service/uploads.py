"""Files that clients handed in before they ask for a job with them."""

from __future__ import annotations

import hashlib
from pathlib import Path

from sqlalchemy import select
from sqlalchemy.exc import IntegrityError

from ..core.errors import BadInput, NotFound
from .database import Database, clock
from .models import IdempotencyRow, UploadRow
from .store import Store, Stored
from .submission import clean_name


class UploadUnknown(NotFound):
    """No such file was uploaded with this key; upload it first."""

    code = "upload.unknown"


class IdempotencyMismatch(BadInput):
    """The Idempotency-Key was used for another request; send a new one."""

    code = "request.idempotency_mismatch"


def keep_upload(database: Database, store: Store, key: str, path: Path, name: str) -> Stored:
    """Keep an uploaded file, and that this key may use it; the newest name counts."""
    kept = store.put(path)
    row = UploadRow(key=key, sha256=kept.sha256, name=clean_name(name), size=kept.size, created=clock())
    with database.write() as session:
        session.merge(row)
    return kept


def find_upload(database: Database, key: str, sha256: str) -> UploadRow:
    """Give an upload of a key.

    Raises:
        UploadUnknown: where this key did not upload it.
    """
    with database.read() as session:
        row = session.get(UploadRow, (key, sha256))
    if row is None:
        raise UploadUnknown(f"no file {sha256[:12]} was uploaded with this key; upload it first.")
    return row


def begin_once(database: Database, key: str, token: str, request: str) -> str | None:
    """Note what an Idempotency-Key is used for.

    Returns:
        The job that it made before, or None.

    Raises:
        IdempotencyMismatch: where it was used for another request.
    """
    fingerprint = hashlib.sha256(request.encode()).hexdigest()
    with database.write() as session:
        try:
            with session.begin_nested():
                session.add(IdempotencyRow(key=key, token=token, fingerprint=fingerprint, job=None, created=clock()))
            return None
        except IntegrityError:
            wanted = (IdempotencyRow.key == key) & (IdempotencyRow.token == token)
            row = session.scalars(select(IdempotencyRow).where(wanted)).one()
    if row.fingerprint != fingerprint:
        raise IdempotencyMismatch()
    return row.job


def end_once(database: Database, key: str, token: str, job: str) -> None:
    """Note the job that an Idempotency-Key made."""
    with database.write() as session:
        row = session.get(IdempotencyRow, (key, token))
        if row is not None:
            row.job = job
