"""The README's production section, followed to the letter by two shells, a PostgreSQL and a Valkey."""

from __future__ import annotations

import json
import os
import re
import signal
import socket
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import pytest
from garmentq.service.database import Database, read_revision
from garmentq.service.settings import read_settings
from garmentq.workers.broker import find_server, is_broker_up
from garmentq_home import (
    drop_database,
    drop_tables,
    make_database,
    make_environment,
    make_settings,
    put_file,
    wait_for,
)
from patience import WAIT_SECONDS

ROOT = Path(__file__).parents[2]
BLOCK = re.search(r"## Production\n.*?```\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)[1]


def read_block(values):
    """Return what is typed in every shell, in the first, and in the second, with the addresses put in."""
    parts = re.split(r"^# .*\n", BLOCK, flags=re.MULTILINE)
    assert len(parts) == 4 and parts[0] == ""
    exports = parts[1]
    for name, value in values.items():
        exports, count = re.subn(
            rf"^(export {name}=).*$", lambda m, v=value: f"{m[1]}'{v}'", exports, flags=re.MULTILINE
        )
        assert count == 1, name
    assert len(exports.splitlines()) == len(values), "every line of the first part is an address"
    return exports, parts[2], parts[3]


@pytest.fixture
def valkey(tmp_path):
    """Start a Valkey on a port of this machine that asks for a password; gives its address."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    command = [str(find_server()), "--port", str(port), "--bind", "127.0.0.1", "--requirepass", "pssst", "--save", ""]
    with (tmp_path / "valkey.log").open("wb") as log:
        server = subprocess.Popen([*command, "--dir", str(tmp_path)], stdout=log, stderr=log)
    yield f"redis://:pssst@127.0.0.1:{port}/0"
    server.terminate()
    server.wait(timeout=WAIT_SECONDS)


def test_it_has_ten_lines():
    """Broken where following the section becomes an afternoon."""
    assert len([line for line in BLOCK.splitlines() if line and not line.startswith("#")]) <= 10


@pytest.mark.nightly
def test_following_the_section_gives_a_fleet(postgres, valkey, tmp_path):
    """Broken where a step is missing, an address is not understood, or hosts need more than the three addresses."""
    database = make_database(postgres)
    drop_tables(database)  # two hosts make the tables at the same time
    store = tmp_path / "srv"
    values = {
        "GARMENTQ_DATABASE_URL": database.replace("postgresql+psycopg://", "postgresql://"),
        "GARMENTQ_BROKER_URL": valkey,
        "GARMENTQ_STORE": str(store),
    }
    exports, first, second = read_block(values)
    scans = tmp_path / "scans"
    scans.mkdir()
    put_file(scans, "body.obj")
    for index in range(6):
        put_file(scans, f"skirt{index}.ply")
    wait_for(lambda: is_broker_up(read_settings(values)))
    workers = []
    try:
        for name in ("host1", "host2"):
            workers.append(start_shell(exports + first, tmp_path / name, tmp_path))
        wait_for(lambda: has_tables(database))
        done = start_shell(exports + second, tmp_path / "desk", tmp_path)
        out, _ = done.communicate(timeout=WAIT_SECONDS)
        assert done.returncode == 0, out
        rows = [json.loads(line) for line in out.splitlines() if line.startswith("{")]
        assert sorted(row["name"] for row in rows) == [f"skirt{index}" for index in range(6)]
        assert {row["state"] for row in rows} == {"succeeded"} and {row["attempts"] for row in rows} == {1}
        assert not (tmp_path / "desk" / "garmentq.db").exists() and list(store.glob("??/*"))
    finally:
        for worker in workers:
            with suppress(ProcessLookupError):
                os.killpg(worker.pid, signal.SIGTERM)
        outputs = [worker.communicate(timeout=WAIT_SECONDS)[0] for worker in workers]
        drop_database(database)
    assert all("pssst" not in output for output in outputs), "a secret in a log"


def has_tables(address):
    """Return whether a host has made the tables, as only `db upgrade` does."""
    opened = Database(address, pooled=False)
    try:
        with opened.read() as session:
            return read_revision(session.connection()) is not None
    finally:
        opened.dispose()


def start_shell(lines, home, folder):
    """Type lines into a fresh shell that has nothing but the package and the stand-in for the pipeline."""
    environment = make_environment(make_settings(home))
    for name in ("GARMENTQ_DATABASE_URL", "GARMENTQ_BROKER_URL", "GARMENTQ_STORE"):
        environment.pop(name)
    environment["PATH"] = f"{Path(sys.executable).parent}:{environment['PATH']}"
    return subprocess.Popen(
        ["bash", "-ec", lines], env=environment, cwd=folder, text=True, start_new_session=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    )  # fmt: skip
