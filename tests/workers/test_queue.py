"""A real broker, a real Celery worker, and a stand-in for the pipeline."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace

import pytest
from garmentq.service.families import cancel
from garmentq.service.jobs import read_events
from garmentq.service.query import list_jobs
from garmentq.workers.broker import is_broker_up, run_folder, start_broker, stop_broker
from garmentq.workers.embedded import ensure_services, is_worker_up, stop_services, was_stopped
from garmentq_home import make_environment, read_job, wait_ended, wait_for
from garmentq_standin import STEPS, hold_gate
from patience import WAIT_SECONDS


@pytest.fixture
def environment(settings, monkeypatch, tmp_path):
    """Let what is started find the stand-in, and leave nothing running behind."""
    marks = tmp_path / "marks"
    for name, value in {**make_environment(settings), "STANDIN_MARKS": str(marks)}.items():
        monkeypatch.setenv(name, value)
    yield marks
    stop_services(settings)
    assert not is_worker_up(settings) and not is_broker_up(settings)


def read_marks(path):
    """Return (step, process) of every step that was really done."""
    if not path.exists():
        return []
    return [(int(step), int(process)) for step, process in (line.split() for line in path.read_text().splitlines())]


@pytest.mark.slow
def test_twelve_jobs_and_two_workers(settings, database, queue_job, environment):
    """Broken where a job is lost, done twice, or stops those behind it."""
    start_broker(settings)
    command = [sys.executable, "-m", "garmentq.cli.main", "worker", "--workers", "1"]
    with (settings.home / "worker.log").open("wb") as log:
        workers = [subprocess.Popen(command, stdout=log, stderr=log, env=dict(os.environ)) for _ in range(2)]
    try:
        names = [f"{'skirt' if i % 2 else 'shirt'}{i}" for i in range(10)] + ["bad", "fault"]
        jobs = [queue_job(name) for name in names]
        rows = [wait_ended(settings, job) for job in jobs]
    finally:
        for worker in workers:
            worker.terminate()
        codes = [worker.wait(timeout=WAIT_SECONDS) for worker in workers]
    assert [row.state for row in rows] == ["succeeded"] * 10 + ["failed"] * 2
    assert [row.error_code for row in rows[10:]] == ["scan.truncated", "job.crashed"]
    assert [row.bad_input for row in rows[10:]] == [True, False]
    assert {row.attempts for row in rows} == {1}
    for job in jobs:
        assert [event.kind for event in read_events(database, job)].count("started") == 1
    assert codes == [0, 0]


def test_cancel_a_running_job(settings, database, queue_job, environment):
    """Broken where a worker does not look at the flag."""
    hold_gate(environment, 3)
    ensure_services(settings, workers=1)
    job = queue_job("gated")
    wait_for(lambda: len(read_marks(environment)) == 3)
    assert cancel(database, job) == "running"
    assert wait_ended(settings, job).state == "cancelled"
    assert len(read_marks(environment)) == 3


@pytest.mark.slow
def test_down_gives_the_job_back_and_up_goes_on(settings, database, queue_job, environment):
    """Broken where stopping counts as a crash, or the work done so far is lost."""
    settings = replace(settings, lease_seconds=600.0)
    hold_gate(environment, 8)
    assert ensure_services(settings, workers=1) == ["broker", "worker"]
    assert ensure_services(settings, workers=1) == []
    job = queue_job("gated")
    wait_for(lambda: len(read_marks(environment)) == 8)
    assert stop_services(settings) == ["worker", "broker"]
    assert was_stopped(settings), "whoever waits for the job must see that a person stopped it"
    row = read_job(settings, job)
    assert (row.state, row.attempts) == ("queued", 0)
    hold_gate(environment, STEPS)
    ensure_services(settings, workers=1)
    assert not was_stopped(settings)
    row = wait_ended(settings, job)
    assert (row.state, row.attempts, row.fence) == ("succeeded", 1, 2)
    assert [step for step, _ in read_marks(environment)] == list(range(STEPS)), "no step twice, none left out"


def test_a_job_that_takes_too_long_fails(settings, database, queue_job, environment, monkeypatch):
    """Broken where a heartbeat alone keeps a stuck job alive for ever."""
    hold_gate(environment, 0)
    monkeypatch.setenv("GARMENTQ_MAX_SECONDS", "1")
    ensure_services(replace(settings, max_seconds=1.0), workers=1)
    row = wait_ended(settings, queue_job("gated"))
    assert (row.state, row.error_code) == ("failed", "job.too_long")


@pytest.mark.slow
def test_an_idle_worker_goes_home(settings, database, queue_job, environment):
    """Broken where `garmentq run` leaves a worker and a broker on the machine for ever."""
    ensure_services(replace(settings, idle_seconds=1.0), workers=1)
    wait_for(lambda: not is_worker_up(settings))
    wait_for(lambda: not is_broker_up(settings))
    assert list_jobs(database) == []


def test_the_broker_is_private(settings, environment):
    """Broken where another user could put a message in, or the queue were only in memory."""
    start_broker(settings)
    folder = run_folder(settings)
    assert (folder / "broker.sock").stat().st_mode & 0o077 == 0
    assert folder.stat().st_mode & 0o077 == 0
    assert any((settings.home / "broker").rglob("*.aof*"))
    assert stop_broker(settings) and not stop_broker(settings)


def test_a_long_home_has_a_short_socket(tmp_path):
    """Broken where a home deeper than a socket's path may be long cannot be used."""
    from garmentq_home import make_settings

    settings = make_settings(tmp_path / ("x" * 60) / ("y" * 60))
    folder = run_folder(settings)
    try:
        assert len(os.fsencode(folder / "broker.sock")) < 104
        assert run_folder(settings) == folder
        assert start_broker(settings) and stop_broker(settings)
    finally:
        for left in folder.iterdir():
            left.unlink()
        folder.rmdir()
