"""Faults R1 to R6, R13 and R19 with real workers and a real broker: nothing is lost, nothing is done twice.

No test asks how quick anything is. Jobs wait at a gate for the blow that is meant for them, and what a stall of the
machine may add (a lease that ran out under a healthy worker) breaks no assertion: attempts are compared with events.
"""

from __future__ import annotations

import asyncio
import gc
import os
import signal
from pathlib import Path

import httpx
import pytest
from garmentq.service.families import cancel
from garmentq.service.jobs import find_job, read_events
from garmentq.service.models import ArtifactRow
from garmentq.workers.broker import is_broker_up, run_folder, start_broker
from garmentq_home import SQLITE_BY_DAY, wait_ended, wait_for
from garmentq_standin import STEPS, hold_gate
from patience import WAIT_SECONDS
from sqlalchemy import func, select

LONG = {"lease_seconds": 600.0}
"""For what must work without any lease that runs out."""

SHORT = {"lease_seconds": 2.0, "max_attempts": 20}
"""For what waits for a lease; a machine that stalls for longer may let healthy ones run out too."""


def kinds(database, job):
    """Return the kinds of a job's events that are no progress."""
    return [event.kind for event in read_events(database, job) if event.kind != "progress"]


def steps(path: Path):
    """Return (step, process) of every step that was really done."""
    lines = path.read_text().splitlines() if path.exists() else []
    return [(int(step), int(process)) for step, process in (line.split() for line in lines if len(line.split()) == 2)]


def count_results(database, job):
    """Count a job's result files."""
    with database.read() as session:
        wanted = (ArtifactRow.job == job) & (ArtifactRow.kind == "result")
        return session.scalar(select(func.count()).select_from(ArtifactRow).where(wanted))


def wait_steps(path: Path, count: int):
    """Wait until so many steps were done, and give them."""
    wait_for(lambda: len(steps(path)) >= count)
    return steps(path)


def check_once(database, row):
    """Check that a job ended well, once, and that each attempt that counts has its `started` event."""
    happened = kinds(database, row.id)
    assert row.state == "succeeded" and happened.count("succeeded") == 1 and count_results(database, row.id) == 1
    uncounted = happened.count("released") + happened.count("attempt_returned")
    assert row.fence == happened.count("started") and row.attempts == row.fence - uncounted


def ask(app, path: str):
    """Ask the HTTP API once, as the local user."""
    key = {"authorization": f"Bearer {app.state.rooms.local_token}"}

    async def get():
        transport = httpx.ASGITransport(app)
        async with httpx.AsyncClient(transport=transport, base_url="http://127.0.0.1", headers=key) as client:
            return await client.get(path)

    return asyncio.run(get())


def left_folders(settings, job: str) -> list[Path]:
    """Return the folders of a job's attempts that are still there."""
    return list((settings.home / "work").glob(f"{job}-*"))


@SQLITE_BY_DAY
@pytest.mark.slow
def test_r1_killed_child(settings, database, queue_job, start_worker, marks):
    """Broken where a crash that the parent saw waits for the lease, begins anew, tells no signal or leaves files."""
    start_broker(settings)
    hold_gate(marks, 8)
    job = queue_job("gated")
    with start_worker(**LONG):
        os.kill(wait_steps(marks, 8)[-1][1], signal.SIGKILL)
        hold_gate(marks, STEPS)
        row = wait_ended(settings, job)
        # no attempt's folder stays; the last one's goes after the job's state is written, before this worker is killed
        wait_for(lambda: not left_folders(settings, job))
    assert (row.state, row.attempts, count_results(database, job)) == ("succeeded", 2, 1)
    assert [step for step, _ in steps(marks)] == [*range(8), *range(5, STEPS)], "from the last checkpoint on"
    [loss] = [event for event in read_events(database, job) if event.kind == "worker_lost"]
    assert "signal 9" in loss.data["reason"]
    assert not left_folders(settings, job), "the killed attempt's folder must be gone"


