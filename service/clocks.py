"""The database's clock may be set: rows that lie in its future are set right, and a leap costs no job an attempt."""

from __future__ import annotations

import time

from sqlalchemy import delete, exists, or_, select, update

from .database import Database, clock, skip_damaged_rows
from .models import JobRow, LockRow, OutageRow, WorkerRow
from .states import OPEN

AHEAD_SECONDS = 2.0
"""How far a row may lie ahead of the clock that wrote it [s]: it cannot at all, but for the rounding of a second."""


@skip_damaged_rows
def clamp_future_times(database: Database) -> int:
    """Move what was written before the clock was set back to now; a lease begins anew, whoever holds it.

    Without that nothing would expire until the clock has caught up.

    Returns:
        How many jobs were moved.
    """
    late = clock() + AHEAD_SECONDS
    ahead = JobRow.state.in_(OPEN) & (JobRow.touched > late)
    with database.read() as session:
        found = exists().where(ahead), exists().where(WorkerRow.seen > late), exists().where(OutageRow.seen > late)
        if not session.scalar(select(or_(*found))):
            return 0
    with database.write() as session:
        rows = session.scalars(select(JobRow).where(ahead).with_for_update(skip_locked=True)).all()
        for row in rows:
            if row.lease_until is not None:
                row.lease_until = clock() + max(0.0, row.lease_until - row.touched)
            row.touched = clock()
        session.execute(update(OutageRow).where(OutageRow.seen > late).values(seen=clock(), since=clock()))
        session.execute(delete(WorkerRow).where(WorkerRow.seen > late))  # who lives says so again within seconds
        return len(rows)


def read_clock(database: Database) -> float:
    """Return the database's time [s since 1970]."""
    with database.read() as session:
        return float(session.execute(select(clock())).scalar_one())


def find_silence(database: Database, duty: str, seconds: float) -> float | None:
    """Return how long nobody has done a duty [s], or None where nobody holds it; `seconds` is how long it is held.

    Nobody holds what was taken before the clock was set back.
    """
    with database.read() as session:
        found = session.scalar(select(clock() - LockRow.until).where(LockRow.name == duty))
    if found is None or found + seconds <= -AHEAD_SECONDS:
        return None
    return max(0.0, float(found) + seconds)


class ClockJumpGuard:
    """Return whether leases may be believed: not until one lease after the database was away, or its clock leapt ahead.

    Their owners could not renew them, or had no chance to yet.
    """

    def __init__(self, lease_seconds: float) -> None:
        """Begin with trust: whoever starts has seen no leap."""
        self._lease = lease_seconds
        self._last: tuple[float, float] | None = None
        self._doubtful_until = 0.0

    def note_outage(self) -> None:
        """Note that the database could not be asked."""
        self._doubtful_until = time.monotonic() + self._lease
        self._last = None

    def note(self, now: float) -> None:
        """Note the database's time [s since 1970]."""
        steady = time.monotonic()
        if self._last is not None and (now - self._last[0]) - (steady - self._last[1]) > self._lease / 2.0:
            self._doubtful_until = steady + self._lease
        self._last = now, steady

    @property
    def is_steady(self) -> bool:
        """Return whether an expired lease is one that its owner let expire."""
        return time.monotonic() >= self._doubtful_until
