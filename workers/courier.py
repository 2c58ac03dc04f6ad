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
from ..service.signals import STOP_SIGNALS, handle_signals
from ..service.webhook_delivery import send
from ..service.webhooks import claim_due_messages, note_receipt
from .detached import launch

log = logging.getLogger(__name__)

AT_ONCE = 8
"""Messages on the way at a time, each to another webhook."""

MAX_COURIER_RUNTIME = 60.0
"""Longest time that a courier works [s]; then the dispatcher starts another one, with its own settings."""

ROUND_SECONDS = 10.0
"""How long a courier that stays works before it says that it lives [s]."""

MAX_COURIER_SILENCE = 60.0
"""Time since its last round after which a courier hangs, or cannot reach the database [s]: a round takes 15 s at
most."""


def start_courier(settings: ServiceSettings, environment: dict[str, str]) -> int:
    """Start a courier; return its process id."""
    command = [sys.executable, "-m", "garmentq.workers.courier"]
    return launch(command, settings.home / "courier.log", environment | settings.as_environment())


class CourierAway(Unavailable):
    """No courier runs in this home; `garmentq courier` starts one."""

    code = "service.courier_away"


@contextmanager
def _stop_event() -> Iterator[Event]:
    """Give what is set when this process is told to stop: what is on its way then arrives, and is noted."""
    told = Event()
    is_kept = signal.getsignal(signal.SIGHUP) is signal.SIG_IGN  # nohup
    heard = [number for number in STOP_SIGNALS if not (is_kept and number is signal.SIGHUP)]
    with handle_signals(heard, lambda *_: told.set()):
        yield told


async def deliver(
    database: Database, networks: str, seconds: float = MAX_COURIER_RUNTIME, told: Event | None = None
) -> int:
    """Send what is due until nothing is, for some seconds, or until told to stop; return how many were sent."""
    until, sent, told = time.monotonic() + seconds, 0, told or Event()
    while time.monotonic() < until and not told.is_set() and (batch := claim_due_messages(database, AT_ONCE)):
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
        with _stop_event() as told:
            while not told.is_set():
                try:
                    asyncio.run(deliver(database, settings.webhook_networks, ROUND_SECONDS, told))
                    _heartbeat_path(settings).touch()
                except GarmentqError as error:
                    log.warning("messages wait: %s", error)
                told.wait(settings.poll_seconds)
    finally:
        _heartbeat_path(settings).unlink(missing_ok=True)
        database.dispose()
        os.close(in_use)


def check_courier(settings: ServiceSettings) -> None:
    """Check that a courier of this home looked lately for what is owed.

    Raises:
        CourierAway: where none did.
    """
    try:
        age = time.time() - _heartbeat_path(settings).stat().st_mtime
    except FileNotFoundError:
        raise CourierAway() from None
    if age > MAX_COURIER_SILENCE:
        raise CourierAway(f"the courier of this home has not looked for messages for {age:.0f} s; see its log.")


def _heartbeat_path(settings: ServiceSettings) -> Path:
    """Return the file whose time says when a courier looked last."""
    return settings.home / "courier.alive"


def main() -> int:
    """Send what is due in the home that the environment names."""
    settings = read_settings()
    set_up_logs(bool(settings.log_json))
    database = Database(settings.database, pooled=False)
    try:
        with _stop_event() as told:
            asyncio.run(deliver(database, settings.webhook_networks, MAX_COURIER_RUNTIME, told))
    except GarmentqError as error:
        log.warning("messages wait: %s", error)
        return 1
    finally:
        database.dispose()
    return 0


if __name__ == "__main__":
    sys.exit(main())
