"""Whether a long-running process of a home still works: each renews the time of a file, which costs next to nothing.

Nothing heavy is imported, so that a container's health check takes a tenth of a second.
"""

from __future__ import annotations

import time
from enum import StrEnum
from pathlib import Path

from ..core.run.errors import Unavailable
from ..service.settings import ServiceSettings

MAX_HEARTBEAT_AGE = 60.0
"""Time since its last heartbeat after which a process counts as hanging [s]; a worker sends one every 5 s, a courier
every 15 s at the latest."""


class Kept(StrEnum):
    """Name a process that runs until it is stopped; `KEPT.alive` in the home is its file."""

    WORKER = "worker"
    COURIER = "courier"


class WorkerAway(Unavailable):
    """No worker runs in this home; `garmentq worker` starts one, and its log says why one ended."""

    code = "service.worker_away"


class CourierAway(Unavailable):
    """No courier runs in this home; `garmentq courier` starts one."""

    code = "service.courier_away"


def renew_heartbeat(settings: ServiceSettings, process: Kept) -> None:
    """Record that a process of a home works."""
    _heartbeat_path(settings, process).touch()


def end_heartbeat(settings: ServiceSettings, process: Kept) -> None:
    """Record that a process of a home has ended; another one of its kind in this home renews it soon."""
    _heartbeat_path(settings, process).unlink(missing_ok=True)


def check_heartbeat(settings: ServiceSettings, process: Kept) -> None:
    """Check that a process of this home has recently sent a heartbeat.

    Raises:
        WorkerAway, CourierAway: if none has.
    """
    kind = WorkerAway if process is Kept.WORKER else CourierAway
    try:
        age = time.time() - _heartbeat_path(settings, process).stat().st_mtime
    except FileNotFoundError:
        raise kind() from None
    if age > MAX_HEARTBEAT_AGE:
        raise kind(f"the {process} of this home has sent no heartbeat for {age:.0f} s; see its log, restart it.")


def _heartbeat_path(settings: ServiceSettings, process: Kept) -> Path:
    """Return the file whose modification time is a process's last heartbeat."""
    return settings.home / f"{process}.alive"
