"""Events are counted once, however many there are."""

from __future__ import annotations

from garmentq.service.database import Database
from garmentq.service.event_counts import MIN_NEW_EVENTS, UNSETTLED_EVENTS, count_events, settle_event_counts
from garmentq.service.metrics import prometheus_text
from garmentq.service.models import EventRow
from sqlalchemy import delete, insert


def add(database: Database, job: str, kind: str, count: int) -> None:
    """Add events of one kind."""
    with database.write() as session:
        session.execute(insert(EventRow), [{"job": job, "at": 0.0, "kind": kind, "data": {}}] * count)


def read(database: Database, kind: str) -> int:
    """Return how many events of a kind are counted."""
    with database.read() as session:
        return count_events(session)[kind]


def test_counts_are_the_same_before_and_after(database: Database, queue_job) -> None:
    """Breaks where an event is counted twice or not at all, or the mark moves for a few."""
    job = queue_job()
    add(database, job, "started", MIN_NEW_EVENTS + UNSETTLED_EVENTS)
    add(database, job, "released", 30)
    before = {kind: read(database, kind) for kind in ("started", "released", "queued")}
    assert before == {"started": MIN_NEW_EVENTS + UNSETTLED_EVENTS, "released": 30, "queued": 1}
    assert settle_event_counts(database) == MIN_NEW_EVENTS + 31
    assert {kind: read(database, kind) for kind in before} == before and read(database, "counted_to") == 0
    assert settle_event_counts(database) == 0
    add(database, job, "started", 7)
    assert read(database, "started") == before["started"] + 7
    assert f"garmentq_attempts_total {before['started'] + 7}.0" in prometheus_text(database)


def test_counted_events_outlive_their_job(database: Database, queue_job) -> None:
    """Breaks where a counter falls when old jobs are deleted, which a monitor takes for a restart."""
    job = queue_job()
    add(database, job, "started", MIN_NEW_EVENTS + UNSETTLED_EVENTS)
    counted = settle_event_counts(database)
    with database.write() as session:
        session.execute(delete(EventRow))
    assert read(database, "started") == counted - 1 >= MIN_NEW_EVENTS - 1
