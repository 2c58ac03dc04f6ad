"""Count the events of each kind without reading them all again: those up to a mark are counted once."""

from __future__ import annotations

from collections import Counter

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from .database import Database, take_advisory_lock
from .models import EventCountRow, EventRow

COUNTED_TO = "counted_to"
"""Kind of the row that has the id of the last event that was counted."""

MIN_NEW_EVENTS = 1000
"""Number of events from which the mark moves on: so many are counted again at each question, in about a millisecond."""

UNSETTLED_EVENTS = 100
"""Number of the newest events that are never counted up: a transaction that began before them may still add one whose
id is smaller (PostgreSQL gives ids out before transactions end)."""


def count_events(session: Session) -> Counter[str]:
    """Return how many events of each kind there were."""
    found = Counter({row.kind: row.number for row in session.scalars(select(EventCountRow))})
    return _count_since(session, found.pop(COUNTED_TO, 0)) + found


def _count_since(session: Session, event: int, to: int | None = None) -> Counter[str]:
    """Return how many events of each kind come after one, up to another (None: all)."""
    counted = select(EventRow.kind, func.count()).where(EventRow.id > event).group_by(EventRow.kind)
    rows = session.execute(counted if to is None else counted.where(EventRow.id <= to))
    return Counter(dict(rows.all()))


def settle_event_counts(database: Database) -> int:
    """Move the mark on where many events have come; return how many were counted. One process at a time does it."""
    with database.read() as session:
        mark = session.get(EventCountRow, COUNTED_TO)
        before, last = mark.number if mark else 0, session.scalar(select(func.max(EventRow.id))) or 0
    to = last - UNSETTLED_EVENTS
    if to - before < MIN_NEW_EVENTS:
        return 0
    with database.write() as session:
        take_advisory_lock(session, COUNTED_TO)
        mark = session.get(EventCountRow, COUNTED_TO, with_for_update=True)
        if (mark.number if mark else 0) != before:
            return 0
        new = _count_since(session, before, to)
        for kind, number in {**new, COUNTED_TO: to - before}.items():
            row = session.get(EventCountRow, kind) or EventCountRow(kind=kind, number=0)
            row.number += number
            session.add(row)
        return new.total()
