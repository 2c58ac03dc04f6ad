"""Faults R7 to R19 that need no worker process, on SQLite and on PostgreSQL; metrics, logs and the live view."""

from __future__ import annotations

import json
import logging
import resource
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from garmentq.service.database import Database
from garmentq.service.families import JobNotEnded, cancel, retry
from garmentq.service.jobs import Claim, FenceLost, claim, claim_next, end_cancelled, find_job, read_events
from garmentq.service.kinds.recover import Recover
from garmentq.service.logs import JsonLines
from garmentq.service.metrics import prometheus_text
from garmentq.service.models import ArtifactRow, JobRow
from garmentq.service.reaper import reap, record_heartbeat, release_lost_leases
from garmentq.service.results import load_checkpoint, save_checkpoint, store_result
from garmentq.service.store import StorageFull
from garmentq.service.submission import Order, submit
from garmentq.workers.recovery import make_hooks, run_job
from garmentq.workers.watch import LeaseKeeper
from garmentq_home import put_file, wait_for
from garmentq_standin import make_recovery
from sqlalchemy import func, select, text


def never() -> bool:
    """Never drain."""
    return False


def hooks_of(database, store, held):
    """Return a claim's hooks without a running watch."""
    return make_hooks(database, store, held, LeaseKeeper(database, held, 30.0, 1.0, 60.0, never))


def test_r6_a_database_that_stays_away_for_a_lease(database, queue_job, tmp_path):
    """Broken where an outage longer than a lease ends a job, or it computes without an end."""
    held = claim(database, queue_job(), "a", 30.0)
    away = Database(f"sqlite:///{tmp_path / 'no' / 'such' / 'folder.db'}", pooled=False)
    began = time.monotonic()
    with LeaseKeeper(away, held, 0.2, 0.05, 1.0, never) as watch:
        wait_for(watch.must_stop)
    assert watch.reason == "too_long" and time.monotonic() - began > 1.0


def test_r7_a_locked_database_is_waited_for(settings, database, queue_job, database_kind):
    """Broken where another process's long write gives `database is locked`: the driver's default gives up after 5 s."""
    job = queue_job()
    hold = {
        "sqlite": "from sqlite3 import connect\nc = connect(sys.argv[1])\nc.execute('begin exclusive')\n",
        "postgresql": "from psycopg import connect\nc = connect(sys.argv[1])\nc.execute('lock jobs')\n",
    }[database_kind]
    code = f"import sys\n{hold}print('held', flush=True)\nsys.stdin.readline()\nc.rollback()\nc.close()\n"
    address = settings.database_url.replace("+psycopg", "") or str(settings.home / "garmentq.db")
    pipe = subprocess.PIPE
    with (
        subprocess.Popen([sys.executable, "-c", code, address], stdin=pipe, stdout=pipe, text=True) as holder,
        ThreadPoolExecutor(1) as pool,
    ):
        assert holder.stdout.readline() == "held\n"
        claimed = pool.submit(claim, database, job, "a", 30.0)
        with pytest.raises(TimeoutError):
            claimed.result(1.0)
        holder.stdin.write("\n")
        holder.stdin.flush()
        assert claimed.result(60.0) is not None
    if database_kind == "sqlite":
        with database.read() as session:
            assert session.execute(text("pragma busy_timeout")).scalar() >= 20_000, "as long as 20 s"


def test_r8_a_full_disk(settings, database, store, queue_job):
    """Broken where a full disk leaves half a file, loses the checkpoint before, or shows a traceback."""
    held = claim(database, queue_job(), "a", 30.0)
    save_checkpoint(database, store, held, "drape", b"old")
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4 << 20, limits[1]))
    try:
        with pytest.raises(StorageFull):
            save_checkpoint(database, store, held, "drape", bytes(8 << 20))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert load_checkpoint(database, store, held.job, "drape") == b"old"
    assert not list((settings.store_path / "incoming").iterdir())


def test_r10_fifty_equal_submits(database, store, tmp_path):
    """Broken where two submits of the same at the same time make two jobs, or one of them fails."""
    order = Order(put_file(tmp_path, "same.ply"), put_file(tmp_path, "body.ply"))
    with ThreadPoolExecutor(10) as pool:
        jobs = {submitted.job for submitted in pool.map(lambda _: submit(database, store, order), range(50))}
    assert len(jobs) == 1
    with database.read() as session:
        assert session.scalar(select(func.count()).select_from(JobRow)) == 1


