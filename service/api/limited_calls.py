"""Calls of limited processes for a request: few at a time, in separate threads, until the client disconnects."""

from __future__ import annotations

import asyncio
import contextvars
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, suppress
from typing import Any, TypeVar

from fastapi import Request
from starlette.exceptions import HTTPException

from ...core.run.errors import Cancelled, GarmentqError
from ...core.run.sandbox import IsStopped
from .limits import ApiLimits
from .meter import LimitedFull, LimitedOpen, Meter
from .problems import refuse

LIMITED_CALL_POLL_INTERVAL = 0.05
"""Interval at which a waiting request checks for its turn [s]."""

Result = TypeVar("Result")


class LimitedCalls:
    """Run functions that call limited processes; no other request waits for their threads."""

    def __init__(self, limits: ApiLimits, meter: Meter) -> None:
        """Create the thread pool.

        Args:
            limits: How many run and wait at a time.
            meter: Counts them.
        """
        self._wait_seconds = limits.limited_wait_seconds
        self._meter = meter
        self._threads = ThreadPoolExecutor(limits.limited, "limited")

    async def run(self, request: Request, key: str, work: Callable[[IsStopped], Result]) -> Result:
        """Run a function in its turn, and return its result.

        Args:
            request: The request, its body read completely; if its client disconnects or the answer times out, the work
                is stopped.
            key: Id of the caller's key, or empty.
            work: The function; its argument returns whether to stop, and it passes that to `call_limited`.

        Raises:
            LimitedOpen, LimitedFull: if its turn does not come in time.
            HTTPException: 499 if the client disconnected.
        """
        disconnected = asyncio.create_task(wait_gone(request))
        stopped = threading.Event()
        try:
            turn = await self._wait_for_turn(key, disconnected)

            def work_once() -> Result:
                with turn:  # ends with the process, not with the request
                    return work(stopped.is_set)

            running = asyncio.wrap_future(self._threads.submit(contextvars.copy_context().run, work_once))
            running.add_done_callback(lambda ended: ended.cancelled() or ended.exception())  # retrieves the error
            ends: tuple[asyncio.Future[Any], ...] = (running, disconnected)
            await asyncio.wait(ends, return_when=asyncio.FIRST_COMPLETED)
            if not running.done():
                stopped.set()
            return await asyncio.shield(running)
        except Cancelled:
            raise refuse_gone() from None
        finally:
            stopped.set()
            disconnected.cancel()

    async def _wait_for_turn(self, key: str, disconnected: asyncio.Task[None]) -> ExitStack:
        """Return the stack that counts the work until it is closed."""
        until = time.monotonic() + self._wait_seconds
        with self._meter.waiting(key), ExitStack() as turn:
            while True:
                try:
                    turn.enter_context(self._meter.limited(key))
                    return turn.pop_all()
                except (LimitedOpen, LimitedFull):
                    if time.monotonic() > until:
                        raise
                await asyncio.wait({disconnected}, timeout=LIMITED_CALL_POLL_INTERVAL)
                if disconnected.done():
                    raise refuse_gone()


def refuse_gone() -> HTTPException:
    """Return the refusal that the log shows for a client that disconnected."""
    return refuse(499, "request.gone", "the client disconnected.")


async def wait_gone(request: Request) -> None:
    """Wait until the client has closed the connection, or aborts a body that is not read."""
    with suppress(HTTPException, GarmentqError):
        while (await request.receive())["type"] != "http.disconnect":
            pass
