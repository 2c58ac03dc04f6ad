"""What outsiders are told: no password, no host, no folder, no text of a crash; and what the database cannot hold."""

from __future__ import annotations

import asyncio
import logging

import httpx
import pytest
from garmentq.service.api.app import make_app
from garmentq.service.database import Database, DatabaseDamaged, DatabaseTooOld, open_database
from garmentq.service.health import find_troubles, hide_places, read_queue
from garmentq.service.jobs import find_job
from garmentq.service.outage import note_outage
from garmentq.service.query import JobQuery, QueryBad
from garmentq.service.reaper import DUTY, hold_duty, show_life
from garmentq.service.settings import ServiceSettingBad, hide_password
from garmentq.workers.recovery import run_job
from garmentq_home import drop_tables
from sqlalchemy import text

PASSWORDS = ("plain", "pa/ss", "pa#ss", "pa?ss", "a[b", "p@ss", "p%40ss", "a:b")


@pytest.mark.parametrize("password", PASSWORDS)
@pytest.mark.parametrize("form", ["postgresql://u:{}@h/db", "redis://:{}@h:6379/0", "rediss://u:{}@[::1]:1/0"])
def test_no_password_is_shown(form, password):
    """Broken where who hides a password and who takes it read an address differently."""
    shown = hide_password(form.format(password))
    assert password not in shown and "***" in shown and ("h" in shown or "::1" in shown)
    assert hide_password(shown) == shown


def test_what_has_no_password_is_shown_as_it_is():
    """Broken where an address without a secret becomes unreadable."""
    for url in ("sqlite:////home/a/b.db", "redis+socket:///run/a.sock", "s3://bucket/prefix", "postgresql://u@h/db"):
        assert hide_password(url) == url


def test_a_password_with_an_at_sign_is_named_before_it_is_sent():
    """Broken where the driver takes half of the password for a host, and prints it."""
    with pytest.raises(ServiceSettingBad, match="%40") as told:
        Database("postgresql://me:se@cret@127.0.0.1/db")
    assert "cret" not in told.value.message


def test_an_outage_tells_nothing_over_http(settings, caplog):
    """Broken where a caller without a key reads where the database is, or who may log in there."""
    import dataclasses

    app = make_app(settings, is_open=True)
    app.state.rooms.database.dispose()
    away = Database("postgresql://postgres:S3cret@127.0.0.1:1/secretname", pooled=False)
    app.state.rooms = dataclasses.replace(app.state.rooms, database=away)

    async def ask():
        async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://127.0.0.1") as client:
            return await client.get("/v1/jobs", headers={"authorization": "Bearer x"})

    with caplog.at_level(logging.WARNING):
        answer = asyncio.run(ask())
    assert answer.status_code == 503 and answer.json()["code"] == "service.database_unreachable"
    assert not any(word in answer.text for word in ("postgres:", "S3cret", "secretname", "127.0.0.1", ":1/"))
    assert "secretname" in caplog.text and "S3cret" not in caplog.text, "the log has it, without the password"


def test_a_crash_tells_its_type_only(settings, database, queue_job):
    """Broken where values of a bug (SQL, names, paths) become the user's message."""
    job = queue_job("fault")
    run_job(settings, database, job, lambda: False)
    row = find_job(database, job)
    assert row.error_code == "job.crashed" and "ZeroDivisionError" in row.error_message
    assert "a bug" not in row.error_message


def test_a_question_has_an_end():
    """Broken where a question takes seconds, or is answered as an outage of the database."""
    for wheres in (["name = 'x'"] * 51, [" and ".join(["attempts > 0"] * 1000)]):
        with pytest.raises(QueryBad, match="more than 50"):
            _ = JobQuery({}, wheres).conditions


@pytest.mark.parametrize("database_kind", ["sqlite"], indirect=True)
@pytest.mark.parametrize("content", [b"no database at all" * 500, None])
def test_a_damaged_database_is_one_clear_error(settings, cli, content):
    """Broken where a damaged file is a traceback in every command."""
    path = settings.home / "garmentq.db"
    path.write_bytes(content or path.read_bytes()[:4096] + bytes(40000))
    (settings.home / "scan.ply").write_text("ply")
    for words in (("status",), ("query",), ("submit", settings.home / "scan.ply"), ("backup", settings.home / "b.tar")):
        done = cli(*words)
        assert done.returncode == 9 and done.stderr.startswith("error service.database_damaged: "), (words, done)
        assert "restore" in done.stderr
    done = cli("doctor", "--json")
    assert done.returncode == 1 and "service.database_damaged" in done.stdout
    with pytest.raises(DatabaseDamaged):
        open_database(settings)


def test_only_one_command_migrates(settings, database, database_url, cli):
    """Broken where a newer laptop's `status` locks older workers out."""
    with database.write() as session:
        session.execute(text("update alembic_version set version_num = '0001'"))
    database.dispose()
    for words in (("status",), ("doctor",), ("up",)):
        done = cli(*words)
        assert done.returncode != 0 and "service.database_too_old" in done.stderr + done.stdout, words
    with pytest.raises(DatabaseTooOld):
        open_database(settings)
    if database_url:
        drop_tables(database_url)
        open_database(settings).dispose()


@pytest.mark.parametrize("database_kind", ["sqlite"], indirect=True)
def test_what_stands_still_is_said(database, queue_job):
    """Broken where a queue that nobody works on looks healthy, or an outsider reads the name of a machine."""
    assert find_troubles(read_queue(database)) == []
    queue_job()
    assert "no worker is up" in find_troubles(read_queue(database))[0]
    show_life(database, "host:1", "cpu", 1, 30.0)
    assert "no dispatcher" in find_troubles(read_queue(database))[0]
    hold_duty(database, DUTY, "host:1", 5.0)
    assert find_troubles(read_queue(database)) == []
    note_outage(database, "myhost", "store.full")
    [trouble] = find_troubles(read_queue(database))
    assert "myhost" in trouble and "store.full" in trouble and "free some disk space" in trouble
    shown = hide_places(read_queue(database))
    assert "myhost" not in find_troubles(shown)[0] and "host:1" not in str(shown.workers)


def test_running_jobs_come_first(database, queue_job):
    """Broken where a long queue hides what runs."""
    from garmentq.service.jobs import claim
    from garmentq.service.query import list_jobs

    first, *rest = [queue_job(f"shirt{i}") for i in range(4)]
    claim(database, first, "w", 30.0)
    assert [row.id for row in list_jobs(database, 2)] == [first, rest[-1]]
