"""Delete the stored files that no row names: remains of crashes, and replaced checkpoints."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from contextlib import suppress
from dataclasses import dataclass
from time import time
from typing import Any

from sqlalchemy import exists, select
from sqlalchemy.orm import Session

from .columns import RowDamaged, is_sound
from .damage import DamagedRow, read_damaged_references
from .database import Database
from .model_base import Base
from .models import JobRow
from .named_files import HASH
from .store import ArtifactMissing, Store, StoreEntry

FOUND = re.compile(HASH.pattern.encode())
"""The same pattern for the bytes of a damaged request."""

KEYS_AT_ONCE = 500
"""Number of keys of one query; SQLite binds 32 766 values."""

GARBAGE_GRACE_HOURS = 24.0
"""Least age of a file that may be deleted [h]: a worker stores its files some seconds before a row names them, and an
upload is named by the request that follows it. A day is longer than any job."""


@dataclass(frozen=True)
class Garbage:
    """Describe the files that no row names.

    Attributes:
        files: The stored files, oldest first.
        removed: How many of them were deleted.
        kept_bytes: Size of all other files in the store [bytes].
        damaged: Rows that cannot be read and may name any file; if there are some, nothing is deleted.
    """

    files: tuple[StoreEntry, ...]
    removed: int
    kept_bytes: int
    damaged: tuple[DamagedRow, ...] = ()

    @property
    def size(self) -> int:
        """Return the size of all files that no row names [bytes]."""
        return sum(one.size for one in self.files)


def collect_garbage(
    database: Database, store: Store, grace_seconds: float, is_delete: bool, now: float | None = None
) -> Garbage:
    """List the stored files that no row names and that are older than the grace time.

    The store is listed before the database is read: a file named in between is kept, and a file stored later is too
    young. Each file's age is checked again when it is deleted (`Store.remove`).

    Args:
        database: The database whose rows name the files.
        store: The store; no other database may use it.
        grace_seconds: Age below which a file is never deleted [s].
        is_delete: Delete them; otherwise they are only listed.
        now: Seconds since 1970; None: now, by this machine's clock.
    """
    before = (time() if now is None else now) - grace_seconds
    listed = list(store.list_files())
    named, damaged = find_all_references(database)
    files = sorted((one for one in listed if one.sha256 not in named and one.modified < before), key=_age)
    removed = sum(_remove(store, one, before) for one in files) if is_delete and not damaged else 0
    kept = sum(one.size for one in listed) - sum(one.size for one in files)
    return Garbage(tuple(files), removed, kept, damaged)


def find_all_references(database: Database) -> tuple[set[str], tuple[DamagedRow, ...]]:
    """Return every key that a row names, and the damaged rows, which may name more keys than are legible in them."""
    with suppress(RowDamaged), database.read() as session:
        if not session.scalar(select(exists().where(~is_sound(JobRow.request)))):
            return set(find_references(session)), ()
    with database.intact.read() as session:
        left = {key.decode() for remains in read_damaged_references(session) for key in FOUND.findall(remains)}
        return left.union(find_references(session)), tuple(database.find_damaged())


def find_references(session: Session) -> Iterator[str]:
    """Yield every key that a row names: each column `sha256` of any table, scans of jobs, the files of requests.

    Each column is read from its index; `job_files` names the files of requests, which are not read themselves.
    """
    for column in _list_columns():
        yield from session.scalars(select(column).distinct())


def find_named(session: Session, files: Collection[str]) -> set[str]:
    """Return those of some keys that a row names; each is looked up by an index."""
    found: set[str] = set()
    left = sorted(files)
    for start in range(0, len(left), KEYS_AT_ONCE):
        keys = left[start : start + KEYS_AT_ONCE]
        for column in _list_columns():
            found.update(session.scalars(select(column).where(column.in_(keys))))
    return found


def _list_columns() -> list[Any]:
    """Return the columns that name stored files."""
    tables = [mapper for mapper in Base.registry.mappers if "sha256" in mapper.columns]
    return [JobRow.scan, *(mapper.class_.sha256 for mapper in tables)]


def _age(one: StoreEntry) -> tuple[float, str]:
    return one.modified, one.sha256


def _remove(store: Store, one: StoreEntry, before: float) -> bool:
    try:
        return store.remove(one.sha256, before)
    except ArtifactMissing:
        return False  # another collector has deleted it
