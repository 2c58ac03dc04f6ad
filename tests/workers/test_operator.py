"""An operator's year in a minute: two hosts, upgrade, keys, jobs, a rolling restart, a backup, an erasure, a disaster.

Real servers: PostgreSQL, a Valkey that asks for a password, and an S3 stand-in.
"""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
from contextlib import ExitStack, contextmanager, suppress

import httpx
import pytest
from garmentq.workers.broker import find_server, is_broker_up
from garmentq_home import (
    Cli,
    drop_database,
    drop_tables,
    make_database,
    make_environment,
    make_settings,
    put_file,
    wait_for,
)
from garmentq_standin import hold_gate
from patience import WAIT_SECONDS

STEPS = 40
"""Steps of a gated job of the stand-in."""


@pytest.fixture
def servers(postgres, tmp_path, monkeypatch):
    """Start broker and bucket server; gives a function that returns the settings of a host."""
    from moto.server import ThreadedMotoServer

    monkeypatch.setenv("AWS_ACCESS_KEY_ID", "x")
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "y")
    monkeypatch.setenv("STANDIN_MARKS", str(tmp_path / "marks"))
    port = find_port()
    words = ["--port", str(port), "--bind", "127.0.0.1", "--requirepass", "pssst", "--save", "", "--dir", str(tmp_path)]
    broker = subprocess.Popen([str(find_server()), *words], stdout=subprocess.DEVNULL)
    store = ThreadedMotoServer("127.0.0.1", port=0, verbose=False)
    store.start()
    address = "http://{}:{}".format(*store.get_host_and_port())
    databases = []

    def make_host(name, service):
        return make_settings(
            tmp_path / name, database_url=service[0], broker_url=f"redis://:pssst@127.0.0.1:{port}/0",
            store=service[1], s3_endpoint=address, lease_seconds=30.0,
        )  # fmt: skip

    def make_service():
        databases.append(make_database(postgres))
        drop_tables(databases[-1])
        return databases[-1], f"s3://gq-{os.urandom(6).hex()}/studio"

    service = make_service()
    wait_for(lambda: is_broker_up(make_host("desk", service)))
    yield make_host, make_service, service
    store.stop()
    broker.terminate()
    broker.wait(timeout=WAIT_SECONDS)
    for one in databases:
        drop_database(one)


def find_port() -> int:
    """Return a free port."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return free.getsockname()[1]


@contextmanager
def running(settings, *words):
    """Run a command of a host for the block; it ends by SIGTERM with status 0, and its log has no password."""
    settings.home.mkdir(exist_ok=True)
    path = settings.home / f"{words[0]}.out"
    command = [sys.executable, "-m", "garmentq.cli.main", *words]
    with path.open("a") as log:
        process = subprocess.Popen(
            command, env=make_environment(settings), stdout=log, stderr=log, start_new_session=True
        )
    try:
        yield process
        process.terminate()
        assert process.wait(timeout=WAIT_SECONDS) == 0, path.read_text()
    finally:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
    text = path.read_text()
    assert "pssst" not in text and "Traceback" not in text, text


def read_jobs(cli) -> dict[str, dict]:
    """Return every job by name."""
    done = cli("status", "--json")
    assert done.returncode == 0, done.stderr
    return {row["name"]: row for row in map(json.loads, done.stdout.splitlines())}


def find_state(cli, name) -> str:
    """Return a job's state; empty while the list, which is read in parts, misses it between two states."""
    return read_jobs(cli).get(name, {}).get("state", "")


def submit(cli, folder, *names):
    """Queue a scan for each name."""
    body = put_file(folder, "body.ply")
    done = cli("submit", *(put_file(folder, f"{name}.ply") for name in names), "--body", body)
    assert done.returncode == 0, done.stderr


