"""The state machine: one owner at a time, and nothing from one who lost the job."""

from __future__ import annotations

import subprocess
import sys
import time
from collections import Counter

import pytest
from garmentq.service.database import clock
from garmentq.service.families import JobNotEnded, cancel, retry
from garmentq.service.jobs import (
    FenceLost,
    JobUnknown,
    claim,
    end_cancelled,
    fail,
    find_job,
    read_events,
    read_flags,
    renew,
)
from garmentq.service.kinds.recover import Recover
from garmentq.service.models import ArtifactRow, EventRow, JobRow, MetricRow, OutboxRow
from garmentq.service.progress import report
from garmentq.service.query import list_jobs
from garmentq.service.reaper import (
    acquire_leader_lease,
    dispatch,
    is_idle,
    reap,
    release_leader_lease,
    republish_stalled_jobs,
)
from garmentq.service.records import Progress
from garmentq.service.requeueing import release
from garmentq.service.results import load_checkpoint, save_checkpoint, store_result
from garmentq_home import make_environment
from garmentq_standin import make_recovery
from patience import WAIT_SECONDS
from sqlalchemy import func, select, text, update


def expire(database, job):
    """Put a lease into the past, as if its owner had died long ago."""
    with database.write() as session:
        session.execute(update(JobRow).where(JobRow.id == job).values(lease_until=clock() - 1.0))


def test_claim_is_exclusive_and_counts(database, queue_job):
    """Broken where a claim does not check the state: the second worker would get the job too."""
    job = queue_job()
    first = claim(database, job, "a", 30.0)
    assert (first.fence, first.attempt) == (1, 1)
    assert claim(database, job, "b", 30.0) is None
    row = find_job(database, job)
    assert (row.state, row.owner, row.attempts) == ("running", "a", 1)
    assert 29.0 < row.lease_until - row.started < 31.0, "the claim itself must write the lease"


def test_each_job_is_claimed_once_by_many_processes(settings, database, queue_job):
    """Broken where a transaction reads before it has the write lock: two processes would claim one job, or fail."""
    jobs = [queue_job(f"shirt{i}") for i in range(30)]
    script = (
        "import sys\n"
        "from garmentq.service.settings import read_settings\n"
        "from garmentq.service.database import open_database\n"
        "from garmentq.service.jobs import claim\n"
        "database = open_database(read_settings())\n"
        "for job in sys.argv[2:]:\n"
        "    if claim(database, job, sys.argv[1], 30.0):\n"
        "        print(job)\n"
    )
    processes = [
        subprocess.Popen(
            [sys.executable, "-c", script, f"owner{i}", *jobs],
            stdout=subprocess.PIPE,
            text=True,
            env=make_environment(settings),
        )
        for i in range(3)
    ]
    got = [process.communicate(timeout=WAIT_SECONDS)[0].split() for process in processes]
    assert [process.returncode for process in processes] == [0] * 3
    assert Counter(job for part in got for job in part) == Counter(jobs)


def test_a_zombie_writes_nothing(database, store, queue_job, tmp_path):
    """Broken where any write of a worker lacks the fence: the first owner's result would mix with the second's."""
    job = queue_job()
    zombie = claim(database, job, "zombie", 30.0)
    expire(database, job)
    reap(database, max_attempts=3)
    owner = claim(database, job, "owner", 30.0)
    assert owner.fence == zombie.fence + 1
    with database.read() as session:
        events = session.scalar(select(func.count()).select_from(EventRow))
    request = type("R", (), {"scan": tmp_path / "skirt.ply", "settings": type("S", (), {"fabric": "x", "seed": 0})})
    recovery = make_recovery(request, 1.0)
    folder = tmp_path / "files"
    folder.mkdir()
    (folder / "a.txt").write_text("a")
    for write in (
        lambda: report(database, zombie, Progress("drape", 0.5, "")),
        lambda: fail(database, zombie, "x", "x", bad_input=False),
        lambda: end_cancelled(database, zombie),
        lambda: release(database, zombie),
        lambda: save_checkpoint(database, store, zombie, "drape", b"state"),
        lambda: store_result(database, store, zombie, Recover(), recovery, folder),
    ):
        with pytest.raises(FenceLost):
            write()
    assert not renew(database, zombie, 30.0).is_owner
    assert not read_flags(database, zombie).is_owner
    with database.read() as session:
        assert session.scalar(select(func.count()).select_from(EventRow)) == events
        assert session.scalar(select(func.count()).select_from(ArtifactRow)) == 0
        assert session.scalar(select(func.count()).select_from(MetricRow)) == 0
    row = find_job(database, job)
    assert (row.state, row.owner, row.stage) == ("running", "owner", "")
    store_result(database, store, owner, Recover(), recovery, folder)
    assert find_job(database, job).state == "succeeded"


