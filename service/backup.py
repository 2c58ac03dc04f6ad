"""Save and restore a home or a service: one tar file with a snapshot of the database and every file that it names.

The snapshot is an SQLite file, of a server's database too, so that a backup of either can be restored into either.
"""

from __future__ import annotations

import io
import json
import os
import shutil
import sqlite3
import tarfile
import tempfile
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from sqlalchemy.engine import make_url

from .. import __version__
from ..core.run.errors import BadInput
from .copy_rows import dump_rows, load_rows
from .damage import DamagedRow
from .database import Database, open_database, translate_driver_errors, upgrade
from .garbage import find_all_references
from .home import lock_home, restrict_permissions
from .private import PRIVATE_FILE_MODE, make_private
from .query import count_states
from .reaper import list_workers
from .settings import ServiceSettings
from .store import ArtifactDamaged, ArtifactMissing, Store
from .stores import open_store

DATABASE = "garmentq.db"
BLOBS = "store/"
ABOUT = "about.json"

HAS_FILES = "has_files"
"""Field of `about.json` that says whether the stored files are in the backup; an older backup has them."""

MAX_ABOUT_SIZE = 256 << 20
"""Largest `about.json` that is read [bytes]: it names missing files, 67 bytes each."""


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
        files: Number of stored files in it; of a backup without files, of those that the store has.
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


def make_backup(
    settings: ServiceSettings,
    destination: Path,
    is_overwrite: bool = False,
    has_files: bool = True,
    keep: Callable[[Path], None] | None = None,
) -> BackupContents:
    """Write a backup while the services run.

    The database is copied first, in one transaction; then the files that the copy names. Files never change, and `gc`
    deletes one only a day after the last reference to it, so all of them still exist.

    Args:
        settings: Settings of the home.
        destination: The tar file.
        is_overwrite: Replace the file if it exists.
        has_files: Copy the stored files, too; otherwise the backup only names them.
        keep: Called with the copy of the database, an SQLite file, to delete from it what is not saved.

    Raises:
        BackupRefused: if there is no database, or the file exists.
    """
    source = None if settings.is_database_server else _find_database(settings)
    if source is not None and not source.is_file():
        raise BackupRefused(f"there is no database {source}; there is nothing to save.")
    if destination.exists() and not is_overwrite:
        raise BackupRefused(f"{destination} exists; name another file, or add --overwrite.")
    make_private(destination.parent)
    descriptor, partial = tempfile.mkstemp(prefix=f".{destination.name}.", dir=destination.parent)
    try:
        with os.fdopen(descriptor, "wb") as stream:
            saved = _write(settings, (source, destination), stream, has_files, keep)
            stream.flush()
            os.fsync(stream.fileno())
        os.replace(partial, destination)
    except BaseException:
        os.unlink(partial)
        raise
    return saved


def read_backup(source: Path) -> BackupContents:
    """Read a backup to its end, and check each file against its hash; nothing is kept of it.

    Raises:
        BackupDamaged: if a file is missing, changed, or does not belong in a backup.
    """
    with tempfile.TemporaryDirectory(prefix=".read-", dir=source.parent) as folder:
        snapshot = Path(folder) / DATABASE
        with _open_tar(source) as archive:
            members = _read_members(archive, Store(Path(folder) / "store"), snapshot)
        named, rows = _check_snapshot(snapshot)
    return BackupContents(
        source, len(named & members.files), members.size, tuple(sorted(named - members.files)), rows=rows
    )


def restore_backup(settings: ServiceSettings, source: Path, is_overwrite: bool = False) -> BackupContents:
    """Restore a backup: files first, each checked against its hash, then the database in one step.

    The next worker requeues the jobs that ran when the backup was made, as after a crash.

    Raises:
        BackupRefused: if the database has jobs and `is_overwrite` is False, or a worker, or the API of this machine,
            has it open: they would continue with what is replaced.
        BackupDamaged: if a file is missing, changed, or does not belong in a backup; the database is then not changed.
    """
    if settings.is_database_server:
        return _restore_server(settings, source, is_overwrite)
    target = _find_database(settings)
    if target.exists() and not is_overwrite:
        raise BackupRefused(f"{target} exists; restore into another --home, or add --overwrite to lose what is there.")
    make_private(target.parent)
    store = open_store(settings)
    with _hold_home_exclusively(settings), tempfile.TemporaryDirectory(prefix=".restore-", dir=target.parent) as folder:
        snapshot = Path(folder) / DATABASE
        with _open_tar(source) as archive:
            members = _read_members(archive, store, snapshot)
        named, rows = _check_snapshot(snapshot)
        for ending in ("-wal", "-shm"):
            target.with_name(target.name + ending).unlink(missing_ok=True)
        snapshot.chmod(PRIVATE_FILE_MODE)
        os.replace(snapshot, target)
    restrict_permissions(settings)
    return _describe(settings, store, members, named, rows)


def _restore_server(settings: ServiceSettings, source: Path, is_overwrite: bool) -> BackupContents:
    database = open_database(settings, pooled=False, is_upgraded=True)
    try:
        if list_workers(database):
            raise BackupRefused("workers are alive; stop them and the API, then restore.")
        if count_states(database) and not is_overwrite:
            raise BackupRefused("the database has jobs; restore into an empty one, or add --overwrite to lose them.")
        store, folder = open_store(settings), make_private(settings.home)
        store.prepare()
        with _hold_home_exclusively(settings), tempfile.TemporaryDirectory(prefix=".restore-", dir=folder) as made:
            snapshot = Path(made) / DATABASE
            with _open_tar(source) as archive:
                members = _read_members(archive, store, snapshot)
            named, rows = _check_snapshot(snapshot)
            load_rows(snapshot, database)
    finally:
        database.dispose()
    return _describe(settings, store, members, named, rows)


