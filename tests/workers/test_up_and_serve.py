"""One command keeps the API, the broker and the workers alive together, and takes them down with it."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys

import httpx
import pytest
from garmentq.service.local_token import read_local_token
from garmentq.workers.broker import is_broker_up, run_folder
from garmentq.workers.embedded import is_worker_up
from garmentq_home import Cli, make_environment, wait_ended, wait_for
from patience import WAIT_SECONDS


def answers(address):
    """Return whether the API answers."""
    try:
        return httpx.get(f"{address}/healthz").status_code == 200
    except httpx.TransportError:
        return False


@pytest.mark.slow
def test_what_dies_is_started_again_and_all_stops_together(settings, queue_job):
    """Broken where a service takes jobs that nobody does any more, or leaves a worker behind."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    address = f"http://127.0.0.1:{port}"
    command = [sys.executable, "-m", "garmentq.cli.main", "up", "--serve", "--workers", "1", "--port", str(port)]
    process = subprocess.Popen(command, env=make_environment(settings), stderr=subprocess.PIPE, text=True)
    try:
        wait_for(lambda: answers(address))
        first = int((run_folder(settings) / "worker.pid").read_text())
        os.killpg(first, signal.SIGKILL)
        wait_for(lambda: is_worker_up(settings) and int((run_folder(settings) / "worker.pid").read_text()) != first)
        assert wait_ended(settings, queue_job()).state == "succeeded"
        key = {"authorization": f"Bearer {read_local_token(settings.home)}"}
        assert len(httpx.get(f"{address}/v1/jobs", headers=key).json()["jobs"]) == 1
        busy = Cli(settings)("restore", settings.home / "x.tar", "--overwrite")
        assert busy.returncode == 4 and "backup.refused" in busy.stderr
    finally:
        process.send_signal(signal.SIGINT)
        told = process.communicate(timeout=WAIT_SECONDS)[1]
    assert "started the broker and the worker" in told and "api.token" in told
    assert not is_worker_up(settings) and not is_broker_up(settings)
