"""How long a free slot waits for its next job, at the head and at the tail of a long queue.

python benchmarks/service_starts.py [--database sqlite|postgresql] [--jobs 1000] [--slots 2]

The jobs take 0.1 s each (the stand-in of the tests). The delay of one start is from the `succeeded` event of a pool
child to the `started` event of its next job, both by the database's clock: end of the transaction, wake-up, claim.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "standin"))

from garmentq.service.database import Database, open_database
from garmentq.service.models import EventRow
from garmentq.service.query import count_states
from garmentq.service.store import Store
from garmentq.service.submission import Order, submit
from garmentq.workers.broker import start_broker, stop_broker
from garmentq_home import make_environment, make_settings, put_file
from postgres_server import PostgresServer
from sqlalchemy import select

PART = 10
"""Head and tail are a tenth of the queue each."""


def read_delays(database: Database) -> np.ndarray:
    """Return (time of start, delay) of every start but the first of each child [s], shape [n, 2], in order of time."""
    with database.read() as session:
        events = session.execute(
            select(EventRow.job, EventRow.kind, EventRow.at, EventRow.data)
            .where(EventRow.kind.in_(("started", "succeeded")))
            .order_by(EventRow.at)
        ).all()
    child, free, found = {}, {}, []
    for event in events:
        if event.kind == "started":
            child[event.job] = event.data["owner"].rsplit(":", 1)[0]
            if child[event.job] in free:
                found.append((event.at, event.at - free[child[event.job]]))
        else:
            free[child[event.job]] = event.at
    return np.array(found)


def measure(kind: str, jobs: int, slots: int) -> None:
    """Queue the jobs, then start one worker and wait for its end."""
    with tempfile.TemporaryDirectory() as folder:
        home = Path(folder)
        postgres = PostgresServer() if kind == "postgresql" else None
        settings = make_settings(home, database_url=postgres.url if postgres else "", lease_seconds=30.0)
        database, store = open_database(settings, pooled=False), Store(settings.store_path)
        body = put_file(home, "body.ply")
        for index in range(jobs):
            submit(database, store, Order(put_file(home, f"short{index}.ply"), body))
        start_broker(settings)
        command = [sys.executable, "-m", "garmentq.cli.main", "worker", "--workers", str(slots)]
        with open(os.devnull, "wb") as log:
            worker = subprocess.Popen(command, env=make_environment(settings), stdout=log, stderr=log)
        begun = time.monotonic()
        while count_states(database).get("succeeded", 0) < jobs and worker.poll() is None:
            time.sleep(0.5)
        seconds = time.monotonic() - begun
        worker.terminate()
        worker.wait(timeout=60)
        stop_broker(settings)
        delays, part = 1e3 * read_delays(database)[:, 1], jobs // PART
        database.dispose()
    for name, chosen in (("first", delays[:part]), ("all", delays), ("last", delays[-part:])):
        median, high, worst = np.percentile(chosen, [50, 95, 100])
        print(f"{kind}: {name:5} {len(chosen):4} starts of {jobs}: median {median:.0f} ms, "
              f"95th percentile {high:.0f} ms, longest {worst:.0f} ms")  # fmt: skip
    print(f"{kind}: {jobs} jobs of 0.1 s through {slots} slots in {seconds:.0f} s")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--database", choices=["sqlite", "postgresql"], default="sqlite")
    parser.add_argument("--jobs", type=int, default=1000)
    parser.add_argument("--slots", type=int, default=2)
    given = parser.parse_args()
    measure(given.database, given.jobs, given.slots)
