"""Faults R1 to R6, R13 and R19 with real workers and a real broker: nothing is lost, nothing is done twice."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import pytest
from garmentq.service.jobs import find_job, read_events
from garmentq.service.models import ArtifactRow
from garmentq.workers.broker import run_folder, start_broker
from garmentq_home import wait_ended, wait_for
from sqlalchemy import func, select

WAIT_SECONDS = 90.0
"""A deadline that only a hang reaches, however loaded the machine is."""


@contextmanager
def worker(settings, *arguments, **changes):
    """Run a worker; what is left of it at the end is killed."""
    environment = {**os.environ, **replace(settings, **changes).as_environment()}
    command = [sys.executable, "-m", "garmentq.cli.main", "worker", "--workers", "1", *arguments]
    with (settings.home / "worker.log").open("ab") as log:
        process = subprocess.Popen(command, env=environment, stdout=log, stderr=log, start_new_session=True)
    try:
        yield process
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def kinds(database, job):
    """Give the kinds of a job's events that are no progress."""
    return [event.kind for event in read_events(database, job) if event.kind != "progress"]


def steps(path: Path):
    """Give (step, process) of every step that was really done."""
    lines = path.read_text().splitlines() if path.exists() else []
    return [(int(step), int(process)) for step, process in (line.split() for line in lines if len(line.split()) == 2)]


def count_results(database, job):
    """Count a job's result files."""
    with database.read() as session:
        wanted = (ArtifactRow.job == job) & (ArtifactRow.kind == "result")
        return session.scalar(select(func.count()).select_from(ArtifactRow).where(wanted))


@pytest.mark.slow
def test_r1_killed_child(settings, database, queue_job, marks):
    """Broken where a crash waits for the lease though the parent saw it, begins anew, or tells no signal."""
    start_broker(settings)
    job = queue_job("slow")
    with worker(settings, lease_seconds=600.0):
        wait_for(lambda: len(steps(marks)) > 7, WAIT_SECONDS)
        os.kill(steps(marks)[-1][1], signal.SIGKILL)
        row = wait_ended(settings, job, WAIT_SECONDS)
    assert (row.state, row.attempts, count_results(database, job)) == ("succeeded", 2, 1)
    assert len(steps(marks)) - 40 < 6, "only the work since the last checkpoint may be done again"
    [loss] = [event for event in read_events(database, job) if event.kind == "worker_lost"]
    assert "signal 9" in loss.data["reason"]


@pytest.mark.slow
def test_r2_killed_worker_and_r13_stopped_worker(settings, database, queue_job, marks):
    """Broken where a lost host needs a hand, or an orderly stop counts as a crash or waits for the job's end."""
    start_broker(settings)
    job = queue_job("slow")
    with worker(settings) as first:
        wait_for(lambda: len(steps(marks)) > 7, WAIT_SECONDS)
        os.killpg(first.pid, signal.SIGKILL)
        first.wait()
    with worker(settings) as second:
        before = len(steps(marks))
        wait_for(lambda: len(steps(marks)) > before + 3, WAIT_SECONDS)
        second.terminate()
        assert second.wait(timeout=WAIT_SECONDS) == 0
    row = find_job(database, job)
    assert (row.state, row.attempts) == ("queued", 1), "the kill counts, the stop does not"
    with worker(settings):
        row = wait_ended(settings, job, WAIT_SECONDS)
    assert (row.state, row.attempts, row.fence, count_results(database, job)) == ("succeeded", 2, 3, 1)
    assert kinds(database, job).count("succeeded") == 1
    assert {step for step, _ in steps(marks)} == set(range(40)) and len(steps(marks)) < 46


@pytest.mark.slow
def test_r3_poison_and_r13_deaf_job(settings, database, queue_job, marks):
    """Broken where a job that kills its worker is repeated for ever, harms others, or a deaf one holds up a deploy."""
    start_broker(settings)
    poison, leaver, good = queue_job("crash"), queue_job("leave"), queue_job("shirt")
    with worker(settings, grace_seconds=1.0, lease_seconds=20.0) as process:
        rows = [wait_ended(settings, job, WAIT_SECONDS) for job in (poison, leaver, good)]
        assert [(row.state, row.attempts) for row in rows] == [("dead", 3), ("dead", 3), ("succeeded", 1)]
        assert "signal 9" in rows[0].error_message and "exitcode 3" in rows[1].error_message
        deaf = queue_job("stuck")
        wait_for(lambda: find_job(database, deaf).state == "running", WAIT_SECONDS)
        process.terminate()
        process.wait(timeout=WAIT_SECONDS)
    assert (find_job(database, deaf).state, find_job(database, deaf).attempts) == ("queued", 0)


