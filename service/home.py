"""What a process does before it works on a home for long: private files, and a lock that keeps a restore out."""

from __future__ import annotations

import os

from ..core.errors import GarmentqError
from .lock import share_lock, take_lock
from .settings import ServiceSettings

IN_USE = "home.lock"
"""File of a home that its workers and its API hold together, and that a restore holds alone."""


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
    os.umask(0o077)
    lock = share_lock(settings.home / IN_USE)
    if lock is None:
        raise HomeBusy()
    return lock


def take_home(settings: ServiceSettings) -> int | None:
    """Keep workers and the API of this machine out; None where one of them has the home open."""
    return take_lock(settings.home / IN_USE)
