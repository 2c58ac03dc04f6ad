"""Start of a long-running process on a home: private files, and a lock that excludes a restore."""

from __future__ import annotations

import os
import shutil
from contextlib import suppress
from time import time

from ..core.run.errors import GarmentqError
from .lock import share_lock, take_lock
from .private import PRIVATE_UMASK, make_private_all
from .settings import ServiceSettings

IN_USE = "home.lock"
"""Lock file of a home: shared by its workers and its API, exclusive to a restore."""


PARTS = ("store", "incoming", "work", "run", "cache", "broker", "results", "api.token")
"""Contents of a home beside its database, logs and locks; other files in it may be a user's and are not changed."""

ENDINGS = (".db", ".db-wal", ".db-shm", ".log", ".log.1", ".log.2", ".log.3", ".lock", ".alive")
"""Endings of the names of databases, logs, locks and heartbeats."""

LEFT_SECONDS = 86400.0
"""Age after which the remains of a killed process are deleted [s]; no upload and no job takes so long."""


class HomeBusy(GarmentqError):
    """The home is being restored; start this once that is done."""

    code = "service.home_busy"


def use_home(settings: ServiceSettings) -> int:
    """Set a private umask, and exclude a restore while this process lives.

    Other users of this machine must not read scans of bodies, names and hashes of keys.

    Returns:
        The descriptor of the lock, to be closed at the end.

    Raises:
        HomeBusy: if a restore is running.
    """
    os.umask(PRIVATE_UMASK)
    lock = share_lock(settings.home / IN_USE)
    if lock is None:
        raise HomeBusy()
    remove_leftovers(settings)
    return lock


def restrict_permissions(settings: ServiceSettings) -> None:
    """Remove all other users' permissions on a home and its store: earlier versions made some files readable."""
    if settings.home.is_dir():
        settings.home.chmod(settings.home.stat().st_mode & 0o777 & ~PRIVATE_UMASK)
        for path in settings.home.iterdir():
            if path.name in PARTS or path.name.endswith(ENDINGS):
                make_private_all(path)
    if not settings.is_store_remote and settings.store_path.is_dir():
        make_private_all(settings.store_path)


def remove_leftovers(settings: ServiceSettings, now: float | None = None) -> int:
    """Delete unfinished transfers and folders of killed jobs once they are a day old.

    Args:
        settings: Settings of the home.
        now: Seconds since 1970; None: now, by this machine's clock.

    Returns:
        How many files and folders were deleted.
    """
    count, before = 0, (time() if now is None else now) - LEFT_SECONDS
    folders = [settings.home / "incoming", settings.home / "work"]
    folders += [] if settings.is_store_remote else [settings.store_path / "incoming"]
    for folder in folders:
        for left in folder.iterdir() if folder.is_dir() else ():
            with suppress(OSError):
                if left.lstat().st_mtime < before:
                    if left.is_dir() and not left.is_symlink():
                        shutil.rmtree(left)
                    else:
                        left.unlink()
                    count += 1
    return count


def lock_home(settings: ServiceSettings) -> int | None:
    """Take the home's exclusive lock; return None if a worker or the API of this machine has the home open."""
    return take_lock(settings.home / IN_USE)
