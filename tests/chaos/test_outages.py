"""Faults R22 to R25: a store that is away or full, and a clock that is set, cost no job an attempt."""

from __future__ import annotations

import pytest
from garmentq.core.run.errors import BadInput, GarmentqError
from garmentq.service.clocks import ClockJumpGuard, clamp_future_times
from garmentq.service.families import cancel
from garmentq.service.jobs import claim, find_job, read_events
from garmentq.service.models import JobRow, LockRow, WorkerRow
from garmentq.service.outage import MAX_OUTAGE_PAUSE, find_outage, find_pause, list_outages
from garmentq.service.reaper import (
    DISPATCHER_LEASE,
    acquire_leader_lease,
    dispatch,
    list_workers,
    reap,
    record_heartbeat,
    republish_stalled_jobs,
)
from garmentq.service.store import StorageFull, Store, StoreUnreachable
from garmentq.workers import patience
from garmentq.workers.broker import start_broker
from garmentq.workers.recovery import run_job
from garmentq.workers.watch import LeaseKeeper
from garmentq_home import wait_ended, wait_for
from garmentq_standin import STEPS, hold_gate

HOUR = 3600.0


SECONDS = 30.0
"""Deadline of these tests."""


def never():
    """Never drain."""
    return False


def let_go(database, job):
    """End a job's rest."""
    with database.write() as session:
        session.get(JobRow, job).not_before = 1.0


@pytest.mark.slow
@pytest.mark.parametrize("database_kind", ["sqlite"], indirect=True)
def test_r22_the_store_is_away(settings, database, queue_job, start_worker, marks):
    """Broken where an outage of the store ends jobs, spends attempts, or lets a worker claim what it cannot do."""
    start_broker(settings)
    hold_gate(marks, 8)
    first, *rest = [queue_job(name) for name in ("gated", *(f"shirt{i}" for i in range(5)))]
    away = settings.store_path.with_name("away")
    with start_worker(pause_seconds=0.2):
        wait_for(lambda: marks.exists() and len(marks.read_text().splitlines()) == 8)
        settings.store_path.rename(away)
        hold_gate(marks, STEPS)
        wait_for(lambda: list_outages(database) or find_job(database, first).state != "running")
        wait_for(lambda: "cannot be" in (text := (settings.home / "worker.log").read_text()) or "unavailable" in text)
        assert {find_job(database, job).state for job in (first, *rest)} <= {"queued", "running"}
        away.rename(settings.store_path)
        rows = [wait_ended(settings, job) for job in (first, *rest)]
        wait_for(lambda: not list_outages(database))
    assert [(row.state, row.attempts) for row in rows] == [("succeeded", 1)] * 6


def test_r22_a_worker_without_a_store_claims_nothing(settings, database, store, queue_job, monkeypatch):
    """Broken where a job is begun that cannot be done, or nobody is told what is waited for."""
    monkeypatch.setattr(patience, "MAX_OUTAGE_PAUSE", 0.3)
    job = queue_job()
    store.root.rename(store.root.with_name("away"))
    assert run_job(settings, database, job, never) == "unclaimed"
    assert [one.code for one in list_outages(database)] == ["store.unreachable"]
    store.root.with_name("away").rename(store.root)
    assert (find_job(database, job).state, find_job(database, job).attempts) == ("queued", 0)
    assert run_job(settings, database, job, never) == "succeeded"
    assert list_outages(database) == []