def test_reaper_requeues_then_gives_up(database, queue_job):
    """Broken where attempts are not counted at the claim: a job that kills its worker would run for ever."""
    job = queue_job("crash")
    for attempt in (1, 2, 3):
        assert claim(database, job, "a", 30.0).attempt == attempt
        assert reap(database, 3) == 0, "a lease that holds must be left alone"
        expire(database, job)
        assert reap(database, 3) == 1
    row = find_job(database, job)
    assert (row.state, row.error_code, row.lease_until) == ("dead", "job.worker_lost", None)
    kinds = [event.kind for event in read_events(database, job)]
    assert kinds == ["queued", "started", "lease_expired", "started", "lease_expired", "started", "dead"]
    retry(database, job)
    assert (find_job(database, job).state, find_job(database, job).attempts) == ("queued", 0)


def test_release_does_not_count_the_attempt(database, queue_job):
    """Broken where a deployment's SIGTERM used up attempts: three deployments would kill a healthy job."""
    job = queue_job()
    for _ in range(5):
        held = claim(database, job, "a", 30.0)
        assert held.attempt == 1
        release(database, held)
    assert find_job(database, job).state == "queued"


def test_cancel(database, queue_job):
    """Broken where cancelling a running job ended it under its worker, or a queued one could still be claimed."""
    queued, running = queue_job("one"), queue_job("two")
    assert cancel(database, queued) == "cancelled"
    assert claim(database, queued, "a", 30.0) is None
    held = claim(database, running, "a", 30.0)
    assert not read_flags(database, held).is_cancelled
    assert cancel(database, running) == "running"
    assert read_flags(database, held).is_cancelled and renew(database, held, 30.0).is_cancelled
    end_cancelled(database, held)
    assert cancel(database, running) == "cancelled"
    with pytest.raises(JobUnknown):
        cancel(database, "nosuchjob")


def test_a_cancelled_job_whose_worker_died_ends_cancelled(database, queue_job):
    """Broken where the reaper forgot the flag: the job would start once more only to be cancelled."""
    job = queue_job()
    claim(database, job, "a", 30.0)
    cancel(database, job)
    expire(database, job)
    reap(database, 3)
    assert find_job(database, job).state == "cancelled"


def test_retry_needs_an_ended_job(database, queue_job):
    """Broken where a retry could queue a job that a worker holds."""
    job = queue_job()
    with pytest.raises(JobNotEnded):
        retry(database, job)


def test_outbox_survives_a_broker_that_is_away(database, queue_job):
    """Broken where a row goes before its message was taken: a job submitted while the broker is down would wait."""
    jobs = [queue_job(f"shirt{i}") for i in range(3)]
    sent = []

    def publish(job, queue):
        if len(sent) == 1:
            raise ConnectionError("the broker is away")
        sent.append(job)

    with pytest.raises(ConnectionError):
        dispatch(database, publish)
    assert sent == jobs[:1]
    rest = []
    assert dispatch(database, lambda job, queue: rest.append(job)) == 2
    assert rest == jobs[1:]
    assert dispatch(database, lambda job, queue: rest.append(job)) == 0


