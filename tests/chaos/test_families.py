"""A family of jobs whose processes are killed at every stage, with real workers and a real broker."""

from __future__ import annotations

import pytest
from garmentq.service.jobs import read_events
from garmentq.service.models import ArtifactRow
from garmentq.service.query import JobQuery, find_jobs
from garmentq.service.states import ENDED, State
from garmentq.service.submission import JobRequest, add_job
from garmentq.service.terms import JobTerms
from garmentq.workers.broker import start_broker
from garmentq_family import KINDS, PIECES, Root
from garmentq_home import SQLITE_BY_DAY, wait_ended, wait_for
from sqlalchemy import func, select

STAGES = ("begin", "end", "store")
KILLED = ("root", "front", "whole")
"""Parent, child, and the child that reads the others; what is left is a child like another."""


@SQLITE_BY_DAY
@pytest.mark.slow
def test_a_family_killed_at_every_stage(settings, database, queue_job, start_worker, marks, monkeypatch):
    """Broken where a kill loses a child, makes one twice, or a result is stored twice."""
    monkeypatch.setenv("STANDIN_KILLS", " ".join(KILLED))
    start_broker(settings)
    source = queue_job("source")
    with start_worker(lease_seconds=600.0, max_attempts=20, kinds=KINDS):
        scan = wait_ended(settings, source).scan
        with database.write() as session:
            root = add_job(session, JobRequest(Root.name, {"text": "one"}, scan, terms=JobTerms("Kleid"))).job
        wait_ended(settings, root)
        family = JobQuery({"family": root}).conditions
        wait_for(lambda: all(row.state in ENDED for row in find_jobs(database, family)))
    rows = {row.name: row for row in find_jobs(database, family)}
    assert sorted(rows) == sorted(["Kleid", *PIECES]) and {row.state for row in rows.values()} == {State.SUCCEEDED}
    for name, row in rows.items():
        kills = len(STAGES) * ({"Kleid": "root"}.get(name, name) in KILLED)
        kinds = [event.kind for event in read_events(database, row.id)]
        assert kinds.count("succeeded") == 1 and kinds.count("worker_lost") == kills
        assert (row.fence, row.attempts) == (kills + 1, kills + 1)
    with database.read() as session:
        counts = session.execute(
            select(ArtifactRow.job, func.count()).where(ArtifactRow.kind == "result").group_by(ArtifactRow.job)
        ).all()
    assert {job: count for job, count in counts if job != source} == {row.id: 1 for row in rows.values()}
    done = marks.read_text().splitlines()
    for name in ("root", *PIECES):
        times = [4, 3, 2] if name in KILLED else [1, 1, 1]
        assert [done.count(f"{name} {stage}") for stage in STAGES] == times, "each attempt came one stage further"
