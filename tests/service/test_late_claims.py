"""An attempt counts where its worker died, and does not where the worker was only late."""

from __future__ import annotations

from garmentq.service.database import clock
from garmentq.service.jobs import claim, fail, find_job, read_events, renew
from garmentq.service.late_claims import MAX_RETURNED_ATTEMPTS, RETURNED_EVENT, return_attempt
from garmentq.service.models import JobRow
from garmentq.service.reaper import reap, release_lost_leases
from garmentq.service.requeueing import release
from sqlalchemy import update


def lose(database, job, seconds=1.0):
    """Let a job's lease have run out some seconds ago."""
    with database.write() as session:
        session.execute(update(JobRow).where(JobRow.id == job).values(lease_until=clock() - seconds))


def test_a_late_worker_gives_the_attempt_back(database, queue_job):
    """Broken where an overloaded machine uses a job's attempts up, though no worker died."""
    job = queue_job()
    for _ in range(2):  # queued again: nobody has claimed it since
        late = claim(database, job, "late", 30.0)
        lose(database, job)
        assert reap(database, 3) == 1 and find_job(database, job).attempts == 1
        assert return_attempt(database, late)
        assert (find_job(database, job).state, find_job(database, job).attempts) == ("queued", 0)
        assert not return_attempt(database, late), "once"
    late = claim(database, job, "late", 30.0)
    lose(database, job)
    reap(database, 3)
    owner = claim(database, job, "owner", 30.0)
    assert owner.attempt == 2 and return_attempt(database, late)
    row = find_job(database, job)
    assert (row.state, row.owner, row.attempts, row.fence) == ("running", "owner", 1, owner.fence)
    release(database, owner)
    assert find_job(database, job).attempts == 0
    assert [event.kind for event in read_events(database, job)].count(RETURNED_EVENT) == 3


def test_nothing_is_given_back_by_whoever_owns_or_has_ended(database, queue_job):
    """Broken where a worker's report lowers the count of a valid claim, of an ended job or of a retried one."""
    job = queue_job()
    held = claim(database, job, "a", 30.0)
    assert not return_attempt(database, held) and find_job(database, job).attempts == 1
    fail(database, held, "x", "x", bad_input=False)
    assert not return_attempt(database, held)
    row = find_job(database, job)
    assert (row.state, row.attempts) == ("failed", 1)


def test_a_job_that_always_outlasts_its_lease_ends(database, queue_job):
    """Broken where a job that no machine can run within its lease is repeated for ever."""
    job = queue_job()
    for number in range(MAX_RETURNED_ATTEMPTS + 3):
        late = claim(database, job, "late", 30.0)
        lose(database, job)
        reap(database, 3)
        assert return_attempt(database, late) == (number < MAX_RETURNED_ATTEMPTS)
    assert find_job(database, job).state == "dead"


def test_the_last_attempt_of_a_late_worker_goes_on(database, queue_job):
    """Broken where a job is dead whose worker renews its lease a moment later, or one that has died is waited for."""
    job = queue_job()
    for attempt in (1, 2, 3):
        last = claim(database, job, "host:1:mark", 30.0)
        assert last.attempt == attempt
        lose(database, job)
        assert reap(database, 3, patience=60.0) == (1 if attempt < 3 else 0)
    assert renew(database, last, 30.0).is_owner and find_job(database, job).state == "running"
    lose(database, job, 61.0)
    with database.read() as session:
        assert session.get(JobRow, job).lease_until < session.scalar(clock().select())
    release_lost_leases(database, "mark", "signal 9")
    assert reap(database, 3, patience=60.0) == 1 and find_job(database, job).state == "dead"
