"""Run many jobs while workers are killed, the broker is restarted and the database goes away; print what came of it.

    python tests/chaos/long.py --database sqlite|postgresql [--jobs 1000] [--workers 4] [--seed 0]

Every two seconds one process of one worker (its parent or its child, by chance) gets a `kill -9`; a parent that is gone
is started again, as an init system would. The broker is killed and started again twice. PostgreSQL is stopped at once
(`pg_ctl -m immediate`) and started again; SQLite has no server, so another process holds its lock for five seconds.
The store is taken away for ten seconds, three times; the kills go on meanwhile.
"""

from __future__ import annotations

import argparse
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "standin"))

from garmentq.service.database import Database, DatabaseUnreachable, open_database
from garmentq.service.models import ArtifactRow, EventRow, JobRow
from garmentq.service.query import count_states
from garmentq.service.store import Store
from garmentq.service.submission import Order, submit
from garmentq.workers.broker import run_folder, start_broker, stop_broker
from garmentq_home import make_environment, make_settings, put_file
from postgres_server import PostgresServer
from sqlalchemy import func, select

AWAY_SECONDS = 5.0
STORE_SECONDS = 10.0
LOOK_SECONDS = 0.1
GIVE_UP_SECONDS = 3600.0


class Fleet:
    """Keep some workers running and kill their processes by chance."""

    def __init__(self, start: Callable[[], Any], count: int, random: np.random.Generator) -> None:
        self.start, self.random, self.kills = start, random, Counter()
        self.workers = [start() for _ in range(count)]

    def keep_up(self) -> None:
        """Start again what is gone."""
        self.workers = [worker if worker.poll() is None else self.start() for worker in self.workers]

    def kill_one(self) -> None:
        """Kill the parent or a child of one worker."""
        worker = self.workers[self.random.integers(len(self.workers))]
        children = Path(f"/proc/{worker.pid}/task/{worker.pid}/children")
        pids = [worker.pid, *map(int, children.read_text().split())] if children.exists() else [worker.pid]
        victim = pids[self.random.integers(len(pids))]
        with suppress(ProcessLookupError):
            os.kill(victim, signal.SIGKILL)
            self.kills["parent" if victim == worker.pid else "child"] += 1

    def stop(self) -> None:
        """Stop all workers well."""
        for worker in self.workers:
            worker.terminate()
        for worker in self.workers:
            worker.wait(timeout=60)


def start_by_command(settings) -> subprocess.Popen:
    """Start a worker as an init system does."""
    command = [sys.executable, "-m", "garmentq.cli.main", "worker", "--workers", "1"]
    with (settings.home / "worker.log").open("ab") as log:
        return subprocess.Popen(command, env=make_environment(settings), stdout=log, stderr=log, start_new_session=True)


def restart_broker(settings) -> None:
    """Kill the broker and start it again."""
    with suppress(ProcessLookupError):
        os.kill(int((run_folder(settings) / "broker.pid").read_text()), signal.SIGKILL)
    time.sleep(1.0)
    start_broker(settings)


def lock_sqlite(settings, seconds: float) -> None:
    """Describe SQLite's write lock for a while from a process of its own."""
    code = (
        "import sqlite3, sys, time\nc = sqlite3.connect(sys.argv[1], timeout=60, isolation_level=None)\n"
        f"c.execute('begin exclusive')\ntime.sleep({seconds})\n"
    )
    subprocess.run([sys.executable, "-c", code, str(settings.home / "garmentq.db")], check=True)


def restart_database(settings, server: PostgresServer | None, seconds: float) -> None:
    """Stop the server at once and start it again, or lock SQLite for a while."""
    if server is None:
        lock_sqlite(settings, seconds)
    else:
        server.stop()
        server.start()


def take_store_away(settings, seconds: float) -> None:
    """Rename the store's folder, and name it back after a while; processes are killed meanwhile."""
    away = wait_for_store(settings)
    settings.store_path.rename(away)
    threading.Timer(seconds, lambda: away.rename(settings.store_path)).start()


def wait_for_store(settings) -> Path:
    """Wait until the store is back, and return the name that it has while it is away."""
    away = settings.store_path.with_name("away")
    while away.exists():
        time.sleep(LOOK_SECONDS)
    return away


@dataclass(frozen=True)
class Pace:
    """Describe when a process is killed: after so many seconds, and not before so many more jobs have ended.

    A quick test counts jobs only, so that a machine that hardly moves is not killed faster than it can start.

    Attributes:
        seconds: Least time between two kills [s].
        jobs: Jobs that end between two kills, at least.
        store_seconds: How long the store is away each time [s].
        lock_seconds: How long SQLite is locked [s].
    """

    seconds: float = 2.0
    jobs: int = 0
    store_seconds: float = STORE_SECONDS
    lock_seconds: float = AWAY_SECONDS


