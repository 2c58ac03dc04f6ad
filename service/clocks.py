"""Handling of a database clock that was set: future times are clamped to now, and a jump costs no job an attempt."""

from __future__ import annotations

import time

from sqlalchemy import delete, exists, or_, select, update

from .database import Database, clock, skip_damaged_rows
from .models import JobRow, LockRow, OutageRow, WorkerRow
from .states import OPEN

AHEAD_SECONDS = 2.0
"""Tolerance by which a row's time may be ahead of the clock that wrote it [s]; only rounding to a second can cause
that."""


@skip_damaged_rows
def clamp_future_times(database: Database) -> int:
    """Clamp times that were written before the clock was set back to now; a lease starts anew for its owner.

    Without that nothing would expire until the clock has caught up.

    Returns:
        How many jobs were changed.
    """
    late = clock() + AHEAD_SECONDS
    in_future = JobRow.state.in_(OPEN) & (JobRow.touched > late)
    with database.read() as session:
        found = exists().where(in_future), exists().where(WorkerRow.seen > late), exists().where(OutageRow.seen > late)
        if not session.scalar(select(or_(*found))):
            return 0
    with database.write() as session:
        rows = session.scalars(select(JobRow).where(in_future).with_for_update(skip_locked=True)).all()
        for row in rows:
            if row.lease_until is not None:
                row.lease_until = clock() + max(0.0, row.lease_until - row.touched)
            row.touched = clock()
        session.execute(update(OutageRow).where(OutageRow.seen > late).values(seen=clock(), since=clock()))
        session.execute(delete(WorkerRow).where(WorkerRow.seen > late))  # live workers send a heartbeat within seconds
        return len(rows)


def read_clock(database: Database) -> float:
    """Return the database's time [s since 1970]."""
    with database.read() as session:
        return float(session.execute(select(clock())).scalar_one())


def find_silence(database: Database, duty: str, seconds: float) -> float | None:
    """Return the time since a leader last renewed its lease [s], or None if there is no leader.

    A lease that was taken before the clock was set back does not count.

    Args:
        database: The leases' database.
        duty: Name of the lease.
        seconds: Duration of the lease [s].
    """
    with database.read() as session:
        found = session.scalar(select(clock() - LockRow.until).where(LockRow.name == duty))
    if found is None or found + seconds <= -AHEAD_SECONDS:
        return None
    return max(0.0, float(found) + seconds)


class ClockJumpGuard:
    """Detect whether expired leases are reliable: not until one lease after an outage or a forward jump of the clock.

    Until then their owners could not renew them.
    """

    def __init__(self, lease_seconds: float) -> None:
        """Begin with reliable leases: no jump has been seen yet."""
        self._lease = lease_seconds
        self._last: tuple[float, float] | None = None
        self._doubtful_until = 0.0

    def note_outage(self) -> None:
        """Record that the database was unavailable."""
        self._doubtful_until = time.monotonic() + self._lease
        self._last = None

    def note(self, now: float) -> None:
        """Record the database's time [s since 1970]."""
        steady = time.monotonic()
        if self._last is not None and (now - self._last[0]) - (steady - self._last[1]) > self._lease / 2.0:
            self._doubtful_until = steady + self._lease
        self._last = now, steady

    @property
    def is_steady(self) -> bool:
        """Return whether the owner of an expired lease was able to renew it."""
        return time.monotonic() >= self._doubtful_until