@pytest.mark.nightly
def test_an_operators_story(servers, tmp_path):
    """Broken where a step of running a fleet needs more than its command, or an attempt or a file is lost."""
    make_host, make_service, service = servers
    one, two, desk = (make_host(name, service) for name in ("one", "two", "desk"))
    cli, folder, marks = Cli(desk), tmp_path / "scans", tmp_path / "marks"
    folder.mkdir()
    hold_gate(marks, STEPS)

    # an empty database and no bucket: everything names the one command
    for words in (("worker",), ("serve",), ("status",)):
        assert cli(*words).returncode == 9 and "garmentq db upgrade" in cli(*words).stderr
    assert cli("doctor").returncode == 1
    assert cli("db", "upgrade").returncode == 0 and cli("doctor").returncode == 0

    # keys, and an API behind a proxy that starts only with one
    port = str(find_port())
    assert cli("serve", "--allow-host", "garmentq.example", "--port", port).returncode == 4
    key = json.loads(cli("keys", "create", "studio", "--json").stdout)["token"]
    monitor = json.loads(cli("keys", "create", "monitor", "--scope", "metrics", "--json").stdout)["token"]
    with ExitStack() as services:
        services.enter_context(running(desk, "serve", "--allow-host", "garmentq.example", "--port", port))
        url = f"http://127.0.0.1:{port}"
        wait_for(lambda: answers(url, "/readyz"))
        remote = {"GARMENTQ_URL": url, "GARMENTQ_API_KEY": key}

        # jobs on two hosts, one of them by way of the API
        first = services.enter_context(ExitStack())
        first.enter_context(running(one, "worker", "--workers", "1"))
        second = services.enter_context(ExitStack())
        second.enter_context(running(two, "worker", "--workers", "1"))
        for host in (one, two):
            wait_for(lambda host=host: Cli(host)("worker", "--check").returncode == 0)
        submit(cli, folder, "shirt", "skirt", "anna")
        body = folder / "body.ply"
        done = cli("submit", put_file(folder, "dress.ply"), "--body", body, "--wait", **remote)
        assert done.returncode == 0, done.stderr
        wait_for(lambda: {row["state"] for row in read_jobs(cli).values()} == {"succeeded"})

        # a rolling restart in the middle of a job: it changes hosts twice and no attempt is spent
        hold_gate(marks, 10)
        submit(cli, folder, "gated")
        wait_for(lambda: find_steps(marks) >= 10)
        restarted = [(first, one), (second, two)]
        for step, (host, settings) in zip((20, 30), restarted, strict=True):
            host.close()
            hold_gate(marks, step)
            wait_for(lambda step=step: find_steps(marks) >= step)
            host.enter_context(running(settings, "worker", "--workers", "1"))
            wait_for(lambda settings=settings: Cli(settings)("worker", "--check").returncode == 0)
        hold_gate(marks, STEPS)
        wait_for(lambda: find_state(cli, "gated") == "succeeded")
        assert {row["attempts"] for row in read_jobs(cli).values()} == {1}
        told = httpx.get(f"{url}/metrics", headers={"authorization": f"Bearer {monitor}"}).text
        assert "garmentq_leases_expired_total 0.0" in told and "garmentq_workers 2.0" in told
        assert httpx.get(f"{url}/v1/jobs", headers={"authorization": f"Bearer {monitor}"}).status_code == 403

        # a person is erased, then all is saved while it runs
        assert cli("delete", "--person", "anna.ply", "--yes").returncode == 0 and "anna" not in read_jobs(cli)
        hold_gate(marks, 5)
        submit(cli, folder, "gated2")
        wait_for(lambda: find_state(cli, "gated2") == "running")
        done = cli("backup", tmp_path / "monday.tar", "--json")
        saved = json.loads(done.stdout)
        assert done.returncode == 0 and saved["files"] > 5, done
    before = read_jobs(cli)

    # the machine room burns down: another database, another bucket, the same broker, which has forgotten all
    other = make_service()
    there, three = make_host("desk2", other), make_host("three", other)
    again = Cli(there)
    done = again("restore", tmp_path / "monday.tar", "--json")
    assert done.returncode == 0 and json.loads(done.stdout)["files"] == saved["files"], done
    assert again("verify", "--read-data").returncode == 0
    jobs = read_jobs(again)
    assert set(jobs) == set(before) and jobs["gated2"]["state"] == "running" and "anna" not in jobs
    with running(there, "serve", "--port", port), running(three, "worker", "--workers", "1"):
        wait_for(lambda: answers(url, "/readyz"))
        hold_gate(marks, STEPS)
        listed = httpx.get(f"{url}/v1/jobs", headers={"authorization": f"Bearer {key}"})
        assert [row["name"] for row in listed.json()["jobs"]] == ["dress"], "the key knows its own job"
        wait_for(lambda: find_state(again, "gated2") == "succeeded")
        assert again("export", jobs["shirt"]["job"], "-o", tmp_path / "out").returncode == 0
        assert list((tmp_path / "out").rglob("metrics.txt"))


def answers(url: str, path: str) -> bool:
    """Return whether a service answers that it is ready."""
    try:
        return httpx.get(f"{url}{path}").status_code == 200
    except httpx.TransportError:
        return False


def find_steps(marks) -> int:
    """Return the number of the next step of the gated job."""
    lines = marks.read_text().splitlines() if marks.exists() else []
    return max((int(line.split()[0]) + 1 for line in lines if len(line.split()) == 2), default=0)
