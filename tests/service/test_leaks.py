"""What outsiders are told: no password, no host, no folder, no text of a crash; and what the database cannot hold."""

from __future__ import annotations

import asyncio
import logging
import socket
from collections import Counter
from contextlib import contextmanager
from dataclasses import replace

import httpx
import pytest
from api_client import carrying, local_user, serving
from api_routes import list_pages, list_routes
from api_work import make_key
from garmentq.service.api.app import make_app
from garmentq.service.api.limits import ApiLimits
from garmentq.service.database import Database, DatabaseDamaged, DatabaseEmpty, DatabaseTooOld, open_database
from garmentq.service.health import find_troubles, hide_worker_names, read_queue
from garmentq.service.jobs import claim, find_job
from garmentq.service.outage import note_outage
from garmentq.service.query import JobQuery, QueryBad
from garmentq.service.reaper import DISPATCHER_LEASE, acquire_leader_lease, record_heartbeat
from garmentq.service.requeueing import reschedule
from garmentq.service.settings import ServiceSettingBad, hide_password
from garmentq.service.store import StoreUnreachable
from garmentq.workers.recovery import run_job
from garmentq_home import drop_tables
from sqlalchemy import text
from sqlalchemy.engine import make_url

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
    app = make_app(settings, is_open=True)
    app.state.rooms.database.dispose()
    away = Database("postgresql://postgres:S3cret@127.0.0.1:1/secretname", pooled=False)
    app.state.rooms = replace(app.state.rooms, database=away)

    async def ask():
        async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://127.0.0.1") as client:
            return await client.get("/v1/jobs", headers={"authorization": "Bearer x"})

    with caplog.at_level(logging.WARNING):
        answer = asyncio.run(ask())
    assert answer.status_code == 503 and answer.json()["code"] == "service.database_unreachable"
    assert not any(word in answer.text for word in ("postgres:", "S3cret", "secretname", "127.0.0.1", ":1/"))
    assert "secretname" in caplog.text and "S3cret" not in caplog.text, "the log has it, without the password"


@pytest.mark.parametrize("database_kind", ["sqlite"], indirect=True)
def test_what_a_job_waits_for_tells_no_place(settings, database, queue_job, store):
    """Broken where the folder of a store that is away stands in a job's events, which its key reads."""
    job = queue_job()
    held = claim(database, job, "w", 60.0)
    store.root.rename(store.root.with_name("aside"))
    with pytest.raises(StoreUnreachable, match=str(settings.home)) as gone:
        store.check()
    reschedule(database, held, gone.value, 0.1)
    with serving(settings) as url:
        told = httpx.get(f"{url}/v1/jobs/{job}/events", headers=local_user(settings), timeout=60.0).text
    assert "store.unreachable" in told and str(settings.home) not in told


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
        with pytest.raises(DatabaseEmpty):
            open_database(settings)
        open_database(settings, is_upgraded=True).dispose()


@pytest.mark.parametrize("database_kind", ["sqlite"], indirect=True)
def test_what_stands_still_is_said(database, queue_job):
    """Broken where a queue that nobody works on looks healthy, or an outsider reads the name of a machine."""
    assert find_troubles(read_queue(database)) == []
    queue_job()
    assert "no worker is up" in find_troubles(read_queue(database))[0]
    record_heartbeat(database, "host:1", "cpu", 1, 30.0)
    assert "no dispatcher" in find_troubles(read_queue(database))[0]
    acquire_leader_lease(database, DISPATCHER_LEASE, "host:1", 5.0)
    assert find_troubles(read_queue(database)) == []
    note_outage(database, "myhost", "store.full")
    [trouble] = find_troubles(read_queue(database))
    assert "myhost" in trouble and "store.full" in trouble and "free some disk space" in trouble
    shown = hide_worker_names(read_queue(database))
    assert "myhost" not in find_troubles(shown)[0] and "host:1" not in str(shown.workers)


def test_running_jobs_come_first(database, queue_job):
    """Broken where a long queue hides what runs."""
    from garmentq.service.query import list_jobs

    first, *rest = [queue_job(f"shirt{i}") for i in range(4)]
    claim(database, first, "w", 30.0)
    assert [row.id for row in list_jobs(database, 2)] == [first, rest[-1]]


