"""Places of queued jobs in their queue, and when they should start: what the choice of the next job would give now.

The first `MAX_PLACE` jobs of a queue are put into the order in which workers would claim them, and handed to the slots
of the live workers with the times of earlier jobs of each kind. Jobs behind them have no place.
"""

from __future__ import annotations

import heapq
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from itertools import zip_longest
from statistics import fmean
from typing import Any

from sqlalchemy import ColumnElement, select
from sqlalchemy.orm import Session

from .clocks import read_clock
from .database import Database
from .fairness import find_front, is_in_queue, rank_payers
from .models import JobRow
from .reaper import list_workers
from .states import QUEUES, State

MAX_PLACE = 500
"""Number of places that are counted in a queue: the time for them does not grow with the queue."""

LATEST_ENDED = 100
"""Number of the latest succeeded jobs whose times are averaged by kind."""


@dataclass(frozen=True)
class Place:
    """Describe the place of a queued job: 1 is next; and when it should start [s since 1970], None if unknown."""

    place: int
    expected_start: float | None


def find_places(database: Database, jobs: Collection[str]) -> dict[str, Place]:
    """Return the places of some queued jobs by id; paused jobs and those far behind have none."""
    if not jobs:
        return {}
    now, workers = read_clock(database), list_workers(database)
    found: dict[str, Place] = {}
    with database.read() as session:
        seconds = _average_times(session)
        for queue in QUEUES:
            size = sum(worker.concurrency for worker in workers if queue in worker.queues.split(","))
            slots = _find_slots(session, queue, size, now, seconds)
            for number, (job, kind) in enumerate(_order(session, queue), 1):
                start = heapq.heappop(slots) if slots and seconds else None
                found[job] = Place(number, start)
                if start is not None:
                    heapq.heappush(slots, start + _expect(kind, seconds))
    return {job: found[job] for job in jobs if job in found}


def _order(session: Session, queue: str) -> Iterator[tuple[str, str]]:
    """Yield id and kind of the first jobs of a queue in the order in which they would be claimed."""
    left, waits = MAX_PLACE, is_in_queue(queue)
    while left and (front := find_front(session, waits)) is not None:
        group = waits & front.condition
        lists = [_read_oldest(session, group & (JobRow.payer == payer), left) for payer in rank_payers(session, group)]
        taken = [one for turn in zip_longest(*lists) for one in turn if one is not None]
        yield from taken[:left]
        left -= min(left, len(taken))
        waits = is_in_queue(queue) & front.behind


def _read_oldest(session: Session, condition: ColumnElement[bool], most: int) -> list[tuple[str, str]]:
    age = JobRow.family_created, JobRow.created, JobRow.id
    found = session.execute(select(JobRow.id, JobRow.kind).where(condition).order_by(*age).limit(most))
    return [(row.id, row.kind) for row in found]


def _average_times(session: Session) -> dict[str, float]:
    """Return the average time of the latest jobs by kind [s], and of all of them by the empty name."""
    latest = select(JobRow.kind, JobRow.started, JobRow.finished).where(JobRow.state == State.SUCCEEDED)
    times: dict[str, list[float]] = {}
    for row in session.execute(latest.order_by(JobRow.finished.desc()).limit(LATEST_ENDED)):
        if row.started is not None and row.finished is not None:
            for kind in (row.kind, ""):
                times.setdefault(kind, []).append(max(0.0, row.finished - row.started))
    return {kind: fmean(values) for kind, values in times.items()}


def _expect(kind: str, seconds: Mapping[str, float]) -> float:
    return seconds.get(kind, seconds[""])


def _find_slots(session: Session, queue: str, size: int, now: float, seconds: Mapping[str, float]) -> list[Any]:
    """Return when each slot of the queue's workers is free [s since 1970], as a heap."""
    running = select(JobRow.kind, JobRow.started, JobRow.expected_end)
    busy = session.execute(running.where(JobRow.state == State.RUNNING, JobRow.queue == queue).limit(size)).all()
    ends = [one.expected_end or (one.started or now) + (_expect(one.kind, seconds) if seconds else 0.0) for one in busy]
    slots = [max(now, end) for end in ends] + [now] * (size - len(busy))
    heapq.heapify(slots)
    return slots
