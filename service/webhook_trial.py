"""Test of a webhook by a message that is queued and sent as all others."""

from __future__ import annotations

import asyncio
import time

from .database import Database
from .webhook_records import Receipt
from .webhooks import queue_trial, read_receipt, withdraw_message

WEBHOOK_TRIAL_TIMEOUT = 30.0
"""Longest wait for the result of a test [s]: a worker starts its courier within two, and a message takes 5 s at most,
after the one that is being sent."""

TRIAL_POLL_INTERVAL = 0.2
"""Interval at which the result of a test is polled [s]."""

UNSENT_RECEIPT = Receipt(None, "it was not sent in time: start a worker, or `garmentq courier` if workers do not send")
"""Receipt of a message that was not sent."""


async def try_webhook(database: Database, webhook: str, key: str | None = None) -> Receipt:
    """Queue a message of the type `test` for a webhook, wait until it was sent once, and return the outcome.

    Args:
        database: The webhook's database.
        webhook: Its id.
        key: Key that must own it; None: any.

    Raises:
        WebhookUnknown: if there is none.
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
