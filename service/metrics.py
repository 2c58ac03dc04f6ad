"""Metrics of the queue in the Prometheus exposition format, read from the database."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping

from sqlalchemy import func, select

from .database import Database, clock, skip_damaged_rows
from .event_counts import count_events
from .exposition import format_family
from .models import DeliveryRow, JobRow, OutageRow, OutboxRow, WebhookRow, WorkerRow
from .outage import STALE_SECONDS, list_outage_codes
from .progress import read_stage_seconds
from .states import QUEUES, State

MEASURED_JOB_COUNT = 1000
"""Number of ended jobs whose stage times are averaged: enough for a rate, and bounded however large the table is."""


@skip_damaged_rows
def prometheus_text(database: Database) -> str:
    """Return the queue's metrics as text: jobs, ages [s], stage times [CPU s], attempts, workers, outages, messages.

    Each question is answered by an index, and no label grows with jobs, keys or hosts.
    """
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
        running = session.scalar(select(clock() - func.min(JobRow.started)).where(JobRow.state == State.RUNNING))
        outages: dict[str, int] = dict(
            session.execute(
                select(OutageRow.code, func.count())
                .where(OutageRow.seen > clock() - STALE_SECONDS)
                .group_by(OutageRow.code)
            ).all()
        )
        waiting = (DeliveryRow.webhook == WebhookRow.id) & DeliveryRow.due.is_not(None)
        messages, oldest = session.execute(
            select(func.count(DeliveryRow.id), clock() - func.min(DeliveryRow.created))
            .select_from(WebhookRow)
            .join(DeliveryRow, waiting)
        ).one()
        kinds = count_events(session)
        workers = session.execute(select(func.count(), func.sum(WorkerRow.concurrency)).select_from(WorkerRow)).one()
        owed = session.scalar(select(func.count()).select_from(OutboxRow))
        ended = select(JobRow.result).where(JobRow.state == State.SUCCEEDED).order_by(JobRow.finished.desc())
        results = session.scalars(ended.limit(MEASURED_JOB_COUNT)).all()
    queues = sorted({*QUEUES, *(queue for _, queue in jobs)})
    parts = [
        format_family(
            "jobs",
            "gauge",
            "Jobs by state and queue.",
            [({"state": s, "queue": q}, jobs.get((s, q), 0)) for s in State for q in queues],
        ),
        format_family(
            "queue_age_seconds",
            "gauge",
            "Age of the oldest queued job.",
            [({"queue": q}, _bound(ages.get(q))) for q in queues],
        ),
        format_family(
            "running_age_seconds", "gauge", "Time since the oldest running job began.", [({}, _bound(running))]
        ),
        format_family(
            "outages",
            "gauge",
            "Hosts whose jobs wait for what is unavailable.",
            [({"code": code}, outages.get(code, 0)) for code in sorted({*list_outage_codes(), *outages})],
        ),
        format_family("webhook_messages", "gauge", "Messages to webhooks that wait.", [({}, messages)]),
        format_family("webhook_age_seconds", "gauge", "Age of the oldest of them.", [({}, _bound(oldest))]),
        format_family("workers", "gauge", "Workers alive.", [({}, workers[0])]),
        format_family("worker_slots", "gauge", "Jobs that the live workers run at a time.", [({}, workers[1] or 0)]),
        format_family("outbox", "gauge", "Wake-ups still to be sent to the broker.", [({}, owed or 0)]),
        format_family("leases_overdue", "gauge", "Running jobs whose lease has run out.", [({}, expired or 0)]),
        format_family("attempts_total", "counter", "Attempts started.", [({}, kinds.get("started", 0))]),
        format_family(
            "leases_expired_total",
            "counter",
            "Attempts that ended because their worker died.",
            [({}, kinds.get("lease_expired", 0) + kinds.get("dead", 0))],
        ),
        format_family(
            "releases_total", "counter", "Jobs requeued by stopping workers.", [({}, kinds.get("released", 0))]
        ),
        format_family(
            "stage_seconds",
            "gauge",
            f"Mean CPU time by stage of the latest {MEASURED_JOB_COUNT} succeeded jobs.",
            [({"stage": name}, value) for name, value in sorted(_mean_stages(results).items())],
        ),
    ]
    return "".join(parts)


def _bound(age: float | None) -> float:
    """Return an age [s]; 0 if there is nothing, or the clock was set back."""
    return max(0.0, float(age or 0.0))


def _mean_stages(results: Iterable[Mapping[str, Mapping[str, float]] | None]) -> dict[str, float]:
    seconds: dict[str, list[float]] = defaultdict(list)
    for result in results:
        for stage, value in read_stage_seconds(result).items():
            seconds[stage].append(value)
    return {stage: sum(values) / len(values) for stage, values in seconds.items()}
