"""Metrics of the queue in the Prometheus exposition format, read from the database."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping

from sqlalchemy import func, select

from .database import Database, clock, skip_damaged_rows
from .event_counts import count_events
from .models import JobRow, OutboxRow, WorkerRow
from .progress import read_stage_seconds
from .states import QUEUES, State

MEASURED_JOB_COUNT = 1000
"""Number of ended jobs whose stage times are averaged: enough for a rate, and bounded however large the table is."""

Labelled = tuple[Mapping[str, str], float]


@skip_damaged_rows
def prometheus_text(database: Database) -> str:
    """Return every metric as text: jobs, ages [s], stage times [CPU s], attempts, workers, expired leases."""
    with database.read() as session:
        rows = session.execute(select(JobRow.state, JobRow.queue, func.count()).group_by(JobRow.state, JobRow.queue))
        jobs: dict[tuple[str, str], int] = {(state, queue): count for state, queue, count in rows}
        ages = dict(
            session.execute(
                select(JobRow.queue, clock() - func.min(JobRow.created))
                .where(JobRow.state == State.QUEUED)
                .group_by(JobRow.queue)
            ).all()
        )
        expired = session.scalar(
            select(func.count()).select_from(JobRow).where(JobRow.state == State.RUNNING, JobRow.lease_until < clock())
        )
        kinds = count_events(session)
        workers = session.execute(select(func.count(), func.sum(WorkerRow.concurrency)).select_from(WorkerRow)).one()
        owed = session.scalar(select(func.count()).select_from(OutboxRow))
        ended = select(JobRow.result).where(JobRow.state == State.SUCCEEDED).order_by(JobRow.finished.desc())
        results = session.scalars(ended.limit(MEASURED_JOB_COUNT)).all()
    queues = sorted({*QUEUES, *(queue for _, queue in jobs)})
    parts = [
        _family(
            "jobs",
            "gauge",
            "Jobs by state and queue.",
            [({"state": s, "queue": q}, jobs.get((s, q), 0)) for s in State for q in queues],
        ),
        _family(
            "queue_age_seconds",
            "gauge",
            "Age of the oldest queued job.",
            [({"queue": q}, max(0.0, float(ages.get(q, 0.0)))) for q in queues],
        ),
        _family("workers", "gauge", "Workers alive.", [({}, workers[0])]),
        _family("worker_slots", "gauge", "Jobs that the live workers run at a time.", [({}, workers[1] or 0)]),
        _family("outbox", "gauge", "Wake-ups still to be sent to the broker.", [({}, owed or 0)]),
        _family("leases_overdue", "gauge", "Running jobs whose lease has run out.", [({}, expired or 0)]),
        _family("attempts_total", "counter", "Attempts started.", [({}, kinds.get("started", 0))]),
        _family(
            "leases_expired_total",
            "counter",
            "Attempts that ended because their worker died.",
            [({}, kinds.get("lease_expired", 0) + kinds.get("dead", 0))],
        ),
        _family("releases_total", "counter", "Jobs requeued by stopping workers.", [({}, kinds.get("released", 0))]),
        _family(
            "stage_seconds",
            "gauge",
            f"Mean CPU time by stage of the latest {MEASURED_JOB_COUNT} succeeded jobs.",
            [({"stage": name}, value) for name, value in sorted(_mean_stages(results).items())],
        ),
    ]
    return "".join(parts)


def _mean_stages(results: Iterable[Mapping[str, Mapping[str, float]] | None]) -> dict[str, float]:
    seconds: dict[str, list[float]] = defaultdict(list)
    for result in results:
        for stage, value in read_stage_seconds(result).items():
            seconds[stage].append(value)
    return {stage: sum(values) / len(values) for stage, values in seconds.items()}


def _family(name: str, kind: str, help_text: str, values: Iterable[Labelled]) -> str:
    lines = [f"# HELP garmentq_{name} {help_text}", f"# TYPE garmentq_{name} {kind}"]
    for labels, value in values:
        inside = ",".join(f'{key}="{_escape(text)}"' for key, text in labels.items())
        lines.append(f"garmentq_{name}{{{inside}}} {float(value)!r}" if inside else f"garmentq_{name} {float(value)!r}")
    return "\n".join(lines) + "\n"


def _escape(text: str) -> str:
    return text.replace("\\", r"\\").replace("\n", r"\n").replace('"', r"\"")