def test_r23_the_store_is_full_then_there_is_room(settings, database, queue_job, monkeypatch):
    """Broken where a full disk ends a job, spends its attempts, or keeps it from going on once there is room."""
    monkeypatch.setattr(patience, "MAX_OUTAGE_PAUSE", 0.3)
    job = queue_job()
    with monkeypatch.context() as full:
        full.setattr(Store, "put_stream", refuse)
        assert run_job(settings, database, job, never) == "put_off"
    row = find_job(database, job)
    assert (row.state, row.attempts, row.delays, row.delay_code) == ("queued", 0, 1, "store.full")
    assert [event.kind for event in read_events(database, job)][-1] == "put_off"
    assert run_job(settings, database, job, never) == "unclaimed", "it rests"
    assert dispatch(database, lambda *_: None) == 0 and republish_stalled_jobs(database, -1.0, lambda: True) == 0, (
        "nor is it woken"
    )
    let_go(database, job)
    assert dispatch(database, lambda *_: None) >= 1
    assert run_job(settings, database, job, never) == "succeeded"
    assert find_job(database, job).attempts == 1


def refuse(*_):
    """Refuse to keep anything, as a full disk does."""
    raise OSError(28, "No space left on device")


def test_room_is_asked_for_before_a_claim(settings, database, store, queue_job, monkeypatch):
    """Broken where a job begins on a disk that cannot hold its result."""
    from dataclasses import replace

    monkeypatch.setattr(patience, "MAX_OUTAGE_PAUSE", 0.2)
    job = queue_job()
    assert run_job(replace(settings, free_bytes=1 << 60), database, job, never) == "unclaimed"
    assert [one.code for one in list_outages(database)] == ["store.full"]
    with pytest.raises(StorageFull, match="GARMENTQ_FREE_BYTES"):
        store.check(1 << 60)


@pytest.mark.parametrize("database_kind", ["sqlite"], indirect=True)
def test_what_is_an_outage_and_how_long_it_is_waited_for(database, store, queue_job):
    """Broken where bad input or a bug is tried for ever, an outage is not, or the pause has no end."""
    assert isinstance(find_outage(OSError(28, "full")), StorageFull)
    assert isinstance(find_outage(OSError(5, "input/output error")), StoreUnreachable)
    for error in (OSError(2, "no such file"), ValueError("x"), BadInput(), GarmentqError()):
        assert find_outage(error) is None
    pauses = [find_pause(2.0, times) for times in (0, 1, 2, 50, 5000)]
    assert pauses == [2.0, 4.0, 8.0, MAX_OUTAGE_PAUSE, MAX_OUTAGE_PAUSE]
    job = queue_job()
    held = claim(database, job, "a", 30.0)
    cancel(database, job)
    from garmentq.service.requeueing import reschedule

    reschedule(database, held, StorageFull(), 2.0)
    assert find_job(database, job).state == "cancelled", "a rest must not outlive the wish to stop"


def test_a_database_away_for_longer_than_a_lease(settings, database, queue_job, monkeypatch):
    """Broken where an outage of the database costs each running job an attempt: its owner could not renew its lease."""
    from garmentq.service.database import DatabaseUnreachable
    from garmentq.workers import watch

    held = claim(database, queue_job(), "a", 0.2)

    def away(*_):
        raise DatabaseUnreachable()

    with monkeypatch.context() as gone, LeaseKeeper(database, held, 0.2, 0.05, 60.0, never) as seen:
        gone.setattr(watch, "renew", away)
        gone.setattr(watch, "read_flags", away)
        leaps = ClockJumpGuard(60.0)
        leaps.note_outage()
        import time

        time.sleep(0.5)
        assert not seen.must_stop() and not leaps.is_steady
        gone.undo()
        before = find_job(database, held.job).lease_until
        wait_for(lambda: find_job(database, held.job).lease_until > before)
    assert find_job(database, held.job).state == "running"


def shift(database, seconds):
    """Move every time in the database, as a step of its clock by the negative leaves it."""
    with database.write() as session:
        for row in session.query(JobRow):
            row.touched += seconds
            row.lease_until = None if row.lease_until is None else row.lease_until + seconds
        for row in session.query(LockRow):
            row.until += seconds
        for row in session.query(WorkerRow):
            row.seen += seconds


