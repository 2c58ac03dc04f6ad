"""`/v1/jobs/states` and `/v1/queue`: the progress of many jobs in one request."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from fastapi import APIRouter
from sqlalchemy import func, select

from ..families import find_below
from ..health import hide_worker_names, read_queue
from ..jobs import find_jobs_by_id
from ..models import JobRow, OwnerRow
from ..queue_records import Queue
from ..records import Job
from ..states import State
from .access import AppState, AppStateDependency, Reader
from .answers import Briefs
from .problems import show_answer
from .schemas import JobsIn

router = APIRouter(tags=["jobs"])

BRIEF = {
    "job": "3685ecfd4f81", "name": "skirt", "state": "running", "stage": "drape", "progress": 0.4, "attempts": 1,
    "overall": 0.34, "expected_end": 1795250041.5,
    "created": 1795250000.1, "started": 1795250000.4, "finished": None, "error": None, "bad_input": False,
    "created_at": "2026-11-21T08:33:20.100Z", "started_at": "2026-11-21T08:33:20.400Z", "finished_at": None,
    "queue": "cpu", "priority": 0, "verdict": None, "kind": "recover", "parent": None, "family": "3685ecfd4f81",
    "delay": None,
}  # fmt: skip
WORKER = {"name": "worker 1", "queues": "cpu", "concurrency": 2, "started": 1795240000.0, "seen": 1795250000.0}
QUEUE = {"states": {"queued": 3, "running": 2}, "workers": [WORKER], "outages": [], "silence": 0.4}


@router.post(
    "/jobs/states", summary="Show the states of jobs.", responses=show_answer({"jobs": [BRIEF]}, 200, Briefs, (408,))
)
def list_states(payload: JobsIn, rooms: AppStateDependency, caller: Reader) -> Any:
    """Return the jobs of some ids in their order; with `below`, then all jobs below them.

    Unknown jobs and jobs of other keys are left out.
    """
    ids = payload.jobs
    if not caller.sees_all:
        with rooms.database.read() as session:
            statement = select(OwnerRow.job).where(OwnerRow.key == caller.key, OwnerRow.job.in_(ids))
            seen = set(session.scalars(statement))
        ids = [job for job in ids if job in seen]
    rows = find_jobs_by_id(rooms.database, ids)
    more = find_below(rooms.database, ids) if payload.below else []  # a caller that sees a job sees all below it
    return {"jobs": [Job.from_row(row).as_json() for row in rows + more]}


@router.get("/queue", summary="Count the jobs and list the workers.", responses=show_answer(QUEUE, 200, Queue))
def show_queue(rooms: AppStateDependency, caller: Reader) -> Any:
    """Count the caller's jobs by state, and list the live workers; only the scope `admin` sees their names."""
    queue = read_queue(rooms.database)
    if caller.sees_all:
        return queue
    return replace(hide_worker_names(queue), states=count_own(rooms, caller.key))


def count_own(rooms: AppState, key: str) -> dict[State, int]:
    """Count the jobs of a key by state."""
    statement = select(JobRow.state, func.count()).join(OwnerRow, OwnerRow.job == JobRow.id).where(OwnerRow.key == key)
    with rooms.database.read() as session:
        return {row[0]: row[1] for row in session.execute(statement.group_by(JobRow.state)).all()}
