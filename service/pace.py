"""The time that jobs of a kind take, by the latest that succeeded."""

from __future__ import annotations

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from .models import JobRow
from .states import State

PACE_JOBS = 20
"""Number of the latest jobs whose times are averaged; older ones may be of another machine or version."""

SEARCHED_JOBS = 500
"""Number of the newest jobs of a kind among which those are searched: a bounded part of an index."""


def find_mean_seconds(session: Session, kind: str) -> float | None:
    """Return the mean time of the latest jobs of a kind [s]; None if none has succeeded lately."""
    newest = (
        select(JobRow.state, JobRow.started, JobRow.finished)
        .where(JobRow.kind == kind)
        .order_by(JobRow.created.desc(), JobRow.id.desc())
        .limit(SEARCHED_JOBS)
        .subquery()
    )
    ended = (newest.c.state == State.SUCCEEDED) & newest.c.started.is_not(None)
    times = select((newest.c.finished - newest.c.started).label("seconds")).where(ended).limit(PACE_JOBS).subquery()
    return session.scalar(select(func.avg(times.c.seconds)))
