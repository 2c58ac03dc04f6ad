"""Outages of store, disk or database: the job returns to the queue with a pause, and the outage is recorded.

The retry policy, by an error's class: `Unavailable` costs no attempt and is retried after a growing pause; `BadInput`
and every other error end the job at once; a worker's death costs an attempt (`jobs.expire`).
"""

from __future__ import annotations

import errno

from sqlalchemy import delete, exists, select, update
from sqlalchemy.exc import IntegrityError

from ..core.run.errors import Unavailable
from .database import Database, DatabaseUnreachable, change_rows, clock, skip_damaged_rows
from .models import OutageRow
from .queue_records import Outage
from .store import StorageFull, StoreUnreachable

MAX_OUTAGE_PAUSE = 300.0
"""Longest pause of a job, or between two checks [s]: the longest time for which the end of an outage stays
unnoticed."""

STALE_SECONDS = 2 * MAX_OUTAGE_PAUSE
"""Time without a report after which an outage, or its worker, has ended [s]."""

FULL_ERRNOS, AWAY_ERRNOS = (errno.ENOSPC, errno.EDQUOT), (errno.EIO, errno.ESTALE, errno.ENOTCONN, errno.EROFS)
"""The system's errors for a full disk, and for an unavailable one."""


def find_outage(error: BaseException) -> Unavailable | None:
    """Return the outage that caused an error, or None if there is none."""
    if isinstance(error, Unavailable):
        return error
    if isinstance(error, OSError) and error.errno in FULL_ERRNOS:
        return StorageFull(f"there is no room: {error.strerror}; free some disk space, and the jobs continue.")
    if isinstance(error, OSError) and error.errno in AWAY_ERRNOS:
        return StoreUnreachable(f"a disk is unavailable: {error.strerror}; mount it again, and the jobs continue.")
    return None


def find_pause(first: float, times: int) -> float:
    """Return the pause [s] after `times` earlier outages: it doubles each time, up to `MAX_OUTAGE_PAUSE`."""
    return min(MAX_OUTAGE_PAUSE, first * 2.0 ** min(times, 30))


def note_outage(database: Database, place: str, code: str) -> None:
    """Record that a host's workers wait."""
    with database.write() as session:
        seen = update(OutageRow).where(OutageRow.place == place, OutageRow.code == code)
        if change_rows(session, seen.values(seen=clock())) == 0:
            try:
                with session.begin_nested():
                    session.add(OutageRow(place=place, code=code, since=clock(), seen=clock()))
                    session.flush()
            except IntegrityError:
                pass  # another process of this host has added it


def end_outages(database: Database, place: str) -> None:
    """Record that a host's workers no longer wait; nothing is written if they did not."""
    with database.read() as session:
        if not session.scalar(select(exists().where(OutageRow.place == place))):
            return
    with database.write() as session:
        session.execute(delete(OutageRow).where(OutageRow.place == place))


def list_outage_codes() -> list[str]:
    """Return the codes of all outages of the store and the database that a job may meet."""
    return [StorageFull.code, StoreUnreachable.code, DatabaseUnreachable.code]


@skip_damaged_rows
def list_outages(database: Database) -> list[Outage]:
    """Return the current outages, oldest first."""
    with database.read() as session:
        fresh = select(OutageRow).where(OutageRow.seen > clock() - STALE_SECONDS)
        rows = session.scalars(fresh.order_by(OutageRow.since, OutageRow.place, OutageRow.code)).all()
    return [Outage(row.place, row.code, row.since) for row in rows]
