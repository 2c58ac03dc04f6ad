"""Logs for machines: with GARMENTQ_LOG_JSON=1 every line is an object, and no file of a home grows without bound."""

from __future__ import annotations

import json
import signal
import socket
import stat
import subprocess
import sys
from contextlib import contextmanager

import httpx
from garmentq.workers import log_files
from garmentq.workers.embedded import ensure_services, stop_services
from garmentq.workers.log_files import KEPT_LOGS, MAX_LOG_SIZE, rotate_logs
from garmentq_home import make_environment, wait_ended, wait_for
from patience import WAIT_SECONDS


@contextmanager
def logging(settings, *words):
    """Run a command with JSON logs for the block; what it wrote is in the list that is given, one object a line."""
    variables = make_environment(settings) | {"GARMENTQ_LOG_JSON": "1"}
    command = [sys.executable, "-m", "garmentq.cli.main", *words]
    told, path = [], settings.home / "told.log"
    with path.open("w") as log:
        process = subprocess.Popen(command, env=variables, stdout=log, stderr=log)
    try:
        yield process, told
    finally:
        process.send_signal(signal.SIGTERM)
        process.wait(timeout=WAIT_SECONDS)
        told += [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]


def find_port() -> int:
    """Return a free port."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return free.getsockname()[1]


def test_each_line_of_a_worker_is_an_object(settings, queue_job, cli):
    """Broken where a collector of logs meets a line that is none of JSON's, such as Celery's when it stops."""
    with logging(settings, "worker", "--workers", "1") as (process, told):
        assert wait_ended(settings, queue_job("good")).state == "succeeded"
    cli("down")
    assert process.returncode == 0
    messages = [line["message"] for line in told]
    assert any(message.endswith("ready.") for message in messages) and any("stopping" in one for one in messages)
    assert {line["level"] for line in told} <= {"info", "warning"} and all(line["time"] for line in told)


def test_each_line_of_the_api_is_an_object(settings):
    """Broken where uvicorn's own lines or the announcement are plain, or a link that signs in gets into a log."""
    port = str(find_port())
    with logging(settings, "serve", "--port", port) as (_, told):
        wait_for(lambda: answers(port))
        other = subprocess.run(
            [sys.executable, "-m", "garmentq.cli.main", "serve", "--port", port], text=True, check=False,
            env=make_environment(settings) | {"GARMENTQ_LOG_JSON": "1"}, capture_output=True, timeout=WAIT_SECONDS,
        )  # fmt: skip
    assert any("its pages" in line["message"] for line in told) and "link=" not in json.dumps(told)
    lines = [json.loads(line) for line in other.stderr.splitlines()]
    assert other.stdout == "" and any("address already in use" in line["message"] for line in lines)


def answers(port: str) -> bool:
    """Return whether the API answers."""
    try:
        return httpx.get(f"http://127.0.0.1:{port}/healthz").status_code == 200
    except httpx.TransportError:
        return False


def test_an_error_that_ends_a_service_is_an_object(settings, tmp_path):
    """Broken where the one line that says why a service does not start is not found by its collector."""
    (tmp_path / "file").write_text("")
    for words in (("worker",), ("courier",), ("serve",)):
        command = [sys.executable, "-m", "garmentq.cli.main", *words, "--home", str(tmp_path / "file" / "home")]
        variables = make_environment(settings) | {"GARMENTQ_LOG_JSON": "1"}
        done = subprocess.run(command, env=variables, capture_output=True, text=True, check=False, timeout=WAIT_SECONDS)
        [line] = [json.loads(line) for line in done.stderr.splitlines()]
        assert line["level"] == "error" and done.returncode in (1, 4, 9), (words, line)


def test_a_log_is_begun_anew_under_its_writer(settings, monkeypatch):
    """Broken where a writer goes on behind the end of the emptied file, others can read a log, or all are kept."""
    monkeypatch.setattr(log_files, "MAX_LOG_SIZE", 1000)
    path = settings.home / "worker.log"
    with path.open("ab", buffering=0) as writer:
        for number in range(KEPT_LOGS + 2):
            writer.write(b"%d" % number + b"x" * 2000)
            assert rotate_logs(settings) == 1 and path.stat().st_size == 0
            writer.write(b"small")
            assert path.read_bytes() == b"small" and rotate_logs(settings) == 0
            path.write_bytes(b"")
    kept = sorted(settings.home.glob("worker.log.*"))
    assert [one.name for one in kept] == [f"worker.log.{number}" for number in range(1, KEPT_LOGS + 1)]
    assert [one.read_bytes()[:1] for one in kept] == [b"4", b"3", b"2"]
    assert all(stat.S_IMODE(one.stat().st_mode) == 0o600 for one in kept)


def test_a_worker_empties_its_own_log(settings):
    """Broken where `up --serve`, which runs for months, fills the disk of a home with its worker's log."""
    path = settings.home / "worker.log"
    ensure_services(settings, 1)
    try:
        with path.open("ab") as log:
            log.write(b"x" * MAX_LOG_SIZE)
        wait_for(lambda: path.stat().st_size < MAX_LOG_SIZE)
        assert (settings.home / "worker.log.1").stat().st_size >= MAX_LOG_SIZE
    finally:
        stop_services(settings)
    assert b"stopping" in path.read_bytes()
