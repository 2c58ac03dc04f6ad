"""Wait for the end of a job without a thread: its state is read by one row now and then."""

from __future__ import annotations

import asyncio
import time

from fastapi import Request
from sqlalchemy import select
from starlette.concurrency import run_in_threadpool

from ..models import JobRow
from ..states import ENDED, State
from .access import AppState
from .limited_calls import refuse_gone, wait_gone

MAX_WAIT_SECONDS = 60.0
"""Longest time for which a request waits for a job's end [s]; proxies close a connection that is silent for as long."""

STATE_POLL_INTERVAL = 0.5
"""Interval at which a waiting request reads the job's state [s], as an event stream does."""


async def wait_for_end(rooms: AppState, request: Request, key: str, job: str, seconds: float) -> None:
    """Wait until a job has ended or is gone, at most for some seconds; it counts as one event stream of the key.

    Raises:
        StreamsFull: if the key has reached its limit.
        HTTPException: 499 if the client disconnected.
    """
    until = time.monotonic() + seconds
    disconnected = asyncio.create_task(wait_gone(request))
    try:
        with rooms.meter.streaming(key):
            while await run_in_threadpool(_is_open, rooms, job):
                left = until - time.monotonic()
                if left <= 0.0:
                    return
                await asyncio.wait({disconnected}, timeout=min(STATE_POLL_INTERVAL, left))
                if disconnected.done():
                    raise refuse_gone()
    finally:
        disconnected.cancel()


def _is_open(rooms: AppState, job: str) -> bool:
    """Check whether a job has not ended."""
    with rooms.database.read() as session:
        state = session.scalar(select(JobRow.state).where(JobRow.id == job))
    return state is not None and State(state) not in ENDED
