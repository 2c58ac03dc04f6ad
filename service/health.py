"""Messages about what keeps jobs from running: no worker, a silent dispatcher, an outage; each with the next step."""

from __future__ import annotations

import time
from dataclasses import replace

from ..core.run.errors import GarmentqError, Unavailable
from .clocks import find_silence
from .database import Database
from .outage import list_outages
from .query import count_states
from .queue_records import Queue, Worker
from .reaper import DISPATCHER_LEASE, LEADER_LEASE_TIME, list_workers
from .states import State

MAX_DISPATCHER_SILENCE = 30.0
"""Time without an action after which a dispatcher is reported as stopped [s]; it acts twice a second."""


def read_queue(database: Database) -> Queue:
    """Return counts of jobs, live workers, and outages."""
    workers = [Worker.from_row(row) for row in list_workers(database)]
    silence = find_silence(database, DISPATCHER_LEASE, LEADER_LEASE_TIME)
    return Queue(count_states(database), workers, list_outages(database), silence)


def hide_worker_names(queue: Queue) -> Queue:
    """Return the queue without the names of workers and machines, for callers who do not operate them."""
    workers = [replace(worker, name=f"worker {number}") for number, worker in enumerate(queue.workers, 1)]
    return replace(queue, workers=workers, outages=[replace(outage, place="") for outage in queue.outages])


def find_troubles(queue: Queue) -> list[str]:
    """Return what keeps jobs from running, one message each; none if jobs run or nothing waits."""
    troubles = []
    if not queue.workers and any(queue.states.get(state) for state in (State.QUEUED, State.RUNNING, State.WAITING)):
        troubles.append(
            "no worker is up, or none reaches its broker, so the jobs wait; `garmentq up` starts one, "
            "`garmentq worker` on a server, and `garmentq doctor` there shows what is unavailable."
        )
    if queue.workers and (queue.silence is None or queue.silence > MAX_DISPATCHER_SILENCE):
        since = "yet" if queue.silence is None else f"for {queue.silence:.0f} s"
        troubles.append(f"no dispatcher has acted {since}, so no new job starts; see the workers' log, restart them.")
    for outage in queue.outages:
        since_text = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(outage.since))
        host = f" ({outage.place})" if outage.place else ""
        troubles.append(f"jobs wait since {since_text}{host}: {outage.code}: {explain(outage.code)}")
    return troubles


def explain(code: str) -> str:
    """Return the message of an outage's code, without details of this installation."""
    return next((kind().message for kind in _find_kinds(Unavailable) if kind.code == code), Unavailable().message)


def _find_kinds(kind: type[GarmentqError]) -> list[type[GarmentqError]]:
    return [one for each in kind.__subclasses__() for one in (each, *_find_kinds(each))]
