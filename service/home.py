"""What a process does before it works on a home for long: private files, and a lock that keeps a restore out."""

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
"""File of a home that its workers and its API hold together, and that a restore holds alone."""


PARTS = ("store", "incoming", "work", "run", "cache", "broker", "results", "api.token")
"""What a home holds beside its database, logs and locks; results of commands may lie there, too, and are the user's."""

ENDINGS = (".db", ".db-wal", ".db-shm", ".log", ".lock")
"""How the names of databases, logs and locks end."""

LEFT_SECONDS = 86400.0
"""Age of what a killed process left behind [s]; no upload and no job takes so long."""


class HomeBusy(GarmentqError):
    """The home is being restored; start this once that is done."""

    code = "service.home_busy"


def use_home(settings: ServiceSettings) -> int:
    """Write only files of one user from here on, and keep a restore out for as long as this process lives.

    Scans of bodies, names and hashes of keys are nobody else's on this machine.

    Returns:
        The descriptor of the lock, to be closed at the end.

    Raises:
        HomeBusy: where a restore goes on.
    """
    os.umask(PRIVATE_UMASK)
    lock = share_lock(settings.home / IN_USE)
    if lock is None:
        raise HomeBusy()
    remove_leftovers(settings)
    return lock


def restrict_permissions(settings: ServiceSettings) -> None:
    """Take a home, and a store beside it, from all other users of the machine: earlier versions made some readable."""
    if settings.home.is_dir():
        settings.home.chmod(settings.home.stat().st_mode & 0o777 & ~PRIVATE_UMASK)
        for path in settings.home.iterdir():
            if path.name in PARTS or path.name.endswith(ENDINGS):
                make_private_all(path)
    if not settings.is_store_remote and settings.store_path.is_dir():
        make_private_all(settings.store_path)


def remove_leftovers(settings: ServiceSettings, now: float | None = None) -> int:
    """Remove transfers that nobody ended, and folders of jobs whose process was killed, once they are a day old.

    Args:
        settings: Which home.
        now: Seconds since 1970; None: now, by this machine's clock.

    Returns:
        How many files and folders are gone.
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
    """Keep workers and the API of this machine out; None where one of them has the home open."""
    return take_lock(settings.home / IN_USE)
