"""A command that is told to stop, by whichever signal and whenever, ends in order and leaves nothing behind."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
from pathlib import Path

import httpx
import pytest
from garmentq.service.jobs import read_events
from garmentq.workers.embedded import was_stopped
from garmentq_home import make_environment, read_job, wait_for

STOPS = (signal.SIGTERM, signal.SIGHUP, signal.SIGINT)

BY_DAY = (STOPS[0], *(pytest.param(number, marks=pytest.mark.nightly) for number in STOPS[1:]))
"""Signals, of which the suite sends the one that supervisors send."""

pytestmark = pytest.mark.slow


def list_processes(settings) -> dict[int, str]:
    """Return the living processes of a home, with their command lines: all that were started by its commands."""
    mark = f"GARMENTQ_HOME={settings.home}\0".encode()
    found = {}
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            is_in = (folder / "cwd").readlink().is_relative_to(settings.home)  # the broker writes over its environment
            if int(folder.name) != os.getpid() and (is_in or mark in (folder / "environ").read_bytes() + b"\0"):
                if command := (folder / "cmdline").read_bytes().replace(b"\0", b" ").decode():
                    found[int(folder.name)] = command
        except OSError:
            continue
    return found


def find_port() -> int:
    """Return a port of this machine that is free just now."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return free.getsockname()[1]


@pytest.fixture
def start(settings, tmp_path):
    """Return a function that starts a command of the home; whatever is left of it is killed at the end."""
    started = []

    def begin(*words: str, **options) -> subprocess.Popen:
        command = [sys.executable, "-m", "garmentq.cli.main", *words]
        with (tmp_path / "told.log").open("ab") as log:
            environment = make_environment(settings)
            started.append(subprocess.Popen(command, env=environment, stdout=log, stderr=log, **options))
        return started[-1]

    yield begin
    for pid in list_processes(settings):
        os.kill(pid, signal.SIGKILL)
    for process in started:
        process.wait()


def serve_all(start) -> tuple[subprocess.Popen, str]:
    """Start `up --serve`; give it with its address."""
    port = find_port()
    return start("up", "--serve", "--workers", "1", "--port", str(port)), f"http://127.0.0.1:{port}"


def answers(address: str) -> bool:
    """Return whether the API answers."""
    try:
        return httpx.get(f"{address}/healthz").status_code == 200
    except httpx.TransportError:
        return False


def gone(settings) -> bool:
    """Return whether no process of a home is left."""
    return not list_processes(settings)


@pytest.mark.parametrize("number", BY_DAY, ids=lambda one: one.name)
def test_what_up_serve_keeps_alive_stops_with_it(settings, start, queue_job, number):
    """Broken where a supervisor, a closed terminal or Ctrl-C leaves worker and broker behind, or costs a try."""
    process, address = serve_all(start)
    wait_for(lambda: answers(address) or process.poll() is not None)
    job = queue_job("slow")
    wait_for(lambda: read_job(settings, job).state == "running")
    assert len(list_processes(settings)) >= 4, "command, broker, worker, its child"
    process.send_signal(number)
    assert process.wait() == 0
    wait_for(lambda: gone(settings))
    row = read_job(settings, job)
    assert (row.state, row.attempts) == ("queued", 0), "given back, and not counted"


def test_a_second_signal_changes_nothing(settings, start, database, queue_job):
    """Broken where whoever is impatient cuts the end short: something is left behind, or a job is lost."""
    process, address = serve_all(start)
    wait_for(lambda: answers(address) or process.poll() is not None)
    job = queue_job("slow")
    wait_for(lambda: read_job(settings, job).state == "running")
    for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGTERM, signal.SIGINT):
        process.send_signal(number)
    wait_for(lambda: was_stopped(settings) or process.poll() is not None)
    process.send_signal(signal.SIGTERM)
    assert process.wait() == 0
    wait_for(lambda: gone(settings))
    assert read_job(settings, job).attempts == 0
    assert "released" in [event.kind for event in read_events(database, job)]


@pytest.mark.parametrize("begun", ["broker.sock", "worker --embedded"])
def test_told_while_it_starts(settings, start, begun):
    """Broken where a start that is cut short leaves what it had begun."""
    process, _ = serve_all(start)
    wait_for(lambda: any(begun in words for words in list_processes(settings).values()) or process.poll() is not None)
    process.send_signal(signal.SIGTERM)
    assert process.wait() == 0
    wait_for(lambda: gone(settings))


@pytest.mark.parametrize("number", BY_DAY, ids=lambda one: one.name)
def test_a_worker_gives_its_job_back(settings, start, queue_job, number):
    """Broken where a worker's end by any signal, told twice and to all its processes, is its job's fault."""
    process = start("worker", "--workers", "1", start_new_session=True)
    job = queue_job("slow")
    wait_for(lambda: read_job(settings, job).state == "running" or process.poll() is not None)
    os.killpg(process.pid, number)
    os.killpg(process.pid, number)
    assert process.wait() == 0
    row = read_job(settings, job)
    assert (row.state, row.attempts, row.error_message) == ("queued", 0, None)


@pytest.mark.parametrize("number", BY_DAY, ids=lambda one: one.name)
def test_the_api_alone_stops(settings, start, number):
    """Broken where `serve` dies of a signal in place of ending."""
    port = find_port()
    process = start("serve", "--port", str(port))
    wait_for(lambda: answers(f"http://127.0.0.1:{port}") or process.poll() is not None)
    process.send_signal(number)
    assert process.wait() == 0 and gone(settings)


@pytest.mark.parametrize("number", BY_DAY, ids=lambda one: one.name)
def test_run_stops_waiting_and_the_job_goes_on(settings, start, database, tmp_path, number):
    """Broken where a signal to `run` ends its job, or says nothing of what becomes of it."""
    scan, body = tmp_path / "slow.ply", tmp_path / "body.ply"
    for path in (scan, body):
        path.write_text(f"ply\n{path.name}\n")
    process = start("run", str(scan), "--body", str(body))
    told = tmp_path / "told.log"
    wait_for(lambda: "scan ..." in told.read_text() or process.poll() is not None)
    process.send_signal(number)
    assert process.wait() == 130
    assert "continues; `garmentq logs -f" in told.read_text()
    assert any("worker --embedded" in words for words in list_processes(settings).values())


def test_nohup_is_obeyed(settings, start):
    """Broken where a command that was started to outlive its terminal ends with it."""
    port = find_port()
    old = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        process = start("serve", "--port", str(port))
    finally:
        signal.signal(signal.SIGHUP, old)
    wait_for(lambda: answers(f"http://127.0.0.1:{port}") or process.poll() is not None)
    process.send_signal(signal.SIGHUP)
    assert answers(f"http://127.0.0.1:{port}") and process.poll() is None
    process.send_signal(signal.SIGTERM)
    assert process.wait() == 0