def test_a_forgotten_job_is_published_again(database, queue_job):
    """Broken where the broker's memory were the truth: a FLUSHALL would leave the job queued for ever."""
    job = queue_job()
    dispatch(database, lambda *_: None)
    assert republish_stalled_jobs(database, 60.0, lambda: True) == 0
    time.sleep(0.1)
    assert republish_stalled_jobs(database, 0.05, lambda: False) == 0, "a broker that is only busy must not be flooded"
    assert republish_stalled_jobs(database, 0.05, lambda: True) == 1
    time.sleep(0.1)
    assert republish_stalled_jobs(database, 0.05, lambda: True) == 0, "what is already owed must not be owed twice"
    sent = []
    dispatch(database, lambda job, queue: sent.append(job))
    assert sent == [job]


def test_a_duty_has_one_holder(database):
    """Broken where the lock row is not compared and set: two dispatchers would publish each message twice."""
    assert acquire_leader_lease(database, "dispatcher", "a", 30.0)
    assert acquire_leader_lease(database, "dispatcher", "a", 30.0)
    assert not acquire_leader_lease(database, "dispatcher", "b", 30.0)
    release_leader_lease(database, "dispatcher", "b")
    assert not acquire_leader_lease(database, "dispatcher", "b", 30.0)
    release_leader_lease(database, "dispatcher", "a")
    assert acquire_leader_lease(database, "dispatcher", "b", 0.01)
    time.sleep(0.05)
    assert acquire_leader_lease(database, "dispatcher", "a", 30.0), "a dead holder's duty must come free"


def test_idle(database, queue_job):
    """Broken where a worker could go home while a job waits."""
    assert is_idle(database, 0.01)
    job = queue_job()
    time.sleep(0.05)
    assert not is_idle(database, 0.01)
    cancel(database, job)
    time.sleep(0.05)
    assert is_idle(database, 0.01)
    assert not is_idle(database, 60.0)


def test_checkpoints_outlive_an_attempt(database, store, queue_job):
    """Broken where a new attempt began from nothing, or kept an older state than the newest."""
    job = queue_job()
    held = claim(database, job, "a", 30.0)
    save_checkpoint(database, store, held, "drape", b"one")
    save_checkpoint(database, store, held, "drape", b"two")
    release(database, held)
    claim(database, job, "b", 30.0)
    assert load_checkpoint(database, store, job, "drape") == b"two"
    assert load_checkpoint(database, store, job, "deform") is None


def test_find_job_by_the_beginning_of_its_id(database, queue_job):
    """Broken where a short or ambiguous beginning picked some job, or a pattern sign was understood."""
    job = queue_job()
    queue_job("other")
    assert find_job(database, job[:6]).id == job
    for bad in (job[:3], "%%%%", "____", "", "x" * 50):
        with pytest.raises(JobUnknown):
            find_job(database, bad)
    assert len(list_jobs(database)) == 2


def test_the_outbox_row_comes_with_the_job(database, queue_job):
    """Broken where the row were written in another transaction: a crash between would forget the job."""
    job = queue_job()
    with database.read() as session:
        assert session.scalars(select(OutboxRow.job)).all() == [job]


def test_a_beginning_is_no_pattern(database, queue_job):
    """Broken where an id is found by another one's letters: by a sign of LIKE, or in capitals on SQLite alone."""
    job = queue_job()
    assert find_job(database, job[:6]).id == job
    wrong = ("______", "%%%%%%", job[:5] + "_", "ABCDEF")
    with database.write() as session:
        session.execute(text("delete from outbox"))
        session.execute(text("delete from events"))
        session.execute(text("delete from job_files"))
        session.execute(text("update jobs set id = 'abcdefghijkl', family = 'abcdefghijkl'"))
    for one in wrong:
        with pytest.raises(JobUnknown):
            find_job(database, one)
    assert find_job(database, "abcdef").id == "abcdefghijkl"
