"""Send what is owed to webhooks, in a process of its own beside the worker that holds the dispatcher's duty.

A dispatcher starts one where something is due. It ends when nothing is, and after a minute in any case.
"""

from __future__ import annotations

import asyncio
import logging
import sys
import time

from ..core.errors import GarmentqError
from ..service.database import Database
from ..service.logs import set_up_logs
from ..service.settings import ServiceSettings, read_settings
from ..service.webhook_delivery import send
from ..service.webhooks import note_receipt, take_due
from .detached import launch

log = logging.getLogger(__name__)

AT_ONCE = 8
"""Messages on the way at a time, each to another webhook."""

LONGEST_SECONDS = 60.0
"""How long a courier works [s]; then the dispatcher starts another one, with its own settings."""


def start_courier(settings: ServiceSettings, environment: dict[str, str]) -> int:
    """Start a courier; return its process id."""
    command = [sys.executable, "-m", "garmentq.workers.courier"]
    return launch(command, settings.home / "courier.log", environment | settings.as_environment())


async def deliver(database: Database, networks: str, seconds: float = LONGEST_SECONDS) -> int:
    """Send what is due until nothing is, or for some seconds; return how many messages were sent."""
    until, sent = time.monotonic() + seconds, 0
    while time.monotonic() < until and (batch := take_due(database, AT_ONCE)):
        receipts = await asyncio.gather(*(send(message, networks) for message in batch))
        for message, receipt in zip(batch, receipts, strict=True):
            note_receipt(database, message.id, receipt)
        sent += len(batch)
    return sent


def main() -> int:
    """Send what is due in the home that the environment names."""
    settings = read_settings()
    set_up_logs(bool(settings.log_json))
    database = Database(settings.database, pooled=False)
    try:
        asyncio.run(deliver(database, settings.webhook_networks))
    except GarmentqError as error:
        log.warning("messages wait: %s", error)
        return 1
    finally:
        database.dispose()
    return 0


if __name__ == "__main__":
    sys.exit(main())
