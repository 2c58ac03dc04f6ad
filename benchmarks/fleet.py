"""A fleet of a thousand workers on PostgreSQL, simulated: claims, load of the database, hot rows, store requests.

    python benchmarks/fleet.py [--workers 1000] [--seconds 600]
    python benchmarks/fleet.py --profile HOME       # what the jobs of a home did: the figures of a job

First the operations of a worker are measured on a real server with a long queue: CPU time of the server's processes and
number of statements. Then events of a fleet are simulated with these costs: the server is a queue before some cores,
each statement takes a round trip on the network, a commit waits for the disk, and transactions that write one row wait
for each other.
"""

from __future__ import annotations

import argparse
import heapq
import os
import tempfile
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from garmentq.service.database import Database, open_database
from garmentq.service.jobs import Claim, claim_next, read_flags, renew, succeed
from garmentq.service.models import ArtifactRow, EventRow, JobRow, MetricRow, OutboxRow, ScanRow
from garmentq.service.progress import Progress, report
from garmentq.service.reaper import acquire_leader_lease, dispatch, record_heartbeat
from garmentq.service.results import CHECKPOINT, PREVIOUS, RESULT, save_checkpoint
from garmentq.service.settings import ServiceSettings
from garmentq.service.store import Store
from service_load import fresh_settings
from sqlalchemy import event, func, insert, select, text

REPEATS = 1000
CLOCK_TICKS = os.sysconf("SC_CLK_TCK")
KEYS = 20
QUEUED_JOBS = 10_000


@dataclass(frozen=True)
class JobProfile:
    """Describe what an average job of a fleet does.

    Attributes:
        seconds: Time that it takes a worker [s].
        reports: Number of reports of progress.
        checkpoints: Number of checkpoints.
        files: Number of files that it reads from the store, or writes into it as its result.
        metrics: Number of metrics of its result.
    """

    seconds: float
    reports: int
    checkpoints: int
    files: int
    metrics: int


@dataclass(frozen=True)
class Cost:
    """Describe one transaction.

    Attributes:
        cpu: Time of the server's processes [s].
        trips: Number of round trips, with those for the beginning and the end of the transaction.
        is_write: Whether the commit waits for the disk.
        row: Name of a row that others write too; empty: none. The lock lasts from half of the transaction to its end.
    """

    cpu: float
    trips: int
    is_write: bool
    row: str = ""


@dataclass(frozen=True)
class Site:
    """Describe the machines of a fleet.

    Attributes:
        workers: Number of processes that run jobs.
        per_host: Number of them below one parent, which sends heartbeats.
        cores: Number of cores of the database's server.
        trip: Time of one round trip on the network [s].
        flush: Time for which a commit waits for the disk [s].
        poll: Interval of a job's looks at its cancel flag, and of the dispatcher's rounds [s].
        beat: Interval of the renewals of a job's lease [s].
        lease: Interval at which a parent looks whether the dispatcher's lease is free [s].
    """

    workers: int
    per_host: int = 8
    cores: int = 4
    trip: float = 0.5e-3
    flush: float = 2e-3
    poll: float = 0.5
    beat: float = 7.5
    lease: float = 2.5


