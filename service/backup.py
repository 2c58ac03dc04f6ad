"""Save and restore an embedded home: one tar file with a snapshot of the database and every file that it names."""

from __future__ import annotations

import io
import json
import os
import sqlite3
import tarfile
import tempfile
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from sqlalchemy.engine import make_url

from .. import __version__
from ..core.run.errors import BadInput
from .damage import DamagedRow
from .database import Database, translate_driver_errors
from .garbage import find_all_references
from .home import lock_home, restrict_permissions
from .private import PRIVATE_FILE_MODE, make_private
from .settings import ServiceSettings
from .store import ArtifactDamaged, ArtifactMissing, Store
from .stores import open_store

DATABASE = "garmentq.db"
BLOBS = "store/"
ABOUT = "about.json"


class BackupRefused(BadInput):
    """This home cannot be saved or restored here; the message says why and what to do."""

    code = "backup.refused"


class BackupDamaged(BadInput):
    """The file is not a complete backup of garmentq; use another one."""

    code = "backup.damaged"


@dataclass(frozen=True)
class BackupContents:
    """Describe the contents of a backup.

    Attributes:
        path: The tar file, or the home that was restored.
        files: Number of stored files in it.
        size: Their size [bytes].
        missing: Files that the database names and the store has lost; the backup is valid without them.
        damaged: Files whose bytes changed in the store; they are left out like missing ones.
        rows: Rows of the database that cannot be read; they are kept unchanged, with the files that they still name.
    """

    path: Path
    files: int
    size: int
    missing: tuple[str, ...] = ()
    damaged: tuple[str, ...] = ()
    rows: tuple[DamagedRow, ...] = ()


def make_backup(settings: ServiceSettings, destination: Path, is_overwrite: bool = False) -> BackupContents:
    """Write a backup while the services run.

    The database is copied first, by SQLite's own backup, which is a snapshot; then the files that the snapshot names.
    Files never change, and `gc` deletes one only a day after the last reference to it, so all of them still exist.

    Raises:
        BackupRefused: if the home has no embedded database, or the file exists.
    """
    source = _find_database(settings)
    if not source.is_file():
        raise BackupRefused(f"there is no database {source}; there is nothing to save.")
    if destination.exists() and not is_overwrite:
        raise BackupRefused(f"{destination} exists; name another file, or add --overwrite.")
    make_private(destination.parent)
    descriptor, partial = tempfile.mkstemp(prefix=f".{destination.name}.", dir=destination.parent)
    try:
        with os.fdopen(descriptor, "wb") as stream:
            saved = _write(settings, source, stream, destination)
            stream.flush()
            os.fsync(stream.fileno())
        os.replace(partial, destination)
    except BaseException:
        os.unlink(partial)
        raise
    return saved


def restore_backup(settings: ServiceSettings, source: Path, is_overwrite: bool = False) -> BackupContents:
    """Restore a backup into a home: files first, each checked against its hash, then the database in one step.

    The next worker requeues the jobs that ran when the backup was made, as after a crash.

    Raises:
        BackupRefused: if the home has a database and `is_overwrite` is False, or a worker or the API has it open: they
            would continue with the replaced file.
        BackupDamaged: if a file is missing, changed, or does not belong in a backup; the database is then not changed.
    """
    target = _find_database(settings)
    if target.exists() and not is_overwrite:
        raise BackupRefused(f"{target} exists; restore into another --home, or add --overwrite to lose what is there.")
    make_private(target.parent)
    store = open_store(settings)
    with _hold_home_exclusively(settings), tempfile.TemporaryDirectory(prefix=".restore-", dir=target.parent) as folder:
        snapshot = Path(folder) / DATABASE
        with _open_tar(source) as archive:
            kept, size = _read_members(archive, store, snapshot)
        named, missing, rows = _check_snapshot(snapshot, kept)
        for ending in ("-wal", "-shm"):
            target.with_name(target.name + ending).unlink(missing_ok=True)
        snapshot.chmod(PRIVATE_FILE_MODE)
        os.replace(snapshot, target)
    restrict_permissions(settings)
    return BackupContents(settings.home, len(named & kept), size, missing, rows=rows)


@contextmanager
def _hold_home_exclusively(settings: ServiceSettings) -> Iterator[None]:
    """Lock the home for the block, so that no worker and no API of this machine opens it."""
    lock = lock_home(settings)
    if lock is None:
        raise BackupRefused("a worker or the API has this home open; `garmentq down`, and stop `garmentq serve`.")
    try:
        yield
    finally:
        os.close(lock)