def run(
    settings, start: Callable[[], Any], jobs: int, workers: int, seed: int, pace: Pace, server: PostgresServer | None
) -> dict[str, object]:
    """Run the whole and give the figures; without a server the database is SQLite in the settings' home."""
    database, store = open_database(settings, pooled=False), Store(settings.store_path)
    start_broker(settings)
    took = queue_all(database, store, settings.home, jobs)
    begun, fleet = time.monotonic(), Fleet(start, workers, np.random.default_rng(seed))
    ended, struck, met = 0, time.monotonic(), 0
    blows = [
        (0.1, lambda: take_store_away(settings, pace.store_seconds)),
        (0.2, lambda: restart_broker(settings)),
        (0.3, lambda: take_store_away(settings, pace.store_seconds)),
        (0.4, lambda: restart_database(settings, server, pace.lock_seconds)),
        (0.6, lambda: restart_broker(settings)),
        (0.7, lambda: take_store_away(settings, pace.store_seconds)),
    ]
    while ended < jobs and time.monotonic() - begun < GIVE_UP_SECONDS:
        fleet.keep_up()
        if time.monotonic() - struck > pace.seconds and ended - met >= pace.jobs:
            fleet.kill_one()
            struck, met = time.monotonic(), ended
        if blows and ended >= blows[0][0] * jobs:
            blows.pop(0)[1]()
        with suppress(DatabaseUnreachable):
            states = count_states(database)
            ended = jobs - states.get("queued", 0) - states.get("running", 0)
        time.sleep(LOOK_SECONDS)
    seconds = time.monotonic() - begun
    fleet.stop()
    stop_broker(settings)
    wait_for_store(settings)
    return describe(database, jobs) | {
        "seconds": round(seconds, 1),
        "kills of parents": fleet.kills["parent"],
        "kills of children": fleet.kills["child"],
        "blows left": len(blows),
        "submit 95th percentile ms": round(1e3 * float(np.percentile(took, 95)), 1),
    }


def queue_all(database: Database, store: Store, folder: Path, jobs: int) -> list[float]:
    """Submit so many jobs of 0.1 s, and give how long each submission took [s]."""
    body, took = put_file(folder, "body.ply"), []
    for index in range(jobs):
        scan, begun = put_file(folder, f"short{index}.ply"), time.perf_counter()
        submit(database, store, Order(scan, body))
        took.append(time.perf_counter() - begun)
    return took


def describe(database: Database, jobs: int) -> dict[str, object]:
    """Count results, duplicates and losses."""
    with database.read() as session:
        states = dict(session.execute(select(JobRow.state, func.count()).group_by(JobRow.state)).all())
        wins = session.execute(
            select(EventRow.job, func.count()).where(EventRow.kind == "succeeded").group_by(EventRow.job)
        ).all()
        results = session.scalar(select(func.count()).select_from(ArtifactRow).where(ArtifactRow.kind == "result"))
        attempts = dict(session.execute(select(JobRow.attempts, func.count()).group_by(JobRow.attempts)).all())
        rests = session.scalar(select(func.count()).select_from(EventRow).where(EventRow.kind == "put_off"))
    return {
        "states": states,
        "results": results,
        "duplicates": sum(count - 1 for _, count in wins) + max(0, results - len(wins)),
        "lost": jobs - len(wins),
        "jobs by attempts": attempts,
        "rests for the store": rests,
    }


def main() -> int:
    """Run one kind of database; exit status 0 where nothing was lost and nothing done twice."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--database", choices=["sqlite", "postgresql"], default="sqlite")
    parser.add_argument("--jobs", type=int, default=1000)
    parser.add_argument("--workers", type=int, default=4)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    server = PostgresServer() if given.database == "postgresql" else None
    with tempfile.TemporaryDirectory(prefix="gq-chaos-", ignore_cleanup_errors=True) as home:
        address = server.url if server else ""
        settings = make_settings(Path(home), database_url=address, lease_seconds=4.0, max_attempts=10)
        start = partial(start_by_command, settings)
        found = run(settings, start, given.jobs, given.workers, given.seed, Pace(), server)
    if server:
        server.end()
    for name, value in {"database": given.database, **found}.items():
        sys.stdout.write(f"{name:28} {value}\n")
    return int(found["results"] != given.jobs or bool(found["duplicates"]) or bool(found["lost"]))


if __name__ == "__main__":
    sys.exit(main())
