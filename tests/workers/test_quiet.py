"""When the dispatcher may leave out its rounds."""

from __future__ import annotations

import pytest
from garmentq.service.jobs import find_job
from garmentq.service.models import JobRow
from garmentq.service.outage import note_outage
from garmentq.service.states import State
from garmentq.workers.quiet import QuietQueue, has_work


def make_quiet(database, seconds: float = 1e6) -> QuietQueue:
    """Return a queue right after a round."""
    found = QuietQueue(database, seconds)
    found.begin()
    database.dispose()
    return found


def test_a_quiet_queue_needs_no_round_until_a_job_comes(database, queue_job):
    """Broken where an idle worker goes on polling, or a job that is submitted meanwhile waits for the next lease."""
    assert QuietQueue(database, 1e6).is_over()
    quiet = make_quiet(database)
    assert not quiet.is_over() and not quiet.is_over()
    queue_job()
    assert quiet.is_over() and make_quiet(database).is_over()


def test_leases_are_renewed(database):
    """Broken where a quiet queue loses its leader lease, or its worker's sign of life."""
    assert make_quiet(database, 0.0).is_over()


@pytest.mark.parametrize("state", State)
def test_whatever_is_open_keeps_the_rounds_going(database, queue_job, state):
    """Broken where the end of a pause or of a lease, which writes nothing, is noticed late."""
    job = queue_job()
    with database.write() as session:
        row = session.get_one(JobRow, job)
        row.state = state
        session.connection().exec_driver_sql("delete from outbox")
    assert has_work(database) is (state in (State.WAITING, State.QUEUED, State.RUNNING))
    assert find_job(database, job).state == state


def test_any_change_of_an_embedded_database_is_a_reason(database):
    """Broken where two writes in one tick of the file's clock, or one whose log is gone, look like none."""
    for n in range(5):
        quiet = make_quiet(database)
        note_outage(database, f"host{n}", "store.full")
        if n % 2:
            database.dispose()
        assert quiet.is_over() is database.is_sqlite