def _describe(
    settings: ServiceSettings, store: Store, members: Members, named: set[str], rows: tuple[DamagedRow, ...]
) -> BackupContents:
    """Return what was restored; the files of a backup that only names them are looked up in the store."""
    kept, size = members.files, members.size
    if not members.has_files:
        sizes = dict(_find_sizes(store, named))
        kept, size = set(sizes), sum(sizes.values())
    return BackupContents(settings.home, len(named & kept), size, tuple(sorted(named - kept)), rows=rows)


def _find_sizes(store: Store, named: set[str]) -> Iterator[tuple[str, int]]:
    for key in named:
        with suppress(ArtifactMissing):
            yield key, store.size(key)


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


def _copy_database(settings: ServiceSettings, source: Path | None, snapshot: Path) -> None:
    """Copy the database as it is now into an SQLite file: by SQLite's own backup, or row by row from a server's."""
    if source is None:
        database = open_database(settings, pooled=False)
        try:
            dump_rows(database, snapshot)
        finally:
            database.dispose()
        return
    opened = closing(sqlite3.connect(source)), closing(sqlite3.connect(snapshot))
    with translate_driver_errors(settings.database), opened[0] as live, opened[1] as copy:
        live.backup(copy)


def _write(
    settings: ServiceSettings,
    places: tuple[Path | None, Path],
    stream: IO[bytes],
    has_files: bool,
    keep: Callable[[Path], None] | None,
) -> BackupContents:
    """Write the members of a backup; `places` are the database's file, if it has one, and the backup."""
    store, (source, destination) = open_store(settings), places
    missing, damaged = list[str](), list[str]()
    count = size = 0
    with tempfile.TemporaryDirectory(dir=destination.parent) as folder, tarfile.open(fileobj=stream, mode="w") as tar:
        snapshot = Path(folder) / DATABASE
        _copy_database(settings, source, snapshot)
        if keep is not None:
            keep(snapshot)
        with closing(sqlite3.connect(snapshot)) as copy:
            copy.execute("pragma journal_mode = delete")  # one file, no log beside it
        tar.add(snapshot, DATABASE, recursive=False)
        named, rows = _references(snapshot)
        for key in sorted(named) if has_files else ():
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
        contents = {"garmentq": __version__, "files": count, "missing": missing + damaged, HAS_FILES: has_files}
        about = json.dumps(contents).encode()
        member = tarfile.TarInfo(ABOUT)
        member.size = len(about)
        tar.addfile(member, io.BytesIO(about))  # last: an incomplete backup has none
    return BackupContents(destination, count, size, tuple(missing), tuple(damaged), rows)


@dataclass(frozen=True)
class Members:
    """Describe the members of a backup: its stored files, their size [bytes], and whether it has any at all."""

    files: set[str]
    size: int
    has_files: bool


def _read_members(archive: tarfile.TarFile, store: Store, snapshot: Path) -> Members:
    """Read the members of a backup; a name only says which stored file a member is, and is never used as a path."""
    kept: set[str] = set()
    size = 0
    about: dict[str, object] | None = None
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
            about = _read_about(stream)
        else:
            raise BackupDamaged(f"'{member.name[:80]}' does not belong in a backup of garmentq.")
    if about is None or not snapshot.exists():
        raise BackupDamaged("the backup ends too early; use another one.")
    return Members(kept, size, about.get(HAS_FILES) is not False)


def _read_about(stream: IO[bytes]) -> dict[str, object]:
    try:
        about = json.loads(stream.read(MAX_ABOUT_SIZE))
    except ValueError:
        about = None
    if not isinstance(about, dict):
        raise BackupDamaged(f"'{ABOUT}' cannot be read; use another backup.")
    return about


def _check_snapshot(snapshot: Path) -> tuple[set[str], tuple[DamagedRow, ...]]:
    """Return the files that a snapshot names, and its damaged rows.

    Raises:
        BackupDamaged: if it is no sound database.
    """
    try:
        with closing(sqlite3.connect(snapshot)) as copy:
            sound = copy.execute("pragma integrity_check").fetchone()[0]
            if sound != "ok":
                raise BackupDamaged(f"the backup's database is damaged: {sound[:100]}.")
        return _references(snapshot)
    except sqlite3.DatabaseError as error:
        raise BackupDamaged(f"the backup's database cannot be read: {error}.") from error


def _references(snapshot: Path) -> tuple[set[str], tuple[DamagedRow, ...]]:
    """Return the files that a snapshot names, and its damaged rows.

    A copy is read, with the tables of this version, because an earlier one may have written the snapshot.

    Raises:
        DatabaseTooNew: if a newer version wrote it.
    """
    with tempfile.TemporaryDirectory(dir=snapshot.parent) as folder:
        opened = Database(f"sqlite:///{shutil.copy(snapshot, folder)}", pooled=False)
        try:
            upgrade(opened)
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
        raise BackupRefused("GARMENTQ_DATABASE_URL names no file; write sqlite:////PATH, or a server's address.")
    return Path(parsed.database)