def _write(settings: ServiceSettings, source: Path, stream: IO[bytes], destination: Path) -> BackupContents:
    store = open_store(settings)
    missing, damaged = list[str](), list[str]()
    count = size = 0
    with tempfile.TemporaryDirectory(dir=destination.parent) as folder, tarfile.open(fileobj=stream, mode="w") as tar:
        snapshot = Path(folder) / DATABASE
        opened = closing(sqlite3.connect(source)), closing(sqlite3.connect(snapshot))
        with translate_driver_errors(settings.database), opened[0] as live, opened[1] as copy:
            live.backup(copy)
            copy.execute("pragma journal_mode = delete")  # one file, no log beside it
        tar.add(snapshot, DATABASE, recursive=False)
        named, rows = _references(snapshot)
        for key in sorted(named):
            try:
                file = store.copy(key, Path(folder) / "blob")
            except ArtifactMissing:
                missing.append(key)
                continue
            except ArtifactDamaged:
                damaged.append(key)
                continue
            tar.add(file, BLOBS + key, recursive=False)
            count, size = count + 1, size + file.stat().st_size
        about = json.dumps({"garmentq": __version__, "files": count, "missing": missing + damaged}).encode()
        member = tarfile.TarInfo(ABOUT)
        member.size = len(about)
        tar.addfile(member, io.BytesIO(about))  # last: an incomplete backup has none
    return BackupContents(destination, count, size, tuple(missing), tuple(damaged), rows)


def _read_members(archive: tarfile.TarFile, store: Store, snapshot: Path) -> tuple[set[str], int]:
    """Read the members of a backup; a name only says which stored file a member is, and is never used as a path."""
    kept: set[str] = set()
    size = 0
    is_complete = False
    for member in archive:
        stream = archive.extractfile(member) if member.isreg() else None
        if stream is None:
            raise BackupDamaged(f"'{member.name[:80]}' is not a plain file; this is not a backup of garmentq.")
        if member.name == DATABASE:
            with snapshot.open("wb") as out:
                while block := stream.read(1 << 20):
                    out.write(block)
        elif member.name.startswith(BLOBS):
            stored = store.put_stream(stream)  # type: ignore[arg-type]
            if BLOBS + stored.sha256 != member.name:
                raise BackupDamaged(f"'{member.name[:80]}' has changed since it was saved; use another backup.")
            kept.add(stored.sha256)
            size += stored.size
        elif member.name == ABOUT:
            is_complete = True
        else:
            raise BackupDamaged(f"'{member.name[:80]}' does not belong in a backup of garmentq.")
    if not is_complete or not snapshot.exists():
        raise BackupDamaged("the backup ends too early; use another one.")
    return kept, size


def _check_snapshot(snapshot: Path, kept: set[str]) -> tuple[set[str], tuple[str, ...], tuple[DamagedRow, ...]]:
    try:
        with closing(sqlite3.connect(snapshot)) as copy:
            sound = copy.execute("pragma integrity_check").fetchone()[0]
            if sound != "ok":
                raise BackupDamaged(f"the backup's database is damaged: {sound[:100]}.")
        named, rows = _references(snapshot)
    except sqlite3.DatabaseError as error:
        raise BackupDamaged(f"the backup's database cannot be read: {error}.") from error
    return named, tuple(sorted(named - kept)), rows


def _references(snapshot: Path) -> tuple[set[str], tuple[DamagedRow, ...]]:
    """Return the files that a snapshot names, and its damaged rows."""
    opened = Database(f"sqlite:///{snapshot}", pooled=False)
    try:
        return find_all_references(opened)[0], tuple(opened.find_damaged())
    finally:
        opened.dispose()


@contextmanager
def _open_tar(source: Path) -> Iterator[tarfile.TarFile]:
    try:
        with tarfile.open(source, "r:") as archive:
            yield archive
    except FileNotFoundError:
        raise BackupDamaged(f"there is no file '{source}'.") from None
    except (tarfile.TarError, IsADirectoryError, EOFError) as error:
        raise BackupDamaged(f"'{source}' is not a backup of garmentq: {error}.") from error


def _find_database(settings: ServiceSettings) -> Path:
    parsed = make_url(settings.database)
    if parsed.get_backend_name() != "sqlite" or not parsed.database:
        raise BackupRefused(
            "the database is a server's; save it by pg_dump, the bucket by its own tools (docs/howto/run-a-fleet.md)."
        )
    return Path(parsed.database)
