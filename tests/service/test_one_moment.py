"""A list of jobs while a job's state changes between two of its queries, or of its requests."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from garmentq.service.database import Database
from garmentq.service.jobs import claim
from garmentq.service.local_token import make_local_token
from garmentq.service.query import list_jobs
from garmentq.service.remote import RemoteBackend
from garmentq.service.requeueing import release
from sqlalchemy import event


def call_once(call: Callable[[], object]) -> Callable[[], None]:
    """Return a function that makes a call, the first time only."""
    left = [call]

    def act() -> None:
        if left:
            left.pop()()

    return act


def act_after_first_query(database: Database, call: Callable[[], object]) -> None:
    """Make a call after the next query of a database, before its transaction's second one."""
    act = call_once(call)

    def listen(connection, cursor, statement: str, *_: object) -> None:
        if statement.startswith("SELECT"):
            act()

    event.listen(database.engine, "after_cursor_execute", listen)


@pytest.fixture
def other(settings, database):
    """Open the database a second time, as a worker has it."""
    opened = Database(settings.database, pooled=False)
    yield opened
    opened.dispose()


def test_a_job_that_starts_meanwhile_is_listed_once(database, other, queue_job):
    """Broken where a query sees what was committed after the first one: the job is then neither among the running ones
    nor among the others."""
    jobs = [queue_job(name) for name in ("a", "b", "c")]
    started = []
    act_after_first_query(database, lambda: started.append(claim(other, jobs[0], "w", 30.0)))
    found = list_jobs(database)
    assert started[0] is not None, "the state changed within the list"
    assert sorted(row.id for row in found) == sorted(jobs)
    assert [row.id for row in list_jobs(database)] == [jobs[0], jobs[2], jobs[1]]


def test_a_job_that_returns_to_the_queue_meanwhile_is_listed_once(database, other, queue_job):
    """Broken where a job that gives way between two queries is listed as running and as queued."""
    jobs = [queue_job(name) for name in ("a", "b")]
    held = claim(other, jobs[0], "w", 30.0)
    act_after_first_query(database, lambda: release(other, held))
    assert [row.id for row in list_jobs(database)] == jobs
    assert [row.id for row in list_jobs(database)] == jobs[::-1]


@pytest.mark.parametrize("database_kind", ["sqlite"], indirect=True)
@pytest.mark.parametrize("limit", [1, 2, 3])
def test_a_job_that_starts_between_two_requests_is_listed(settings, database, queue_job, serve, limit):
    """Broken where the running jobs are asked for first: one that starts after that, and is older than the newest
    others, is in neither answer."""
    jobs = [queue_job(name) for name in ("a", "b", "c")]
    start, send = call_once(lambda: claim(database, jobs[0], "w", 30.0)), serve._ask

    def send_and_start(*words, **fields):
        answer = send(*words, **fields)
        start()
        return answer

    serve._ask = send_and_start
    assert [job.id for job in serve.list_jobs(limit)] == [jobs[0], jobs[2], jobs[1]][:limit]


@pytest.fixture
def serve(settings):
    """Return the backend of a service that serves the home."""
    from api_client import serving

    with serving(settings) as url, RemoteBackend(url, make_local_token(settings.home)) as opened:
        yield opened