def test_r24_the_clock_goes_back_an_hour(database, queue_job):
    """Broken where the queue stands until the clock has caught up, a dead worker lives, or a living one is lost."""
    lost, queued = queue_job("lost"), queue_job("queued")
    held = claim(database, lost, "dead", 0.3)
    assert acquire_leader_lease(database, DISPATCHER_LEASE, "dead", 5.0)
    record_heartbeat(database, "dead", "cpu", 1, 30.0)
    shift(database, HOUR)
    assert list_workers(database) == []
    assert acquire_leader_lease(database, DISPATCHER_LEASE, "new", 5.0), (
        "a duty that lies further ahead than it is held is nobody's"
    )
    assert reap(database, 9) == 0
    assert clamp_future_times(database) == 2 and clamp_future_times(database) == 0
    assert find_job(database, held.job).state == "running", "its owner has one more lease"
    wait_for(lambda: reap(database, 9) == 1)
    assert find_job(database, lost).state == "queued"
    dispatch(database, lambda *_: None)
    wait_for(lambda: republish_stalled_jobs(database, 0.2, lambda: True) >= 1)
    assert queued


def test_r25_the_clock_leaps_ahead(monkeypatch):
    """Broken where leases of living workers end at once, and each costs an attempt."""
    from garmentq.service import clocks

    steady = [100.0]
    monkeypatch.setattr(clocks.time, "monotonic", lambda: steady[0])
    leaps = ClockJumpGuard(30.0)
    leaps.note(1e9)
    steady[0] += 0.5
    leaps.note(1e9 + 0.5)
    assert leaps.is_steady
    steady[0] += 0.5
    leaps.note(1e9 + HOUR)
    assert not leaps.is_steady
    steady[0] += 31.0
    leaps.note(1e9 + HOUR + 31.0)
    assert leaps.is_steady, "after a lease in which all could renew"


def test_who_waited_longest_is_next(database, queue_job):
    """Broken where one key's many jobs stand before another's one, or priority is asked after fairness."""
    from garmentq.service.jobs import claim_next

    many = [queue_job(f"many{i}") for i in range(4)]
    few = [queue_job(f"few{i}") for i in range(2)]
    urgent = queue_job("urgent", priority=7)
    with database.write() as session:
        for job, payer in {**dict.fromkeys(many, "a"), **dict.fromkeys(few, "b"), urgent: "a"}.items():
            session.get(JobRow, job).payer = payer
    taken = [claim_next(database, many[0], "w", 30.0).job for _ in range(7)]
    assert taken == [urgent, few[0], many[0], few[1], *many[1:]]
    assert claim_next(database, many[0], "w", 30.0) is None


@pytest.mark.slow
@pytest.mark.parametrize("database_kind", ["sqlite"], indirect=True)
def test_a_worker_sends_what_is_owed(settings, database, queue_job, start_worker, marks):
    """Broken where nobody sends messages, or a receiver that is away for a while is never told."""
    import socket

    from garmentq.service.models import DeliveryRow
    from garmentq.service.webhooks import create_webhook, list_webhooks

    start_broker(settings)
    with socket.create_server(("127.0.0.2", 0)) as server:
        port = server.getsockname()[1]
    create_webhook(database, f"http://127.0.0.2:{port}/", (), "127.0.0.2/32")
    job = queue_job()
    with start_worker(webhook_networks="127.0.0.2/32"):
        wait_ended(settings, job)
        wait_for(lambda: list_webhooks(database)[0].error)
        with socket.create_server(("127.0.0.2", port)) as server:
            with database.write() as session:
                session.query(DeliveryRow).update({"due": 1.0})
            taken, _ = server.accept()
            with taken:
                assert taken.recv(65536).startswith(b"POST / HTTP/1.1\r\n")
                taken.sendall(b"HTTP/1.1 200 OK\r\ncontent-length: 0\r\n\r\n")
                wait_for(lambda: list_webhooks(database)[0].owed == 0)