def test_r11_cancel_in_each_state(database, store, queue_job, tmp_path):
    """Broken where a cancelled job runs, or one ends twice."""
    queued, finishing = queue_job("one"), queue_job("two")
    assert cancel(database, queued) == "cancelled" and claim(database, queued, "a", 30.0) is None
    held = claim(database, finishing, "a", 30.0)
    assert cancel(database, finishing) == "running"
    outcomes = []

    def end(action):
        try:
            action()
            outcomes.append(action)
        except FenceLost:
            pass

    recovery = make_recovery_of(tmp_path)
    (tmp_path / "files").mkdir()
    actions = [
        lambda: end_cancelled(database, held),
        lambda: store_result(database, store, held, Recover(), recovery, tmp_path / "files"),
    ]
    threads = [threading.Thread(target=end, args=(action,)) for action in actions]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert len(outcomes) == 1, "either ending, never both"
    assert cancel(database, finishing) in ("cancelled", "succeeded")
    retry(database, queued)
    with pytest.raises(JobNotEnded):
        retry(database, queued)


def make_recovery_of(folder):
    """Make the stand-in's recovery."""
    from garmentq.core.recover.recovery import Request

    return make_recovery(Request(folder / "shirt.ply"), 1.0)


def test_r12_the_workers_clock_does_not_matter(database, queue_job, monkeypatch):
    """Broken where a worker's clock, an hour off, makes a lease end early or never."""
    job = queue_job()
    for shift in (3600.0, -3600.0):
        real = time.time
        monkeypatch.setattr(time, "time", lambda shift=shift, real=real: real() + shift)
        held = claim(database, job, "a", 0.3)
        assert reap(database, 9) == 0
        wait_for(lambda: reap(database, 9) == 1)
        monkeypatch.undo()
    assert held.attempt == 2


def test_r14_a_crash_between_store_and_database(database, store, queue_job, tmp_path):
    """Broken where a second run of the same would keep the same bytes twice, or name the lost ones."""
    held = claim(database, queue_job(), "a", 30.0)
    orphan = store.put_bytes(b"result")
    (tmp_path / "files").mkdir()
    (tmp_path / "files" / "out.txt").write_bytes(b"result")
    with database.read() as session:
        assert session.scalar(select(func.count()).select_from(ArtifactRow)) == 0
    store_result(database, store, held, Recover(), make_recovery_of(tmp_path), tmp_path / "files")
    with database.read() as session:
        assert session.scalars(select(ArtifactRow.sha256)).all() == [orphan.sha256]


def test_r15_a_request_of_an_older_version(settings, database, queue_job):
    """Broken where a job that an older version queued ends in a traceback: a new key is missing, an old one is left."""
    old, odd = queue_job("old"), queue_job("odd")
    with database.write() as session:
        row = session.get(JobRow, old)
        row.request = {name: value for name, value in row.request.items() if name != "labels"}
        row = session.get(JobRow, odd)
        row.request = row.request | {"settings": row.request["settings"] | {"gone": 1}}
    results = [run_job(settings, database, old, never) for _ in range(2)]
    assert sorted(results) == ["failed", "succeeded"]
    assert find_job(database, odd).error_code and find_job(database, odd).error_message


