"""`/v1/jobs/{job}/events`: the events of a job, as a list or as a stream that resumes after `Last-Event-ID`."""

from __future__ import annotations

import asyncio
import json
import time
from collections.abc import AsyncIterator
from dataclasses import asdict, replace
from typing import Annotated, Any

from fastapi import APIRouter, Header, Query, Request
from fastapi.responses import StreamingResponse
from sqlalchemy import func, select
from starlette.concurrency import run_in_threadpool
from starlette.types import Receive, Scope, Send

from ...core.run.errors import GarmentqError
from ..jobs import find_job, read_events
from ..keys import Caller
from ..models import EventRow
from ..records import Event, News
from ..states import ENDED
from .access import AppState, AppStateDependency, Reader, find_own
from .answers import Events
from .problems import show_answer

router = APIRouter(prefix="/jobs", tags=["jobs"])

EVENT_POLL_INTERVAL = 0.5
"""Interval at which a stream reads the database [s]; progress is written twice a second."""

STREAM_KEEPALIVE_INTERVAL = 15.0
"""Interval between the comments that an idle stream sends [s]; proxies close a connection that is silent for 30 s."""

MAX_EVENTS_PER_REQUEST = 10_000
"""Largest number of events of one response; a job of an hour and a half writes as many."""

HOST_FIELDS = ("owner",)
"""Fields of events that name a host, a process or a task."""

MAX_EVENT_ID = 2**63 - 1
"""Largest number of an event: the largest value of a 64-bit column."""
EXAMPLE = {
    "id": 17, "job": "3685ecfd4f81", "at": 1795250000.5, "kind": "progress",
    "data": {"stage": "drape", "fraction": 0.4, "message": "", "overall": 0.34, "left_seconds": 41.0},
}  # fmt: skip


def describe_answers() -> dict[int | str, dict[str, Any]]:
    """Describe both forms of the response."""
    described = show_answer({"events": [EXAMPLE], "state": "running", "total": 17, "next": None}, model=Events)
    stream = f'id: 17\nevent: progress\ndata: {json.dumps(EXAMPLE)}\n\nevent: end\ndata: {{"state": "succeeded"}}\n\n'
    described[200]["content"]["text/event-stream"] = {"schema": {"type": "string"}, "example": stream}
    return described


@router.get(
    "/{job}/events", summary="Follow a job.",
    responses=describe_answers(),
)  # fmt: skip
async def follow_job(
    job: str,
    request: Request,
    rooms: AppStateDependency,
    caller: Reader,
    after: Annotated[int, Query(ge=0, le=MAX_EVENT_ID)] = 0,
    limit: Annotated[int, Query(ge=1, le=MAX_EVENTS_PER_REQUEST, description="Of a list, not of a stream.")] = (
        MAX_EVENTS_PER_REQUEST
    ),
    last_event_id: Annotated[str | None, Header(max_length=20)] = None,
) -> Any:
    """Return the events after one; as Server-Sent Events if the request has `Accept: text/event-stream`."""
    row = await run_in_threadpool(find_own, rooms, caller, job)
    if last_event_id is not None and last_event_id.isascii() and last_event_id.isdigit():
        after = min(int(last_event_id), MAX_EVENT_ID)
    if "text/event-stream" not in request.headers.get("accept", ""):
        return await run_in_threadpool(_list_events, rooms, caller, row.id, after, limit)
    return _CountedStream(rooms, caller, row.id, after)


class _CountedStream(StreamingResponse):
    """Stream a job's events; the stream is counted while it is sent, and no longer when the client disconnects."""

    def __init__(self, rooms: AppState, caller: Caller, job: str, after: int) -> None:
        super().__init__(_stream(rooms, caller, job, after), media_type="text/event-stream")
        self._counted = rooms.meter.streaming(caller.key)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        with self._counted:
            await super().__call__(scope, receive, send)


async def _stream(rooms: AppState, caller: Caller, job: str, after: int) -> AsyncIterator[str]:
    last_sent = time.monotonic()
    while True:
        try:
            latest = await run_in_threadpool(_read_news, rooms, caller, job, after)
        except GarmentqError:
            return  # the database is unavailable; the client reconnects with Last-Event-ID
        for event in latest.events:
            after, last_sent = event.id, time.monotonic()
            yield f"id: {event.id}\nevent: {event.kind}\ndata: {json.dumps(asdict(event))}\n\n"
        if latest.state in ENDED:
            yield f"event: end\ndata: {json.dumps({'state': latest.state})}\n\n"
            return
        if time.monotonic() - last_sent > STREAM_KEEPALIVE_INTERVAL:
            last_sent = time.monotonic()
            yield ": alive\n\n"
        await asyncio.sleep(EVENT_POLL_INTERVAL)


def _read_news(rooms: AppState, caller: Caller, job: str, after: int, limit: int | None = None) -> News:
    """Return state and events; the state is read first, so that the job's last event is among those read after it."""
    state = find_job(rooms.database, job).state
    events = [Event.from_row(event) for event in read_events(rooms.database, job, after, limit)]
    return News(state, events if caller.sees_all else [hide_host_fields(event) for event in events])


def _list_events(rooms: AppState, caller: Caller, job: str, after: int, limit: int) -> dict[str, Any]:
    """Return the response with some events; their number is asked for last, so that it includes all of these."""
    latest = _read_news(rooms, caller, job, after, limit + 1)
    events, has_more = latest.events[:limit], len(latest.events) > limit
    with rooms.database.read() as session:
        total = session.scalar(select(func.count()).select_from(EventRow).where(EventRow.job == job))
    following = events[-1].id if has_more else None
    return {"state": latest.state, "events": events, "total": total, "next": following}


def hide_host_fields(event: Event) -> Event:
    """Return an event without the names of the service's hosts and processes, which only the scope `admin` sees."""
    return replace(event, data={name: value for name, value in event.data.items() if name not in HOST_FIELDS})
