"""Send the pending webhook messages, in a process of its own.

A dispatcher starts a courier beside its worker when a message is due. The courier ends when no message is due, and
after a minute at most. Where workers have no outgoing network access, `garmentq courier` runs one that does not end.
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
from threading import Event

from ..core.run.errors import GarmentqError
from ..service.database import Database, open_database
from ..service.home import use_home
from ..service.logs import set_up_logs
from ..service.settings import ServiceSettings, read_settings
from ..service.signals import STOP_SIGNALS, handle_signals
from ..service.webhook_delivery import send
from ..service.webhooks import claim_due_messages, note_receipt
from .alive import Kept, end_heartbeat, renew_heartbeat
from .detached import launch

log = logging.getLogger(__name__)

AT_ONCE = 8
"""Number of messages that are sent at the same time, each to another webhook."""

MAX_COURIER_RUNTIME = 60.0
"""Longest run time of a courier [s]; then the dispatcher starts another one, with its own settings."""

ROUND_SECONDS = 10.0
"""Interval between the heartbeats of a courier that does not end [s]."""


def start_courier(settings: ServiceSettings, environment: dict[str, str]) -> int:
    """Start a courier and return its process id."""
    command = [sys.executable, "-m", "garmentq.workers.courier"]
    return launch(command, settings.home / "courier.log", environment | settings.as_environment())


@contextmanager
def _stop_event() -> Iterator[Event]:
    """Yield an event that is set when this process receives a stop signal; messages being sent are still completed."""
    stop = Event()
    is_kept = signal.getsignal(signal.SIGHUP) is signal.SIG_IGN  # nohup
    numbers = [number for number in STOP_SIGNALS if not (is_kept and number is signal.SIGHUP)]
    with handle_signals(numbers, lambda *_: stop.set()):
        yield stop


async def deliver(
    database: Database, networks: str, seconds: float = MAX_COURIER_RUNTIME, stop: Event | None = None
) -> int:
    """Send due messages until none is left, the time is up, or `stop` is set.

    Args:
        database: The messages' database.
        networks: Non-public networks that webhooks may reach.
        seconds: Longest run time [s].
        stop: Event that ends the run.

    Returns:
        How many messages were sent.
    """
    until, sent, stop = time.monotonic() + seconds, 0, stop or Event()
    while time.monotonic() < until and not stop.is_set() and (batch := claim_due_messages(database, AT_ONCE)):
        receipts = await asyncio.gather(*(send(message, networks) for message in batch))
        for message, receipt in zip(batch, receipts, strict=True):
            note_receipt(database, message.id, receipt)
        sent += len(batch)
    return sent


def run_courier(settings: ServiceSettings) -> None:
    """Send webhook messages until SIGTERM, SIGHUP or SIGINT."""
    in_use = use_home(settings)
    set_up_logs(bool(settings.log_json))
    database = open_database(settings, pooled=False)
    try:
        with _stop_event() as stop:
            while not stop.is_set():
                try:
                    asyncio.run(deliver(database, settings.webhook_networks, ROUND_SECONDS, stop))
                    renew_heartbeat(settings, Kept.COURIER)
                except GarmentqError as error:
                    log.warning("messages wait: %s", error)
                stop.wait(settings.poll_seconds)
    finally:
        end_heartbeat(settings, Kept.COURIER)
        database.dispose()
        os.close(in_use)


def main() -> int:
    """Send the due messages of the home that the environment names."""
    settings = read_settings()
    set_up_logs(bool(settings.log_json))
    database = Database(settings.database, pooled=False)
    try:
        with _stop_event() as stop:
            asyncio.run(deliver(database, settings.webhook_networks, MAX_COURIER_RUNTIME, stop))
    except GarmentqError as error:
        log.warning("messages wait: %s", error)
        return 1
    finally:
        database.dispose()
    return 0


if __name__ == "__main__":
    sys.exit(main())