@pytest.mark.slow
def test_r4_zombie(settings, database, queue_job, marks):
    """Broken where a stopped process that wakes up after its lease writes over its successor."""
    start_broker(settings)
    job = queue_job("slow")
    with worker(settings), worker(settings):
        wait_for(lambda: len(steps(marks)) > 7, WAIT_SECONDS)
        zombie = steps(marks)[-1][1]
        os.kill(zombie, signal.SIGSTOP)
        wait_for(lambda: find_job(database, job).fence == 2, WAIT_SECONDS)
        os.kill(zombie, signal.SIGCONT)
        row = wait_ended(settings, job, WAIT_SECONDS)
    assert (row.state, row.attempts, row.fence, count_results(database, job)) == ("succeeded", 2, 2, 1)
    assert kinds(database, job).count("succeeded") == 1


@pytest.mark.slow
def test_r5_broker_killed_and_flushed(settings, database, queue_job, marks):
    """Broken where the broker's memory is needed for a submit, or for a job to be found."""
    import redis

    start_broker(settings)
    with worker(settings):
        first = [queue_job(f"short{i}") for i in range(4)]
        wait_ended(settings, first[0], WAIT_SECONDS)
        os.kill(int((run_folder(settings) / "broker.pid").read_text()), signal.SIGKILL)
        second = [queue_job(f"away{i}") for i in range(3)]
        time.sleep(0.5)
        start_broker(settings)
        client = redis.Redis(unix_socket_path=str(run_folder(settings) / "broker.sock"))
        client.flushall()
        client.close()
        rows = [wait_ended(settings, job, WAIT_SECONDS) for job in first + second]
    assert {row.state for row in rows} == {"succeeded"}
    assert all(kinds(database, row.id).count("started") == 1 for row in rows), "no job may start twice"


@pytest.mark.slow
def test_r6_database_cut_off(settings, database, queue_job, marks, database_kind):
    """Broken where a job fails because the database was away for less than its lease."""
    if database_kind == "sqlite":
        pytest.skip("SQLite has no server; R7 holds its lock")
    from sqlalchemy import text

    start_broker(settings)
    job = queue_job("slow")
    with worker(settings, lease_seconds=30.0):
        for cut in range(3):
            wait_for(lambda cut=cut: len(steps(marks)) > 5 + 8 * cut, WAIT_SECONDS)
            with database.write() as session:
                others = "select pg_terminate_backend(pid) from pg_stat_activity where pid <> pg_backend_pid()"
                session.execute(text(f"{others} and datname = current_database()"))
        row = wait_ended(settings, job, WAIT_SECONDS)
    assert (row.state, row.attempts) == ("succeeded", 1)


@pytest.mark.slow
def test_priorities_queues_and_three_dispatchers_r19(settings, database, queue_job, marks):
    """Broken where the broker's order decides, a worker takes what it does not serve, or a job starts twice."""
    start_broker(settings)
    jobs = [queue_job(f"short{i}", priority=i) for i in range(8)]
    other = queue_job("gpu", queue="gpu")
    with worker(settings, "--queues", "cpu"):
        rows = [wait_ended(settings, job, WAIT_SECONDS) for job in jobs]
        assert [row.id for row in sorted(rows, key=lambda row: row.started)] == jobs[::-1]
        assert find_job(database, other).state == "queued"
    with worker(settings), worker(settings), worker(settings):
        more = [queue_job(f"more{i}") for i in range(20)]
        rows = [wait_ended(settings, job, WAIT_SECONDS) for job in [other, *more]]
    assert {row.state for row in rows} == {"succeeded"}
    assert all(kinds(database, row.id).count("started") == 1 for row in rows)
