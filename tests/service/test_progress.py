"""How far a job is in all, and the time to go."""

from __future__ import annotations

import math

import pytest
from garmentq.service.jobs import claim, find_job, read_events
from garmentq.service.metrics import prometheus_text
from garmentq.service.models import JobRow
from garmentq.service.progress import LEARNT_JOBS, Pace, ProgressEstimator, learn_pace, report
from garmentq.service.records import Job, Progress
from garmentq.service.requeueing import release
from garmentq.service.states import State
from garmentq.workers.recovery import run_job
from sqlalchemy import text

PACE = Pace({"scan": 1.0, "drape": 3.0, "deform": 4.0}, 80.0)


def test_shares_of_stages():
    """Broken where the whole is not the sum of what its stages take, or a stage that nobody knows moves it."""
    found = [PACE.find_share(*at) for at in (("scan", 0.0), ("scan", 1.0), ("drape", 0.5), ("deform", 1.0), ("x", 0.5))]
    assert found == [0.0, 0.125, pytest.approx(2.5 / 8), 1.0, None]
    assert Pace().find_share("scan", 0.5) is None and Pace(dict.fromkeys("ab", 1.0)).find_left(0.5, 9.0) is None


def test_the_time_to_go():
    """Broken where a slow job is promised the time of a quick one, or the first instants of a job are believed."""
    assert PACE.find_left(0.0, 0.0) == 80.0 and PACE.find_left(0.5, 20.0) == 40.0
    assert PACE.find_left(0.5, 100.0) == 100.0 and PACE.find_left(0.05, 100.0) == pytest.approx(76.0)


def test_the_whole_never_runs_back():
    """Broken where a stage that is entered again, or an attempt that begins anew, takes the whole back."""
    pacer = ProgressEstimator(PACE)
    shares = [pacer.note(stage, at, "").overall for stage, at in (("drape", 1.0), ("drape", 0.2), ("scan", 0.0))]
    assert shares == [0.5, 0.5, 0.5] and pacer.note("x", 0.1, "").overall is None


def test_a_row_tells_it(database, queue_job):
    """Broken where an attempt that begins anew shows less of the whole, or an ended job still has time to go."""
    job = queue_job()
    held = claim(database, job, "a", 30.0)
    report(database, held, Progress("drape", 0.5, "", 0.4, 60.0))
    report(database, held, Progress("scan", 0.5, "", 0.1, 90.0))
    shown = Job.from_row(find_job(database, job))
    assert (shown.stage, shown.overall) == ("scan", 0.4) and shown.expected_end - shown.started > 80.0
    assert read_events(database, job)[-1].data["left_seconds"] == 90.0
    release(database, held)
    again = Job.from_row(find_job(database, job))
    assert (again.overall, again.expected_end) == (0.4, None)


def test_what_is_learned(database, queue_job):
    """Broken where jobs of another method, kind or ending, or those that were disturbed, count."""
    jobs = [queue_job(f"job{index}") for index in range(6)]
    assert learn_pace(database, "recover", {"settings": {"method": "x"}}, ("a", "b")) == Pace({"a": 1.0, "b": 1.0})
    with database.write() as session:
        for index, job in enumerate(jobs):
            row = session.get(JobRow, job)
            row.request = {**row.request, "settings": {"method": "y" if index == 1 else "x"}}
            row.state, row.attempts, row.kind = State.SUCCEEDED, 1, "recover"
            row.started, row.finished = 1000.0, 1000.0 + 10.0 * (index + 1)
            row.result = {"stage_seconds": {"scan": 1.0, "drape": 2.0 + index}}
        session.get(JobRow, jobs[2]).attempts = 2
        session.get(JobRow, jobs[3]).kind = "person"
        session.get(JobRow, jobs[4]).state = State.FAILED
    found = learn_pace(database, "recover", {"settings": {"method": "x"}}, ("a",))
    assert dict(found.weights) == {"scan": 2.0, "drape": 9.0} and found.seconds == 35.0 and LEARNT_JOBS > 1
    assert list(found.weights) == ["scan", "drape"]


def test_no_estimate_fails_a_job(settings, database, queue_job):
    """Broken where an earlier job's row without a start, or with times that are none, fails every further job."""
    jobs = [queue_job(f"job{index}") for index in range(7)]
    spoilt = (
        {"started": None}, {"finished": None}, {"result": {"stage_seconds": {"scan": "long"}}},
        {"result": {"stage_seconds": [1.0]}}, {"started": 9000.0},
    )  # fmt: skip
    with database.write() as session:
        for job, wrong in zip(jobs, (*spoilt, {}), strict=False):
            row = session.get(JobRow, job)
            row.state, row.attempts = State.SUCCEEDED, 1
            row.started, row.finished = 1000.0, 1010.0
            row.result = {"stage_seconds": {"scan": 4.0}}
            for name, value in wrong.items():
                setattr(row, name, value)
        request = session.get(JobRow, jobs[0]).request
    assert learn_pace(database, "recover", request, ("scan",)) == Pace({"scan": 4.0}, 10.0)
    assert 'garmentq_stage_seconds{stage="scan"} 4.0' in prometheus_text(database)
    assert run_job(settings, database, jobs[-1], lambda: False) == "succeeded"


def test_a_question_that_fails_is_no_estimate(database, queue_job):
    """Broken where a job ends because nothing can be learned of earlier ones."""
    with database.write() as session:
        session.execute(text("alter table jobs rename column started to begun"))
    assert learn_pace(database, "recover", {}, ("a", "b")) == Pace({"a": 1.0, "b": 1.0})


def test_a_fraction_that_is_none(database, queue_job):
    """Broken where a stage that tells nonsense of itself ends the job that it reports for."""
    held = claim(database, queue_job(), "a", 30.0)
    for fraction in (math.nan, math.inf, -1.0, 7.0):
        for pace in (PACE, Pace()):
            report(database, held, ProgressEstimator(pace).note("drape", fraction, ""))
    assert 0.0 <= find_job(database, held.job).progress <= 1.0