@pytest.mark.parametrize("database_kind", ["sqlite"], indirect=True)
def test_names_of_an_inner_network_are_not_found_by_trial(settings, database, monkeypatch):
    """Broken where a key learns by a trial message whether a name of the operator's network is there, or may try names
    without end."""
    real = socket.getaddrinfo

    def find(host, port, *given, **more):
        if host == "inner.example":
            return [(socket.AF_INET, socket.SOCK_STREAM, 6, "", ("10.0.0.7", port))]
        if host == "nosuch.example":
            raise socket.gaierror(socket.EAI_NONAME, "no such name")
        return real(host, port, *given, **more)

    monkeypatch.setattr(socket, "getaddrinfo", find)
    api, us = serving(settings), local_user(settings)
    with carrying(settings), api as url, httpx.Client(base_url=url, headers=us, timeout=60.0) as client:
        told = []
        for name in ("inner.example", "nosuch.example"):
            hook = client.post("/v1/webhooks", json={"url": f"https://{name}/"}).json()["webhook"]
            told.append(client.post(f"/v1/webhooks/{hook}/test").json())
        assert told[0] == told[1] and told[0]["status"] is None and "no public address" in told[0]["error"]
        statuses = [client.post(f"/v1/webhooks/{hook}/test").status_code for _ in range(8)]
        assert 429 in statuses[3:], statuses


@contextmanager
def away(settings, request):
    """Take the database away for the block: PostgreSQL is stopped, the file of SQLite overwritten."""
    if settings.database_url:
        server = request.getfixturevalue("postgres_server")
        server.stop()
        try:
            yield
        finally:
            server.start()
        return
    path = settings.home / "garmentq.db"
    for one in (path, *path.parent.glob("garmentq.db-*")):  # its log and the log's index, or pages come from a cache
        with one.open("r+b") as stream:
            stream.write(b"no database at all" * max(1, one.stat().st_size // 18))
    yield


def test_no_page_and_no_route_tells_where_the_database_is(settings, database, queue_job, request, caplog):
    """Broken where anybody, with a key, a session or neither, reads on any page or route where the database is that is
    away, or who may log in there."""
    key = make_key(database, "studio", "admin", "read")
    job = queue_job()
    paths = {path for path, _ in list_pages()} | {path for way, path, _ in list_routes(settings) if way == "GET"}
    words = [str(settings.home), "garmentq.db", "sqlite", "postgresql", "connection to server"]
    if settings.database_url:
        place = make_url(settings.database_url)
        words += [place.database, place.host or place.query["host"]]
    database.dispose()
    statuses, wrong = Counter(), {"authorization": "Bearer gq_wrong"}
    with serving(settings, ApiLimits(wrong_keys=10**6), is_open=False) as url:
        options = {"base_url": url, "timeout": 60.0, "verify": False}
        with httpx.Client(**options) as stranger, httpx.Client(**options) as browser:
            token = key["authorization"].removeprefix("Bearer ")
            assert browser.post("/signin", data={"token": token}).status_code == 303
            csrf = browser.get("/").text.split('name="csrf-token" content="')[1].split('"')[0]
            with away(settings, request):
                answers = []
                for path in paths:
                    place = path.format(
                        job=job, number=0, column=0, name="x", sha256="ab" * 32, token="x", subject=job, tag="x"
                    )
                    for client, headers in ((stranger, {}), (stranger, key), (stranger, wrong), (browser, {})):
                        answers.append(client.get(place, headers=headers))
                answers += [stranger.post("/signin", data={"token": one}) for one in ("gq_wrong", "", token)]
                answers += [browser.post("/signout", data={"csrf": csrf}), stranger.get("/signin?link=abc")]
    for answer in answers:
        told = answer.text + str(answer.headers)
        assert not [word for word in words if word in told], (answer.request.url, told[:2000])
        statuses[answer.status_code] += 1
    assert statuses[503] > 60 and not statuses[500], statuses
