"""Try a webhook by a message that takes the road of all others: it is owed, and whoever carries those carries it."""

from __future__ import annotations

import asyncio
import time

from .database import Database
from .webhook_records import Receipt
from .webhooks import queue_trial, read_receipt, withdraw_message

WEBHOOK_TRIAL_TIMEOUT = 30.0
"""Longest wait for the result of a trial [s]: a worker starts its courier within two, and a message takes 5 s at most,
after the one that is on its way."""

TRIAL_POLL_INTERVAL = 0.2
"""Interval at which the result of a trial is looked for [s]."""

UNSENT_RECEIPT = Receipt(
    None, "nobody sent it in time: start a worker, or `garmentq courier` where workers do not send"
)
"""What is known of a message that was not sent."""


async def try_webhook(database: Database, webhook: str, key: str | None = None) -> Receipt:
    """Owe a webhook a message of the type `test`, wait until it was sent once, and return what came of it.

    Args:
        database: Where the webhook is.
        webhook: Its id.
        key: Whose it must be; None: anybody's.

    Raises:
        WebhookUnknown: where there is none.
    """
    message = await asyncio.to_thread(queue_trial, database, webhook, key)
    try:
        until = time.monotonic() + WEBHOOK_TRIAL_TIMEOUT
        while time.monotonic() < until:
            await asyncio.sleep(TRIAL_POLL_INTERVAL)
            if (receipt := await asyncio.to_thread(read_receipt, database, message)) is not None:
                return receipt
        return UNSENT_RECEIPT
    finally:
        await asyncio.to_thread(withdraw_message, database, message)