@SQLITE_BY_DAY
@pytest.mark.slow
def test_r2_killed_worker_and_r13_stopped_worker(settings, database, queue_job, start_worker, marks):
    """Broken where a lost host needs a hand, or an orderly stop counts as a crash or waits for the job's end."""
    start_broker(settings)
    hold_gate(marks, 8)
    job = queue_job("gated")
    with start_worker(**SHORT) as first:
        wait_steps(marks, 8)
        os.killpg(first.pid, signal.SIGKILL)
        first.wait()
    hold_gate(marks, 16)
    with start_worker(**LONG) as second:
        wait_for(lambda: steps(marks)[-1][0] == 15)
        second.terminate()
        assert second.wait(timeout=WAIT_SECONDS) == 0
    row = find_job(database, job)
    lost = kinds(database, job).count("lease_expired")
    assert (row.state, row.attempts) == ("queued", lost) and lost > 0, "the kill counts, the stop does not"
    hold_gate(marks, STEPS)
    with start_worker(**LONG):
        check_once(database, wait_ended(settings, job))
    done = [step for step, _ in steps(marks)]
    assert done[-24:] == list(range(16, STEPS)), "the stop kept the very step"
    assert set(done) == set(range(STEPS)) and len(done) <= STEPS + 3 * lost, "a crash costs what no checkpoint has"


@SQLITE_BY_DAY
@pytest.mark.slow
def test_r3_poison_and_r13_deaf_job(settings, database, queue_job, start_worker, marks):
    """Broken where a job that kills its worker is repeated for ever, harms others, or a deaf one holds up a deploy."""
    start_broker(settings)
    poison, leaver, good = queue_job("crash"), queue_job("leave"), queue_job("shirt")
    with start_worker(grace_seconds=0.5, max_attempts=2, **LONG) as process:
        rows = [wait_ended(settings, job) for job in (poison, leaver, good)]
        assert [(row.state, row.attempts) for row in rows] == [("dead", 2), ("dead", 2), ("succeeded", 1)]
        assert "signal 9" in rows[0].error_message and "exitcode 3" in rows[1].error_message
        deaf = queue_job("deaf")
        wait_for(lambda: find_job(database, deaf).state == "running")
        process.terminate()
        process.wait(timeout=WAIT_SECONDS)
    assert (find_job(database, deaf).state, find_job(database, deaf).attempts) == ("queued", 0)


@pytest.mark.slow
def test_a_cancelled_job_leaves_its_process(settings, database, queue_job, start_worker, marks):
    """Broken where a job that never asks whether it must stop costs its process, and the log a traceback."""
    start_broker(settings)
    stuck = queue_job("stuck")
    with start_worker(grace_seconds=20.0, **LONG):  # interrupted after half of it, however loaded the machine is
        wait_for(lambda: find_job(database, stuck).state == "running")
        process = find_job(database, stuck).owner.split(":")[1]
        cancel(database, stuck)
        row = wait_ended(settings, stuck)
        next_one = wait_ended(settings, queue_job("shirt"))
    assert (row.state, row.attempts, next_one.state) == ("cancelled", 1, "succeeded"), next_one.error_message
    owners = [
        event.data["owner"].split(":")[1] for event in read_events(database, next_one.id) if event.kind == "started"
    ]
    assert owners == [process], "another process had to be started"
    assert "Traceback" not in (settings.home / "worker.log").read_text(encoding="utf-8", errors="replace")


@SQLITE_BY_DAY
@pytest.mark.slow
def test_r4_zombie(settings, database, queue_job, start_worker, marks):
    """Broken where a stopped process that wakes up after its lease writes over its successor."""
    start_broker(settings)
    hold_gate(marks, 8)
    job = queue_job("gated")
    with start_worker(**SHORT), start_worker(**SHORT):
        zombie = wait_steps(marks, 8)[-1][1]
        os.kill(zombie, signal.SIGSTOP)
        wait_for(lambda: any(process != zombie for _, process in steps(marks)))
        hold_gate(marks, STEPS)  # both may go on: one of them must not write
        os.kill(zombie, signal.SIGCONT)
        check_once(database, wait_ended(settings, job))
        wait_for(lambda: f"job {job}: lost" in (settings.home / "worker.log").read_text())
    assert count_results(database, job) == 1 and kinds(database, job).count("attempt_returned") == 1, "it did not die"


