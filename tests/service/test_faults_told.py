"""Each fault that stops the queue is told by `status`, `doctor` and `/readyz`, in words and with the next step."""

from __future__ import annotations

import asyncio
import shutil
from collections import namedtuple

import httpx
import pytest
from garmentq.service.api.app import make_app
from garmentq.service.models import LockRow, WorkerRow
from garmentq.service.reaper import DISPATCHER_LEASE, acquire_leader_lease, record_heartbeat
from garmentq.workers import patience
from garmentq.workers.recovery import run_job

HOUR = 3600.0

pytestmark = pytest.mark.parametrize("database_kind", ["sqlite"], indirect=True)  # what is said is the same

STEPS = ("mount it", "GARMENTQ_STORE")
"""What to do about a store that is away."""

Usage = namedtuple("Usage", "total used free")


@pytest.fixture
def tell(settings, cli):
    """Return what each of the three says, as one text each."""

    def ask(*which: str) -> dict[str, str]:
        return {name: found[name]() for name in which or found}

    def read_ready() -> str:
        app = make_app(settings)

        async def get() -> httpx.Response:
            async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://127.0.0.1") as client:
                return await client.get("/readyz")

        try:
            return asyncio.run(get()).text
        finally:
            app.state.rooms.database.dispose()

    def run(command: str) -> str:
        done = cli(command)
        return " ".join((done.stdout + done.stderr).split())

    found = {"status": lambda: run("status"), "doctor": lambda: run("doctor"), "/readyz": read_ready}
    return ask


def never() -> bool:
    """Never drain."""
    return False


def meet_outage(settings, database, job, monkeypatch) -> None:
    """Make a worker meet what is away."""
    monkeypatch.setattr(patience, "MAX_OUTAGE_PAUSE", 0.1)
    record_heartbeat(database, "host:1", "cpu", 1, 30.0)
    acquire_leader_lease(database, DISPATCHER_LEASE, "host:1", 5.0)
    assert run_job(settings, database, job, never) == "unclaimed"


def test_a_store_that_is_away(settings, database, store, queue_job, tell, monkeypatch):
    """Broken where an unmounted disk looks like a fresh home, or nobody is told what to mount."""
    job = queue_job()
    store.root.rename(store.root.with_name("away"))
    meet_outage(settings, database, job, monkeypatch)
    for name, text in tell().items():
        assert ("store.unreachable" in text and "GARMENTQ_STORE" in text) or "mount it" in text, (name, text)
    assert "jobs wait since" in tell("status")["status"]


def test_a_store_that_is_full(settings, database, queue_job, tell, monkeypatch):
    """Broken where a full disk is only a code."""
    job = queue_job()
    monkeypatch.setattr(shutil, "disk_usage", lambda _: Usage(1, 1, 0))
    meet_outage(settings, database, job, monkeypatch)
    for name, text in tell().items():
        assert "store.full" in text and "free some disk space" in text, (name, text)


def test_a_clock_that_was_set_back(database, queue_job, tell):
    """Broken where rows of a dead worker, an hour ahead, look alive."""
    queue_job()
    record_heartbeat(database, "dead:1", "cpu", 1, 30.0)
    acquire_leader_lease(database, DISPATCHER_LEASE, "dead:1", 5.0)
    with database.write() as session:
        session.query(LockRow).update({"until": LockRow.until + HOUR})
        session.query(WorkerRow).update({"seen": WorkerRow.seen + HOUR})
    for name, text in tell().items():
        assert "no worker is up" in text and "garmentq up" in text, (name, text)
    record_heartbeat(database, "new:1", "cpu", 1, 30.0)
    for name, text in tell().items():
        assert "no dispatcher has acted yet" in text and "restart them" in text, (name, text)


def test_a_clock_that_was_set_ahead(database, queue_job, tell):
    """Broken where nobody is told that nothing was dispatched for an hour."""
    queue_job()
    acquire_leader_lease(database, DISPATCHER_LEASE, "host:1", 5.0)
    with database.write() as session:
        session.query(LockRow).update({"until": LockRow.until - HOUR})
    record_heartbeat(database, "host:1", "cpu", 1, 30.0)
    for name, text in tell().items():
        assert "no dispatcher has acted for 360" in text and "restart them" in text, (name, text)


def test_a_damaged_database(settings, database, queue_job, tell):
    """Broken where a damaged file is a traceback, or the API says no more than that it is not ready."""
    queue_job()
    database.dispose()
    path = settings.home / "garmentq.db"
    for left in settings.home.glob("garmentq.db-*"):
        left.unlink()
    app = make_app(settings)
    app.state.rooms.database.dispose()
    path.write_bytes(path.read_bytes()[:4096] + bytes(40000))
    for name, text in tell("status", "doctor").items():
        assert "service.database_damaged" in text and "garmentq restore" in text, (name, text)

    async def get() -> str:
        async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://127.0.0.1") as client:
            return (await client.get("/readyz")).text

    text = asyncio.run(get())
    app.state.rooms.database.dispose()
    assert "service.database_damaged" in text and "garmentq restore" in text
