"""Overall progress of a job and its expected end: stages are weighted by their times in earlier jobs of its kind."""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from sqlalchemy import case, select

from .database import Database, clock, skip_damaged_rows
from .jobs import Claim, record, write_fenced
from .models import JobRow
from .records import Progress
from .states import State

log = logging.getLogger(__name__)

LATEST_JOBS = 1000
"""Number of newest jobs among which earlier jobs of a kind are searched: one index lookup, however many jobs
there are."""

LEARNT_JOBS = 20
"""Number of earlier jobs of a kind and method that are averaged; older ones may be of another machine or version."""

BELIEVED_SHARE = 0.1
"""Share of a job from which its own speed is used; before that its start would dominate."""


@dataclass(frozen=True)
class Pace:
    """Describe the times of jobs of a kind and method.

    Attributes:
        weights: Time of each stage in its order, in any unit.
        seconds: Time of a whole job [s]; None if no earlier job is known.
    """

    weights: Mapping[str, float] = field(default_factory=dict)
    seconds: float | None = None

    def find_share(self, stage: str, fraction: float) -> float | None:
        """Return the overall progress, 0..1, of a job at a fraction of a stage; None if the stage is unknown."""
        total = sum(self.weights.values())
        if stage not in self.weights or total <= 0.0:
            return None
        names = list(self.weights)
        before = sum(self.weights[name] for name in names[: names.index(stage)])
        return min(1.0, (before + fraction * self.weights[stage]) / total)

    def find_left(self, share: float, elapsed: float) -> float | None:
        """Return the remaining time [s] of a job at a share of it, `elapsed` seconds after its start; None: unknown.

        It is the time that earlier jobs took for the rest, or the time at this job's own speed if that is longer.
        """
        if self.seconds is None:
            return None
        estimate = elapsed / share if share >= BELIEVED_SHARE else 0.0
        return (1.0 - share) * max(self.seconds, estimate)


class ProgressEstimator:
    """Estimate the overall progress of a running job from that of a stage; it never decreases."""

    def __init__(self, pace: Pace) -> None:
        """Start the clock."""
        self.pace, self.begun, self.share = pace, time.monotonic(), 0.0

    def note(self, stage: str, fraction: float, message: str) -> Progress:
        """Return a stage's progress with the overall one."""
        fraction = min(1.0, max(0.0, fraction)) if math.isfinite(fraction) else 0.0
        found = self.pace.find_share(stage, fraction)
        if found is None:
            return Progress(stage, fraction, message)
        self.share = max(self.share, found)
        left = self.pace.find_left(self.share, time.monotonic() - self.begun)
        return Progress(stage, fraction, message, self.share, left)


def learn_pace(database: Database, kind: str, request: Mapping[str, Any], stages: Sequence[str]) -> Pace:
    """Return the times of earlier jobs of a kind and method; a failure here does not fail the job.

    Args:
        database: The jobs' database.
        kind: Name of the kind.
        request: The job's own request, as it was stored.
        stages: The kind's stages in order; without earlier jobs each has the same share, and no time is estimated.
    """
    try:
        seen = _find_paces(database, kind, request)
    except Exception as error:
        log.warning("times of earlier jobs are not available: %s: %s", type(error).__name__, error)
        seen = []
    weights: dict[str, float] = {}
    for share, _ in seen:
        for stage, seconds in share.items():
            weights[stage] = weights.get(stage, 0.0) + seconds
    if sum(weights.values()) <= 0.0:
        return Pace(dict.fromkeys(stages, 1.0))
    return Pace(weights, sum(seconds for _, seconds in seen) / len(seen))


def read_stage_seconds(result: object) -> dict[str, float]:
    """Return the time of each stage [s] in a job's result, without invalid values."""
    stages = result.get("stage_seconds") if isinstance(result, Mapping) else None
    found = stages.items() if isinstance(stages, Mapping) else ()
    return {str(stage): float(seconds) for stage, seconds in found if is_time(seconds)}


def is_time(seconds: object) -> bool:
    """Return whether a value is a time [s]: a finite number that is not negative."""
    return isinstance(seconds, int | float) and math.isfinite(seconds) and seconds >= 0.0


@skip_damaged_rows
def _find_paces(database: Database, kind: str, request: Mapping[str, Any]) -> list[tuple[dict[str, float], float]]:
    """Return the times of the stages, and of the whole, of each of the latest jobs of a kind and method [s]."""
    newest = select(JobRow.id).order_by(JobRow.created.desc()).limit(LATEST_JOBS).scalar_subquery()
    statement = (
        select(JobRow.request, JobRow.result, (JobRow.finished - JobRow.started).label("seconds"))
        .where(JobRow.id.in_(newest), JobRow.kind == kind, JobRow.state == State.SUCCEEDED, JobRow.attempts == 1)
        .where(JobRow.finished >= JobRow.started)
        .order_by(JobRow.created.desc())
        .limit(3 * LEARNT_JOBS)
    )
    with database.read() as session:
        rows = session.execute(statement).all()
    found = [row for row in rows if _method(row.request) == _method(request)][:LEARNT_JOBS]
    timed = [(read_stage_seconds(row.result), float(row.seconds)) for row in found if is_time(row.seconds)]
    return [(share, seconds) for share, seconds in timed if share]


def report(database: Database, claim: Claim, progress: Progress) -> None:
    """Write a job's progress; a new attempt never shows less overall progress than the one before.

    Raises:
        FenceLost: if another worker has claimed the job.
    """
    stage, fraction, share, left = progress.stage, progress.fraction, progress.overall, progress.left_seconds
    values: dict[str, Any] = {"stage": stage, "progress": fraction, "touched": clock()}
    note: dict[str, Any] = {"stage": stage, "fraction": round(fraction, 4), "message": progress.message}
    if share is not None:
        values["overall"] = case((JobRow.overall > share, JobRow.overall), else_=share)
        values["expected_end"] = None if left is None else clock() + left
        note |= {"overall": round(share, 4), "left_seconds": None if left is None else round(left, 1)}
    with database.write() as session:
        write_fenced(session, claim, **values)
        record(session, claim.job, "progress", **note)


def _method(request: Mapping[str, Any]) -> object:
    """Return what decides which stages a job has."""
    settings = request.get("settings")
    return (settings.get("method"), settings.get("redrape")) if isinstance(settings, Mapping) else None