@SQLITE_BY_DAY
@pytest.mark.slow
def test_r5_broker_killed_and_flushed(settings, database, queue_job, start_worker, marks):
    """Broken where the broker's memory is needed for a submit, or for a job to be found."""
    import redis

    start_broker(settings)
    with start_worker(republish_seconds=0.5, **LONG):
        first = [queue_job(f"short{i}") for i in range(3)]
        wait_ended(settings, first[0])
        os.kill(int((run_folder(settings) / "broker.pid").read_text()), signal.SIGKILL)
        wait_for(lambda: not is_broker_up(settings))
        second = [queue_job(f"away{i}") for i in range(2)]
        start_broker(settings)
        client = redis.Redis(unix_socket_path=str(run_folder(settings) / "broker.sock"))
        client.flushall()
        client.close()
        rows = [wait_ended(settings, job) for job in first + second]
    assert {row.state for row in rows} == {"succeeded"}
    assert all(kinds(database, row.id).count("started") == 1 for row in rows), "no job may start twice"


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*was deleted while still open:ResourceWarning")  # its server went away under it
@pytest.mark.parametrize("database_kind", ["postgresql"], indirect=True)  # SQLite has no server; see R7
def test_r6_the_database_server_stops_and_starts(
    settings, database, queue_job, start_worker, marks, postgres_server, request
):
    """Broken where a job fails because the server was away for less than its lease, or a user sees a traceback."""
    from garmentq.service.api.app import make_app

    start_broker(settings)
    hold_gate(marks, 8)
    job = queue_job("gated")
    app = make_app(settings)
    request.addfinalizer(app.state.rooms.database.dispose)
    with start_worker(**LONG):
        for gate in (8, 22):
            hold_gate(marks, gate)
            wait_for(lambda gate=gate: steps(marks) and steps(marks)[-1][0] == gate - 1)
            postgres_server.stop()
            try:
                answer = ask(app, f"/v1/jobs/{job}")
                assert (answer.status_code, answer.json()["code"]) == (503, "service.database_unreachable")
                assert int(answer.headers["retry-after"]) > 0
                hold_gate(marks, gate + 7)
                wait_for(lambda gate=gate: steps(marks)[-1][0] == gate + 6)  # it goes on without
            finally:
                postgres_server.start()
        hold_gate(marks, STEPS)
        row = wait_ended(settings, job)
        assert ask(app, f"/v1/jobs/{job}").json()["state"] == "succeeded"
    assert (row.state, row.attempts) == ("succeeded", 1)
    assert [step for step, _ in steps(marks)] == list(range(STEPS)), "no step twice"
    gc.collect()


@SQLITE_BY_DAY
@pytest.mark.slow
def test_priorities_queues_and_three_dispatchers_r19(settings, database, queue_job, start_worker, marks):
    """Broken where the broker's order decides, a worker takes what it does not serve, or a job starts twice."""
    start_broker(settings)
    jobs = [queue_job(f"short{i}", priority=i) for i in range(5)]
    other = queue_job("gpu", queue="gpu")
    with start_worker("--queues", "cpu") as alone:
        rows = [wait_ended(settings, job) for job in jobs]
        assert [row.id for row in sorted(rows, key=lambda row: row.started)] == jobs[::-1]
        assert find_job(database, other).state == "queued"
        alone.terminate()
        alone.wait()
    with start_worker(**LONG), start_worker(**LONG), start_worker(**LONG):
        more = [queue_job(f"more{i}") for i in range(12)]
        rows = [wait_ended(settings, job) for job in [other, *more]]
    assert {row.state for row in rows} == {"succeeded"}
    assert all(kinds(database, row.id).count("started") == 1 for row in rows)
