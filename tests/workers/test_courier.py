"""The courier that runs apart: trials and jobs' messages go by its hands alone, and its health is told."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from contextlib import contextmanager
from dataclasses import replace
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from json import loads
from pathlib import Path

import pytest
from garmentq.service import webhook_trial
from garmentq.service.webhooks import create_webhook, list_webhooks
from garmentq_home import Cli, make_environment, wait_ended, wait_for
from patience import WAIT_SECONDS

pytestmark = pytest.mark.slow

NEAR = "127.0.0.2/32"


@pytest.fixture(autouse=True)
def patience(monkeypatch):
    """Wait for a trial as long as a busy machine may take."""
    monkeypatch.setattr(webhook_trial, "WEBHOOK_TRIAL_TIMEOUT", WAIT_SECONDS)


@contextmanager
def receiving():
    """Keep the type of each message, and the process that sent it."""
    got: list[tuple[str, int]] = []

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            body = loads(self.rfile.read(int(self.headers["content-length"])))
            got.append((body["type"], find_sender(self.client_address[1])))
            self.send_response(204)
            self.end_headers()

        def log_message(self, *_: object) -> None:
            pass

    server = ThreadingHTTPServer(("127.0.0.2", 0), Handler)
    thread = threading.Thread(target=server.serve_forever, args=(0.02,), daemon=True)
    thread.start()
    try:
        yield f"http://127.0.0.2:{server.server_address[1]}/", got
    finally:
        server.shutdown()
        server.server_close()
        thread.join(10)


def find_sender(port: int) -> int:
    """Return the process that holds the connection from a port of this machine; 0 where none is found."""
    lines = [line.split() for line in Path("/proc/net/tcp").read_text().splitlines()[1:]]
    inodes = {f"socket:[{line[9]}]" for line in lines if int(line[1].split(":")[1], 16) == port}
    for name in filter(str.isdigit, os.listdir("/proc")):
        try:
            if any(os.readlink(f"/proc/{name}/fd/{one}") in inodes for one in os.listdir(f"/proc/{name}/fd")):
                return int(name)
        except OSError:
            continue
    return 0


@contextmanager
def running(settings, *words):
    """Run a command of a home for the block; it must end by itself when it is told to."""
    command = [sys.executable, "-m", "garmentq.cli.main", *words]
    with (settings.home / "command.log").open("ab") as log:
        process = subprocess.Popen(command, env=make_environment(settings), stdout=log, stderr=log)
    try:
        yield process
    finally:
        process.send_signal(signal.SIGTERM)
        assert process.wait() == 0


def test_a_trial_and_a_jobs_message_come_by_the_same_hands(settings, database, queue_job):
    """Broken where a test of a webhook arrives by another process than the messages it is a test of."""
    apart = replace(settings, send_messages=0, webhook_networks=NEAR)
    cli = Cli(apart)
    assert cli("courier", "--check").returncode == 9
    with receiving() as (url, got), running(apart, "worker", "--workers", "1"):
        hook, _ = create_webhook(database, url, (), NEAR)
        assert wait_ended(settings, queue_job("one")).state == "succeeded"
        wait_for(lambda: list_webhooks(database)[0].owed == 1)
        with running(apart, "courier") as courier:
            wait_for(lambda: len(got) == 1)
            tried = cli("webhooks", "test", hook.id)
            assert tried.returncode == 0 and "answered 204" in tried.stderr
            assert cli("courier", "--check").returncode == 0
            assert wait_ended(settings, queue_job("two")).state == "succeeded"
            wait_for(lambda: len(got) == 3)
    assert got == [("job.succeeded", courier.pid), ("test", courier.pid), ("job.succeeded", courier.pid)]
    assert list_webhooks(database)[0].owed == 0
    assert cli("courier", "--check").returncode == 9


def test_a_trial_goes_by_a_workers_courier_too(settings, database):
    """Broken where a home without a courier of its own sends a trial otherwise than it sends the rest."""
    near = replace(settings, webhook_networks=NEAR)
    with receiving() as (url, got), running(near, "worker", "--workers", "1") as worker:
        hook, _ = create_webhook(database, url, (), NEAR)
        done = Cli(replace(near, webhook_networks=""))("webhooks", "test", hook.id)
    assert done.returncode == 0, "the networks of whoever sends count"
    assert [kind for kind, _ in got] == ["test"] and got[0][1] not in (0, os.getpid(), worker.pid)


def test_a_trial_that_nobody_sends_says_so(settings, database, monkeypatch):
    """Broken where a test succeeds though no process sends, or leaves a message that comes hours later."""
    monkeypatch.setattr(webhook_trial, "WEBHOOK_TRIAL_TIMEOUT", 0.5)
    with receiving() as (url, got):
        hook, _ = create_webhook(database, url, (), NEAR)
        done = Cli(replace(settings, webhook_networks=NEAR))("webhooks", "test", hook.id)
        assert done.returncode == 5 and "it was not sent" in done.stderr and "garmentq courier" in done.stderr
        assert got == [] and list_webhooks(database)[0].owed == 0
