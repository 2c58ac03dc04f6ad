"""What is not a job's fault: store, disk or database away. The job goes back and rests; who waits says for what.

The retry policy, by an error's class: `Unavailable` costs no attempt and is tried again after a pause that grows;
`BadInput` and every other error end the job at once; a worker's death costs an attempt (`jobs.expire`).
"""

from __future__ import annotations

import errno

from sqlalchemy import delete, exists, select, update
from sqlalchemy.exc import IntegrityError

from ..core.run.errors import Unavailable
from .database import Database, change_rows, clock, skip_damaged_rows
from .models import OutageRow
from .queue_records import Outage
from .store import StorageFull, StoreUnreachable

MAX_OUTAGE_PAUSE = 300.0
"""Longest pause of a job, or between two checks [s]: so long may the end of an outage go unnoticed."""

STALE_SECONDS = 2 * MAX_OUTAGE_PAUSE
"""An outage that nobody has met for so long is over, or its worker is [s]."""

FULL_ERRNOS, AWAY_ERRNOS = (errno.ENOSPC, errno.EDQUOT), (errno.EIO, errno.ESTALE, errno.ENOTCONN, errno.EROFS)
"""What the system says of a disk without room, and of one that is gone."""


def find_outage(error: BaseException) -> Unavailable | None:
    """Return the outage that an error tells of, or None where the job itself is at fault."""
    if isinstance(error, Unavailable):
        return error
    if isinstance(error, OSError) and error.errno in FULL_ERRNOS:
        return StorageFull(f"there is no room: {error.strerror}; free some disk space, and the jobs go on.")
    if isinstance(error, OSError) and error.errno in AWAY_ERRNOS:
        return StoreUnreachable(f"a disk is away: {error.strerror}; mount it again, and the jobs go on.")
    return None


def find_pause(first: float, times: int) -> float:
    """Return how long to wait [s] after something was away `times` times before: twice as long each time."""
    return min(MAX_OUTAGE_PAUSE, first * 2.0 ** min(times, 30))


def note_outage(database: Database, place: str, code: str) -> None:
    """Note that a host's workers wait."""
    with database.write() as session:
        seen = update(OutageRow).where(OutageRow.place == place, OutageRow.code == code)
        if change_rows(session, seen.values(seen=clock())) == 0:
            try:
                with session.begin_nested():
                    session.add(OutageRow(place=place, code=code, since=clock(), seen=clock()))
                    session.flush()
            except IntegrityError:
                pass  # another process of this host was quicker


def end_outages(database: Database, place: str) -> None:
    """Note that a host's workers wait no more; that takes no write where they did not."""
    with database.read() as session:
        if not session.scalar(select(exists().where(OutageRow.place == place))):
            return
    with database.write() as session:
        session.execute(delete(OutageRow).where(OutageRow.place == place))


@skip_damaged_rows
def list_outages(database: Database) -> list[Outage]:
    """Return what workers wait for, the oldest first."""
    with database.read() as session:
        fresh = select(OutageRow).where(OutageRow.seen > clock() - STALE_SECONDS)
        rows = session.scalars(fresh.order_by(OutageRow.since, OutageRow.place, OutageRow.code)).all()
    return [Outage(row.place, row.code, row.since) for row in rows]
