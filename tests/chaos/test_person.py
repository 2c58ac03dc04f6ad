"""A person's job whose processes are killed in its middle and at its end, with real workers and a real broker."""

from __future__ import annotations

import pytest
from garmentq.service.jobs import find_job, read_events
from garmentq.service.query import JobQuery, find_jobs
from garmentq.service.states import ENDED, State
from garmentq.service.submission import Order, submit
from garmentq.workers.broker import start_broker
from garmentq_home import SQLITE_BY_DAY, put_file, wait_ended, wait_for

PERSONS = {"separator": "garmentq_person:take_apart", "person_checker": "garmentq_checker:check"}
STAGES = ("garments", "store")


@SQLITE_BY_DAY
@pytest.mark.slow
def test_a_person_killed_in_the_middle(settings, database, store, start_worker, marks, monkeypatch, tmp_path):
    """Breaks where a kill in the middle of the parent loses a garment's job, or makes one twice."""
    monkeypatch.setenv("STANDIN_KILLS", "person")
    start_broker(settings)
    with start_worker(lease_seconds=600.0, max_attempts=20, **PERSONS):
        root = submit(database, store, Order(put_file(tmp_path, "anna.ply"), None)).job
        wait_ended(settings, root)
        family = JobQuery({"family": root}).conditions
        wait_for(lambda: all(row.state in ENDED for row in find_jobs(database, family)))
    rows = {row.name: row for row in find_jobs(database, family)}
    assert sorted(rows) == ["anna", "lower", "upper"] and {row.state for row in rows.values()} == {State.SUCCEEDED}
    assert find_job(database, root).kind == "person"
    for name, row in rows.items():
        kills = len(STAGES) if name == "anna" else 0
        kinds = [event.kind for event in read_events(database, row.id)]
        assert (kinds.count("succeeded"), kinds.count("worker_lost")) == (1, kills), name
        assert row.attempts == kills + 1
    done = marks.read_text().splitlines()
    assert [done.count(f"person {stage}") for stage in STAGES] == [3, 2], "each attempt came one stage further"