def test_r17_a_damaged_checkpoint(database, store, queue_job):
    """Broken where flipped bits reach a stage, or the checkpoint before the damaged one is not found."""
    held = claim(database, queue_job(), "a", 30.0)
    hooks = hooks_of(database, store, held)
    for step in (1, 2, 3):
        hooks.save_checkpoint("fit", {"step": np.array(step)})
    with database.read() as session:
        kept = {row.kind: row.sha256 for row in session.scalars(select(ArtifactRow))}
    assert set(kept) == {"checkpoint", "checkpoint.1"}, "two are kept, no more"
    assert hooks.load_checkpoint("fit")["step"] == 3
    for kind, left in (("checkpoint", 2), ("checkpoint.1", None)):
        path = store.path(kept[kind])
        content = bytearray(path.read_bytes())
        content[len(content) // 2] ^= 1
        path.write_bytes(bytes(content))
        found = hooks.load_checkpoint("fit")
        assert (found is None) if left is None else found["step"] == left


@pytest.mark.nightly
@pytest.mark.parametrize("database_kind", ["sqlite"], indirect=True)
def test_r18_memory_over_a_hundred_jobs(settings, database, queue_job):
    """Broken where each job leaves something behind in its process; which database it asks is no matter to that."""

    def resident() -> float:
        with open("/proc/self/statm", encoding="ascii") as stream:
            return int(stream.read().split()[1]) * resource.getpagesize() / 2**20

    sizes = []
    for index in range(130):
        job = queue_job(f"shirt{index}")
        assert run_job(settings, database, job, never) == "succeeded"
        sizes.append(resident())
    assert sizes[-1] < 1.05 * sizes[29]


def test_most_urgent_first_and_a_known_death(database, queue_job):
    """Broken where a wake-up is bound to its job, or a known death waits for the lease."""
    low, high, other = queue_job("low"), queue_job("high", priority=5), queue_job("gpu", queue="gpu", priority=9)
    held = claim_next(database, low, "host:1:abc", 600.0)
    assert isinstance(held, Claim) and held.job == high
    release_lost_leases(database, "abc", "signal 11 (SIGSEGV)")
    assert reap(database, 1) == 1
    assert "SIGSEGV" in find_job(database, high).error_message
    assert claim_next(database, high, "b", 30.0).job == low
    assert claim_next(database, low, "b", 30.0) is None and find_job(database, other).state == "queued"
    assert claim_next(database, "unknown", "b", 30.0) is None
    assert [event.kind for event in read_events(database, high)] == ["queued", "started", "worker_lost", "dead"]


def test_metrics_read_back(settings, database, queue_job):
    """Broken where Prometheus cannot read the text, or a number is not the database's."""
    from prometheus_client.parser import text_string_to_metric_families

    jobs = [queue_job(f"shirt{i}") for i in range(3)]
    assert run_job(settings, database, jobs[0], never) == "succeeded"
    record_heartbeat(database, 'a"b\\c', "cpu,gpu", 4, 30.0)
    families = {family.name: family for family in text_string_to_metric_families(prometheus_text(database))}
    values = {(s.name, tuple(s.labels.values())): s.value for family in families.values() for s in family.samples}
    assert values["garmentq_jobs", ("queued", "cpu")] == 2 and values["garmentq_jobs", ("succeeded", "cpu")] == 1
    assert values["garmentq_worker_slots", ()] == 4 and values["garmentq_workers", ()] == 1
    assert values["garmentq_attempts_total", ()] == 1 and values["garmentq_leases_expired_total", ()] == 0
    assert values["garmentq_stage_seconds", ("deform",)] == pytest.approx(0.01)
    assert 0.0 <= values["garmentq_queue_age_seconds", ("cpu",)] < 600.0


def test_a_log_line_is_one_json_object():
    """Broken where a name with a newline begins a line of its own, or job, attempt and stage are missing."""
    line = logging.LogRecord("a", logging.INFO, __file__, 1, "job %s", ("x\n{}",), None)
    line.__dict__.update(job="j1", attempt=2, stage="drape")
    written = JsonLines().format(line)
    assert "\n" not in written
    found = json.loads(written)
    assert (found["job"], found["attempt"], found["stage"], found["message"]) == ("j1", 2, "drape", "job x\n{}")


@pytest.mark.parametrize("database_kind", ["sqlite"], indirect=True)
def test_status_csv_and_batch(cli, settings, database, queue_job, tmp_path):
    """Broken where the live table does not draw, or a cell that begins like a formula reaches a spreadsheet as one."""
    import csv
    import io

    job = queue_job()
    assert run_job(settings, database, job, never) == "succeeded"
    with database.write() as session:
        session.get(JobRow, job).name = "=cmd()\n1"
    record_heartbeat(database, "host:1", "cpu", 2, 30.0)
    shown = cli("status", "--watch").stdout
    assert "succeeded 1" in shown and "host:1" in shown
    rows = list(csv.DictReader(io.StringIO(cli("query", "--csv", "--columns", "all").stdout)))
    assert [(row["job"], row["name"]) for row in rows] == [(job, "'=cmd()?1")]
    assert float(rows[0]["surface_rms_mm.t2s"]) == 5.0
