"""Send what is owed to webhooks, in a process of its own.

A dispatcher starts one beside its worker where something is due. It ends when nothing is, and after a minute at most.
Where workers have no way out, `garmentq courier` runs one that stays.
"""

from __future__ import annotations

import asyncio
import logging
import os
import signal
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Event

from ..core.run.errors import GarmentqError, Unavailable
from ..service.database import Database, open_database
from ..service.home import use_home
from ..service.logs import set_up_logs
from ..service.settings import ServiceSettings, read_settings
from ..service.signals import STOP_SIGNALS, handling
from ..service.webhook_delivery import send
from ..service.webhooks import note_receipt, take_due
from .detached import launch

log = logging.getLogger(__name__)

AT_ONCE = 8
"""Messages on the way at a time, each to another webhook."""

LONGEST_SECONDS = 60.0
"""How long a courier works [s]; then the dispatcher starts another one, with its own settings."""

ROUND_SECONDS = 10.0
"""How long a courier that stays works before it says that it lives [s]."""

ALIVE_SECONDS = 60.0
"""A courier that has not looked for so long hangs, or cannot reach the database [s]: a round takes 15 s at most."""


def start_courier(settings: ServiceSettings, environment: dict[str, str]) -> int:
    """Start a courier; return its process id."""
    command = [sys.executable, "-m", "garmentq.workers.courier"]
    return launch(command, settings.home / "courier.log", environment | settings.as_environment())


class CourierAway(Unavailable):
    """No courier runs in this home; `garmentq courier` starts one."""

    code = "service.courier_away"


@contextmanager
def _listening() -> Iterator[Event]:
    """Give what is set when this process is told to stop: what is on its way then arrives, and is noted."""
    told = Event()
    is_kept = signal.getsignal(signal.SIGHUP) is signal.SIG_IGN  # nohup
    heard = [number for number in STOP_SIGNALS if not (is_kept and number is signal.SIGHUP)]
    with handling(heard, lambda *_: told.set()):
        yield told


async def deliver(
    database: Database, networks: str, seconds: float = LONGEST_SECONDS, told: Event | None = None
) -> int:
    """Send what is due until nothing is, for some seconds, or until told to stop; return how many were sent."""
    until, sent, told = time.monotonic() + seconds, 0, told or Event()
    while time.monotonic() < until and not told.is_set() and (batch := take_due(database, AT_ONCE)):
        receipts = await asyncio.gather(*(send(message, networks) for message in batch))
        for message, receipt in zip(batch, receipts, strict=True):
            note_receipt(database, message.id, receipt)
        sent += len(batch)
    return sent


def run_courier(settings: ServiceSettings) -> None:
    """Send what is owed to webhooks until SIGTERM, SIGHUP or SIGINT."""
    in_use = use_home(settings)
    set_up_logs(bool(settings.log_json))
    database = open_database(settings, pooled=False)
    try:
        with _listening() as told:
            while not told.is_set():
                try:
                    asyncio.run(deliver(database, settings.webhook_networks, ROUND_SECONDS, told))
                    _mark(settings).touch()
                except GarmentqError as error:
                    log.warning("messages wait: %s", error)
                told.wait(settings.poll_seconds)
    finally:
        _mark(settings).unlink(missing_ok=True)
        database.dispose()
        os.close(in_use)


def check_courier(settings: ServiceSettings) -> None:
    """Check that a courier of this home looked lately for what is owed.

    Raises:
        CourierAway: where none did.
    """
    try:
        age = time.time() - _mark(settings).stat().st_mtime
    except FileNotFoundError:
        raise CourierAway() from None
    if age > ALIVE_SECONDS:
        raise CourierAway(f"the courier of this home has not looked for messages for {age:.0f} s; see its log.")


def _mark(settings: ServiceSettings) -> Path:
    """Return the file whose time says when a courier looked last."""
    return settings.home / "courier.alive"


def main() -> int:
    """Send what is due in the home that the environment names."""
    settings = read_settings()
    set_up_logs(bool(settings.log_json))
    database = Database(settings.database, pooled=False)
    try:
        with _listening() as told:
            asyncio.run(deliver(database, settings.webhook_networks, LONGEST_SECONDS, told))
    except GarmentqError as error:
        log.warning("messages wait: %s", error)
        return 1
    finally:
        database.dispose()
    return 0


if __name__ == "__main__":
    sys.exit(main())
