"""What is said where a broker cannot be used, with a real Valkey that asks for a password."""

from __future__ import annotations

import json
import socket
import subprocess
from dataclasses import replace

import pytest
from garmentq.service.reaper import record_heartbeat, remove_worker
from garmentq.workers.broker import find_server, is_broker_up, start_broker
from garmentq_home import Cli, wait_for
from patience import WAIT_SECONDS

SECRET = "gehe1m"


@pytest.fixture
def broker(settings, tmp_path):
    """Start a Valkey with a password and a user who may do nothing; gives settings that reach it."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    words = ["--port", str(port), "--bind", "127.0.0.1", "--requirepass", SECRET, "--save", "", "--dir", str(tmp_path)]
    words += ["--user", "poor", "on", f">{SECRET}", "-@all"]
    server = subprocess.Popen([str(find_server()), *words], stdout=subprocess.DEVNULL)
    right = replace(settings, broker_url=f"redis://:{SECRET}@127.0.0.1:{port}/0")
    wait_for(lambda: is_broker_up(right))
    yield right
    server.terminate()
    server.wait(timeout=WAIT_SECONDS)


def ask_doctor(settings, address: str):
    """Return what doctor finds of the broker, and all that it and a worker that begins there say."""
    cli = Cli(replace(settings, broker_url=address))
    found = cli("doctor", "--json")
    lines = [json.loads(line) for line in found.stdout.splitlines()]
    [broker] = [line for line in lines if line["check"] == "broker"]
    begun = cli("worker") if not broker["ok"] else found
    return broker, found.stdout + found.stderr + begun.stdout + begun.stderr


def test_a_refusal_is_told_from_silence(broker):
    """Broken where a wrong password is called silence, an odd address is a traceback, or either shows the password."""
    port = broker.broker_url.split(":")[-1]
    found, _ = ask_doctor(broker, broker.broker_url)
    assert found["ok"] and found["message"] == f"redis://:***@127.0.0.1:{port} responds"
    for who in (":wr0ng@", "", f"nobody:{SECRET}@", f"poor:{SECRET}@"):
        found, said = ask_doctor(broker, f"redis://{who}127.0.0.1:{port}")
        assert "service.broker_refused" in found["message"] and "GARMENTQ_BROKER_URL" in found["message"]
        assert SECRET not in said and "wr0ng" not in said and "Traceback" not in said
    found, _ = ask_doctor(broker, f"redis://:{SECRET}@127.0.0.1:1/0")
    assert "service.broker_unreachable" in found["message"]
    for odd in (f"{SECRET}/x", f"{SECRET}#x", f"{SECRET}?x", f"{SECRET}[x"):
        found, said = ask_doctor(broker, f"redis://:{odd}@127.0.0.1:{port}")
        assert "service.setting_bad" in found["message"] and "%2F" in found["message"]
        assert SECRET not in said and "Traceback" not in said
    assert not start_broker(broker), "it was there already"


def test_doctor_looks_for_this_machines_worker(settings, database, cli):
    """Broken where a container is healthy whose worker hangs, or another machine's worker stands in for it."""
    assert cli("doctor").returncode == 0
    record_heartbeat(database, "elsewhere:1:ab", "cpu", 1, 30.0)
    found = cli("doctor", "--worker", "--json")
    [told] = [row for row in map(json.loads, found.stdout.splitlines()) if row["check"] == "worker here"]
    assert found.returncode == 1 and "see its log" in told["message"]
    name = f"{socket.gethostname()}:1:ab"
    record_heartbeat(database, name, "cpu", 1, 30.0)
    rows = {row["check"]: row for row in map(json.loads, cli("doctor", "--worker", "--json").stdout.splitlines())}
    assert rows["worker here"]["ok"] and rows["workers"]["message"].startswith("2 alive, 2 jobs at a time")
    remove_worker(database, name)
    assert cli("doctor", "--worker").returncode == 1
