"""A family of jobs in the stand-in home: the fixture that queues its root, and what works it off."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

import pytest
from garmentq.service.families import cancel, release_waiting_jobs
from garmentq.service.jobs import find_job
from garmentq.service.kinds import FileRef, pack_request
from garmentq.service.kinds.person_request import PersonRequest
from garmentq.service.models import JobRow
from garmentq.service.query import JobQuery, find_jobs
from garmentq.service.submission import JobRequest, add_job
from garmentq.service.terms import JobTerms
from garmentq.workers.recovery import run_job
from garmentq_family import KINDS, Root
from garmentq_home import put_file

PERSONS = {"separator": "garmentq_person:take_apart", "person_checker": "garmentq_checker:check"}
"""Settings under which persons are taken apart at once."""

REMOTE_BY_DAY = pytest.mark.parametrize(
    "backend", [pytest.param("local", marks=pytest.mark.nightly), "remote"], indirect=True
)
"""Asks the service in the suite, and at night the home itself, too: the same functions stand behind both."""


@pytest.fixture
def family(settings, database, queue_job, monkeypatch, tmp_path):
    """Return a function that queues a root, and settings under which it runs."""
    monkeypatch.setenv("STANDIN_MARKS", str(tmp_path / "marks"))
    chosen = replace(settings, kinds=KINDS)
    source = find_job(database, queue_job("source"))

    def queue(text: str = "one", inputs=MappingProxyType({}), **terms) -> str:
        wanted = JobRequest(Root.name, {"text": text}, source.scan, inputs, JobTerms("Kleid", **terms))
        with database.write() as session:
            return add_job(session, wanted).job

    cancel(database, source.id)
    return chosen, queue


@pytest.fixture
def queue_person(database, store, queue_job, tmp_path):
    """Return a function that queues a person of a file's name."""
    source = queue_job("source")
    cancel(database, source)

    def queue(name: str = "anna.ply", **given) -> str:
        kept = store.put(put_file(tmp_path, name))
        request = pack_request(PersonRequest(FileRef(kept.sha256, name), **given))
        with database.write() as session:
            return add_job(
                session, JobRequest("person", request, find_job(database, source).scan, terms=JobTerms("Anna"))
            ).job

    return queue


@pytest.fixture
def persons(settings):
    """Return settings under which persons are taken apart at once."""
    return replace(settings, **PERSONS)


def work_off(settings, database) -> None:
    """Run whatever can be run."""
    for _ in range(50):
        release_waiting_jobs(database)
        queued = find_jobs(database, JobQuery({"state": "queued"}).conditions)
        if not queued:
            return
        run_job(settings, database, queued[0].id, lambda: False)
    raise AssertionError(f"never ends: {[(row.id, row.state, row.cancel) for row in queued]}")


def pieces(database, root) -> dict[str, JobRow]:
    """Return a root's children by name."""
    return {row.name: row for row in find_jobs(database, JobQuery({"parent": root}).conditions)}