def read_cpu(data: Path) -> float:
    """Return the CPU time of a PostgreSQL server and of all its processes that have ended or run [s]."""
    parent = int((data / "postmaster.pid").read_text().split()[0])
    total = 0
    for process in Path("/proc").glob("[0-9]*"):
        try:
            fields = (process / "stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(process.name) == parent:
            total += sum(int(value) for value in fields[11:15])
        elif int(fields[1]) == parent:
            total += int(fields[11]) + int(fields[12])
    return total / CLOCK_TICKS


def measure(database: Database, data: Path, ask: Callable[[int], object], is_write: bool, row: str = "") -> Cost:
    """Return the cost of one transaction, averaged over many."""
    trips = Counter[str]()

    def count(*_: Any) -> None:
        trips["all"] += 1

    ask(0)
    names = ("before_cursor_execute", "begin", "commit", "rollback")
    for name in names:
        event.listen(database.engine, name, count)
    before = read_cpu(data)
    for index in range(1, REPEATS + 1):
        ask(index)
    spent = read_cpu(data) - before
    for name in names:
        event.remove(database.engine, name, count)
    return Cost(spent / REPEATS, round(trips["all"] / REPEATS), is_write, row)


def fill(database: Database) -> None:
    """Add a long queue of several keys."""
    with database.write() as session:
        scan = {"sha256": "0" * 64, "name": "s.ply", "size": 1, "created": 0.0, "details": {}}
        session.execute(insert(ScanRow), [scan])
        ids = [f"{index:012x}" for index in range(QUEUED_JOBS)]
        session.execute(insert(JobRow), [
            {"id": job, "dedup": job, "scan": "0" * 64, "name": "s", "request": {"settings": {"method": "hybrid"}},
             "version": "0", "priority": 0, "payer": f"key{index % KEYS:02d}", "state": "queued", "cancel": False,
             "attempts": 0, "fence": 0, "touched": 0.0, "created": float(index), "stage": "", "progress": 0.0,
             "bad_input": False} for index, job in enumerate(ids)
        ])  # fmt: skip
        session.execute(insert(OutboxRow), [{"job": job, "created": 0.0} for job in ids])
        session.execute(text("analyze"))


def measure_all(settings: ServiceSettings, profile: JobProfile) -> dict[str, Cost]:
    """Return the cost of each operation of a worker, on a server with a long queue."""
    database = open_database(settings)
    with database.read() as session:
        data = Path(str(session.scalar(text("show data_directory"))))
    fill(database)
    claims: list[Claim] = []

    def claim(_: int) -> None:
        found = claim_next(database, f"{QUEUED_JOBS - 1:012x}", "host:1:x", 600.0)
        claims.append(found) if found else None

    store = Store(Path(tempfile.mkdtemp(prefix="gq-fleet-")))
    content = os.urandom(1000)

    def save(_: int) -> None:
        save_checkpoint(database, store, claims[0], "c", content)

    def end(index: int) -> None:
        job = claims[index].job
        metrics = [{"job": job, "name": f"m{number}", "value": 1.0} for number in range(profile.metrics)]
        files = [
            {"job": job, "kind": RESULT, "name": f"f{number}", "sha256": "0" * 64, "size": 1, "created": 0.0}
            for number in range(profile.files)
        ]
        with database.write() as session:
            succeed(session, claims[index], {"stage_seconds": {"fit": 1.0}})
            session.execute(insert(MetricRow), metrics)
            session.execute(insert(ArtifactRow), files)

    progress = Progress("fit", 0.5, "step 12 of 40", 0.4, 20.0)
    parent = Database(settings.database, pooled=False)
    acquire_leader_lease(database, "dispatcher", "leader", 600.0)
    costs = {
        "claim": measure(database, data, claim, True, "payer"),
        "look": measure(database, data, lambda _: read_flags(database, claims[0]), False),
        "renew": measure(database, data, lambda _: renew(database, claims[0], 600.0), True),
        "report": measure(database, data, lambda _: report(database, claims[0], progress), True),
        "checkpoint": measure(database, data, save, True),
        "end": measure(database, data, end, True),
        "lease": measure(parent, data, lambda _: acquire_leader_lease(parent, "dispatcher", "other", 600.0), False),
        "heartbeat": measure(parent, data, lambda _: record_heartbeat(parent, "other", "cpu", 8, 30.0), True),
        "dispatch": measure(database, data, lambda _: dispatch(database, lambda job, queue: None), True),
    }  # fmt: skip
    parent.dispose()
    database.dispose()
    return costs


def read_profile(settings: ServiceSettings) -> list[tuple[str, JobProfile]]:
    """Return what the succeeded jobs of a home did, each with its kind."""
    database = open_database(settings)
    found = []
    with database.read() as session:
        for row in session.scalars(select(JobRow).where(JobRow.state == "succeeded")):

            def count(table: Any, *conditions: Any, job: str = row.id) -> int:
                return session.scalar(select(func.count()).select_from(table).where(table.job == job, *conditions)) or 0

            saved = count(EventRow, EventRow.kind == "progress")
            kept = count(ArtifactRow, ArtifactRow.kind.in_((CHECKPOINT, PREVIOUS)))
            profile = JobProfile((row.finished or 0.0) - (row.started or 0.0), saved, kept,
                                 count(ArtifactRow, ArtifactRow.kind == RESULT), count(MetricRow))  # fmt: skip
            found.append((row.kind, profile))
    database.dispose()
    return found


class Server:
    """Serve transactions: some cores in the order of arrival, and a lock for each row that several write."""

    def __init__(self, site: Site) -> None:
        """Start with every core free."""
        self.site, self.free, self.rows = site, [0.0] * site.cores, Counter[str]()
        self.busy, self.waits = 0.0, Counter[str]()

    def run(self, at: float, cost: Cost, row: str) -> float:
        """Return the time at which a transaction that begins at a time has ended [s]."""
        core = heapq.heappop(self.free)
        begun = max(core, at)
        heapq.heappush(self.free, begun + cost.cpu)
        self.busy += cost.cpu
        rest = cost.trips * self.site.trip + (self.site.flush if cost.is_write else 0.0)
        end = begun + cost.cpu + rest
        if row:
            locked = max(self.rows[row], begun + rest / 2)
            self.waits[row] += locked - (begun + rest / 2)
            end = locked + cost.cpu + rest / 2
            self.rows[row] = end
        return end


@dataclass
class Found:
    """Describe a simulated fleet: counts and times of the transactions by name."""

    counts: Counter[str]
    times: dict[str, list[float]]
    server: Server


def simulate(site: Site, costs: dict[str, Cost], profile: JobProfile, seconds: float) -> Found:
    """Simulate a busy fleet: the queue is never empty, and each worker claims as soon as its job has ended."""
    rng = np.random.default_rng(0)
    server, found = Server(site), Found(Counter(), {name: [] for name in costs}, None)  # type: ignore[arg-type]
    found.server = server
    events: list[tuple[float, int, str, int]] = []

    def add(at: float, name: str, worker: int) -> None:
        heapq.heappush(events, (at, len(found.counts) + worker, name, worker))

    ends = np.zeros(site.workers)
    intervals = {"look": site.poll, "renew": site.beat, "report": profile.seconds / profile.reports,
                 "checkpoint": profile.seconds / max(profile.checkpoints, 1)}  # fmt: skip
    for worker in range(site.workers):
        ends[worker] = rng.uniform(0.0, profile.seconds)  # in the middle of a job
        add(ends[worker], "end", worker)
        for name, interval in intervals.items():
            add(rng.uniform(0.0, interval), name, worker)
    for host in range(site.workers // site.per_host):
        add(rng.uniform(0.0, site.lease), "lease", host)
        add(rng.uniform(0.0, 5.0), "heartbeat", host)
    add(0.0, "dispatch", 0)
    periods = intervals | {"lease": site.lease, "heartbeat": 5.0, "dispatch": site.poll}
    while events and events[0][0] < seconds:
        at, _, name, worker = heapq.heappop(events)
        row = costs[name].row and costs[name].row + (str(rng.integers(KEYS)) if name == "claim" else "")
        done = server.run(at, costs[name], row)
        found.counts[name] += 1
        found.times[name].append(done - at)
        if name == "end":
            add(done, "claim", worker)
        elif name == "claim":
            add(done + profile.seconds * rng.lognormal(-0.08, 0.4), "end", worker)  # mean 1, a third shorter or longer
        else:
            add(max(done, at + periods[name]), name, worker)
    return found


def show(site: Site, found: Found, profile: JobProfile, seconds: float) -> None:
    """Print what a simulated fleet asked of its database and its store."""
    server, counts = found.server, found.counts
    writes = sum(count for name, count in counts.items() if name not in ("look",)) / seconds
    store = counts["end"] / seconds * (profile.files + profile.checkpoints)
    claims, ends = np.array(found.times["claim"]), np.array(found.times["end"])
    print(
        f"{site.workers:6d} workers: {counts['claim'] / seconds:.1f} claims/s, claim {1000 * np.median(claims):.0f} ms,"
        f" 95 % {1000 * np.percentile(claims, 95):.0f}; end 95 % {1000 * np.percentile(ends, 95):.0f} ms; "
        f"{sum(counts.values()) / seconds:.0f} transactions/s, {writes:.0f} of them write; "
        f"server {100 * server.busy / seconds / site.cores:.0f} % of {site.cores} cores; store {store:.0f} requests/s; "
        f"waits for hot rows {', '.join(f'{n} {1000 * w / seconds:.0f} ms/s' for n, w in _sum(server.waits).items())}"
    )
    shares = {name: count / seconds for name, count in counts.most_common()}
    print("        per second: " + ", ".join(f"{name} {rate:.0f}" for name, rate in shares.items()))


def _sum(waits: Counter[str]) -> dict[str, float]:
    total = Counter[str]()
    for name, seconds in waits.items():
        total["payer" if name.startswith("payer") else name] += seconds
    return dict(total)


def main() -> None:
    """Measure the operations, simulate fleets of several sizes."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--workers", type=int, nargs="*", default=[100, 1000, 3000, 10000])
    parser.add_argument("--seconds", type=float, default=300.0)
    parser.add_argument("--cores", type=int, default=4)
    parser.add_argument("--profile", type=Path, metavar="HOME")
    parser.add_argument("--job", type=float, nargs=5, default=(100.0, 57, 14, 18, 170),
                        metavar=("SECONDS", "REPORTS", "CHECKPOINTS", "FILES", "METRICS"))  # fmt: skip
    chosen = parser.parse_args()
    if chosen.profile:
        for kind, found in read_profile(ServiceSettings(home=chosen.profile)):
            print(kind, found)
        return
    profile = JobProfile(chosen.job[0], *(int(value) for value in chosen.job[1:]))
    with fresh_settings("postgresql") as settings:
        costs = measure_all(settings, profile)
    for name, cost in costs.items():
        print(f"{name:11s} {1000 * cost.cpu:6.2f} ms of the server's CPU, {cost.trips} round trips")
    for count in chosen.workers:
        site = replace(Site(count), cores=chosen.cores)
        show(site, simulate(site, costs, profile, chosen.seconds), profile, chosen.seconds)


if __name__ == "__main__":
    main()
