"""What an operator reads of a host: failures first, and for what is not made yet the command that makes it."""

from __future__ import annotations

import json
import os
from dataclasses import replace

import pytest
from garmentq.cli.doctor_checks import Level
from garmentq.service.database import Database, open_database, read_revision
from garmentq_home import Cli, drop_database, drop_tables, make_database, put_file


@pytest.fixture
def server_home(settings, postgres):
    """Return settings of a home whose database is a server's, and empty."""
    address = make_database(postgres)
    drop_tables(address)
    yield replace(settings, database_url=address, store=str(settings.home / "shared"))
    drop_database(address)


def examine(settings, *words, **variables):
    """Return what doctor finds, in its order."""
    done = Cli(settings)("doctor", "--json", *words, **variables)
    return done.returncode, [json.loads(line) for line in done.stdout.splitlines()]


def test_what_failed_comes_first(settings):
    """Broken where an operator looks for one FAIL among forty lines, or a warning counts as a failure."""
    settings.home.chmod(0o755)
    status, found = examine(settings)
    levels = [row["level"] for row in found]
    assert levels == sorted(levels, key=[str(level) for level in Level].index)
    assert status == 1 and found[0]["check"] == "home" and [row["ok"] for row in found].count(False) == 1
    settings.home.chmod(0o700)
    assert examine(settings)[0] == 0
    shown = Cli(settings)("doctor").stdout
    assert "cores" in shown and "GARMENTQ_DATABASE_URL" not in shown, "a default is not shown unless --all"
    assert "GARMENTQ_DATABASE_URL" in Cli(settings)("doctor", "--all").stdout


def test_a_setting_is_set_where_somebody_set_it(settings):
    """Broken where a default counts as set, or a value that is set to the default does not."""
    unset = dict.fromkeys(settings.as_environment(), "")
    file = put_file(settings.home, "attempts.txt")
    file.write_text("3")

    def find_set(*words, **variables):
        return {row["check"] for row in examine(settings, *words, **unset | variables)[1] if "(set)" in row["message"]}

    there = str(settings.home)
    assert find_set(GARMENTQ_HOME=there) == {"GARMENTQ_HOME"} == find_set("--home", there)
    assert find_set(GARMENTQ_HOME=there, GARMENTQ_THREADS="1") == {"GARMENTQ_HOME", "GARMENTQ_THREADS"}
    assert "GARMENTQ_MAX_ATTEMPTS" in find_set("--home", there, GARMENTQ_MAX_ATTEMPTS_FILE=str(file))


def test_a_servers_database_with_a_store_of_this_machine_fails(server_home):
    """Broken where two hosts each have a store of their own, and nobody is told before jobs fail."""
    assert Cli(server_home)("db", "upgrade").returncode == 0
    status, found = examine(replace(server_home, store=""))
    [store] = [row for row in found if row["check"] == "store"]
    assert status == 1 and not store["ok"] and "GARMENTQ_STORE" in store["message"]
    status, found = examine(server_home)
    rows = {row["check"]: row for row in found}
    assert status == 0 and rows["store"]["ok"] and rows["brokers"]["level"] == "warning"


def test_only_db_upgrade_makes_the_tables_of_a_server(server_home, tmp_path):
    """Broken where a look makes thirty tables, a start fails without the next step, or a home needs the command."""
    cli, scan = Cli(server_home), put_file(tmp_path, "shirt.ply")
    commands = [
        ("submit", scan, "--body", put_file(tmp_path, "body.ply")), ("status",), ("query",), ("keys", "list"),
        ("worker",), ("serve",), ("serve", "--host", "0.0.0.0"), ("courier",), ("gc",), ("verify",), ("audit",),
        ("up",), ("webhooks", "list"), ("delete", "--older-than", "1d"),
    ]  # fmt: skip
    for words in commands:
        done = cli(*words)
        assert (done.returncode, done.stdout) == (9, ""), (words, done)
        assert done.stderr.startswith("error service.database_empty") and "garmentq db upgrade" in done.stderr, words
    status, found = examine(server_home)
    assert status == 1 and found[0]["check"] == "database" and "garmentq db upgrade" in found[0]["message"]
    opened = Database(server_home.database, pooled=False)
    with opened.read() as session:
        assert read_revision(session.connection()) is None
    assert cli("db", "upgrade").returncode == 0 and cli("status").returncode == 0
    fresh = replace(server_home, home=tmp_path / "fresh", database_url="")
    open_database(fresh).dispose()
    assert (fresh.home / "garmentq.db").is_file()


def test_a_bucket_that_is_not_made_yet(settings, tmp_path, monkeypatch):
    """Broken where a bucket that `db upgrade` makes is called a fault of garmentq, or is made by another command."""
    from moto.server import ThreadedMotoServer

    monkeypatch.setenv("AWS_ACCESS_KEY_ID", "x")
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "y")
    server = ThreadedMotoServer("127.0.0.1", port=0, verbose=False)
    server.start()
    try:
        host, port = server.get_host_and_port()
        address = f"http://{host}:{port}"
        away = replace(settings, store=f"s3://gq-{os.urandom(6).hex()}/a", s3_endpoint=address)
        cli, words = Cli(away), ("submit", put_file(tmp_path, "a.ply"), "--body", put_file(tmp_path, "b.ply"))
        for _ in range(2):
            done = cli(*words)
            assert done.returncode == 9 and done.stderr.startswith("error store.bucket_missing"), done
            assert "garmentq db upgrade" in done.stderr
        status, found = examine(away)
        assert status == 1 and found[0]["check"] == "store" and "garmentq db upgrade" in found[0]["message"]
        assert cli("db", "upgrade").returncode == 0
        assert examine(away)[0] == 0 and cli(*words).returncode == 0
    finally:
        server.stop()


def test_a_public_address_without_keys_is_refused_before_it_is_announced(settings):
    """Broken where a service says that it is there, and then refuses; or `up` starts a worker for it first."""
    cli = Cli(settings)
    for words in (("serve",), ("up", "--serve")):
        done = cli(*words, "--host", "0.0.0.0")
        assert done.returncode == 4 and done.stderr.startswith("error serve.keys_missing"), done
    assert not (settings.home / "worker.log").exists()
