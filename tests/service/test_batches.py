"""The jobs of a tag are counted as they are, for whoever owns them, and a batch without jobs is none."""

from __future__ import annotations

import pytest
from garmentq.service.batches import BatchUnknown, find_batch, list_batches
from garmentq.service.deletion import delete_jobs
from garmentq.service.families import cancel, make_children
from garmentq.service.jobs import claim, fail, find_job
from garmentq.service.keys import create_key
from garmentq.service.kinds.kind import ChildRequest
from garmentq.service.models import BatchRow, JobRow
from garmentq.service.pace import find_mean_seconds
from garmentq.service.reaper import record_heartbeat
from garmentq.service.renaming import rename_family
from garmentq.service.states import State
from sqlalchemy import event, update


def put(database, job: str, **values) -> None:
    """Write columns of a job."""
    with database.write() as session:
        session.execute(update(JobRow).where(JobRow.id == job).values(**values))


def end(database, job: str, seconds: float, **values) -> None:
    """Let a job have succeeded after some seconds."""
    put(database, job, state=State.SUCCEEDED, started=100.0, finished=100.0 + seconds, **values)


def test_a_batch_is_counted(database, queue_job):
    """Broken where a state, a child or a verdict is not counted, or a failure comes without its reason."""
    jobs = [queue_job(f"s{n}", tags=("march",)) for n in range(5)]
    queue_job("other", tags=("april",))
    end(database, jobs[0], 10.0, verdict="pass", garment="skirt", cpu_seconds=7.0)
    with database.write() as session:
        (child,) = make_children(session, jobs[0], [ChildRequest("upper", "recover", {})]).values()
    end(database, child, 10.0, verdict="doubtful", garment="skirt", cpu_seconds=0.5)
    fail(database, claim(database, jobs[1], "a", 30.0), "scan.empty", "The scan has no points.", bad_input=True)
    cancel(database, jobs[2])
    assert claim(database, jobs[3], "a", 30.0)
    put(database, jobs[3], overall=0.5)
    found = find_batch(database, "march")
    assert (found.jobs, found.scans, found.open_jobs) == (6, 5, 2)
    assert found.states == {"succeeded": 2, "failed": 1, "cancelled": 1, "running": 1, "queued": 1}
    assert found.share == pytest.approx(4.5 / 6.0, abs=1e-4)
    assert (found.verdicts, found.garments, found.cpu_seconds) == ({"doubtful": 1, "pass": 1}, {"skirt": 2}, 7.5)
    assert [(one.job, one.error.code, one.error.message) for one in found.failures] == [
        (jobs[1], "scan.empty", "The scan has no points.")
    ]
    with pytest.raises(BatchUnknown):
        find_batch(database, "may")


def test_the_time_to_go(database, queue_job):
    """Broken where the estimate forgets running jobs, the number of workers, or the garments that persons will have."""
    jobs = [queue_job(f"s{n}", tags=("march",)) for n in range(6)]
    for job, seconds in zip(jobs, (10.0, 30.0), strict=False):
        end(database, job, seconds)
    with database.read() as session:
        assert find_mean_seconds(session, "recover") == pytest.approx(20.0)
        assert find_mean_seconds(session, "person") is None
    assert find_batch(database, "march").left_seconds is None, "no worker"
    record_heartbeat(database, "w", "cpu", 2, 30.0)
    assert find_batch(database, "march").left_seconds == pytest.approx(4 * 20.0 / 2)
    assert claim(database, jobs[2], "a", 300.0)
    with database.read() as session:
        from garmentq.service.database import clock
        from sqlalchemy import select

        now = session.scalar(select(clock()))
    put(database, jobs[2], expected_end=now + 8.0)
    assert find_batch(database, "march").left_seconds == pytest.approx((3 * 20.0 + 8.0) / 2, abs=1.0)
    end(database, jobs[2], 20.0, expected_end=None)
    put(database, jobs[3], kind="person")
    assert find_batch(database, "march").left_seconds is None, "no person has ended yet"
    put(database, jobs[0], kind="person")
    with database.write() as session:
        children = make_children(session, jobs[0], [ChildRequest(name, "recover", {}) for name in "ab"])
    for child in children.values():
        end(database, child, 25.0)
    expected = 10.0 + (2 + 2) * 25.0  # one person with two garments, and two garments
    assert find_batch(database, "march").left_seconds == pytest.approx(expected / 2)
    for job in jobs[3:]:
        cancel(database, job)
    assert find_batch(database, "march").left_seconds == 0.0


def test_batches_are_paged_newest_first(database, queue_job):
    """Broken where a page repeats or leaves out a tag, a tag without jobs stays, or a renamed family is in none."""
    jobs = [queue_job(f"s{n}", tags=(f"t{n}", "all")) for n in range(5)]
    with database.write() as session:
        for number in range(5):
            session.get_one(BatchRow, ("", f"t{number}")).latest = 5.0 if number in (1, 2) else float(number)
        session.get_one(BatchRow, ("", "all")).latest = 9.0
    found: list[str] = []
    while page := list_batches(database, 2, found[-1] if found else ""):
        found += [one.tag for one in page]
    assert found == ["all", "t2", "t1", "t4", "t3", "t0"]
    queue_job("s0", tags=("t0",), force=True)
    assert list_batches(database, 1)[0].tag == "t0"
    for job in jobs:
        cancel(database, job)
    rename_family(database, jobs[1], tags=["new", "t2"])
    assert [one.tag for one in list_batches(database)][:2] in (["new", "t2"], ["t2", "new"])
    assert "t1" not in {one.tag for one in list_batches(database)}


def test_a_deleted_batch_is_gone(database, store, queue_job):
    """Broken where a tag stays in the list when its last job is deleted."""
    first, second = queue_job("a", tags=("x", "y")), queue_job("b", tags=("y",))
    for job in (first, second):
        cancel(database, job)
    delete_jobs(database, store, [first])
    assert [(one.tag, one.jobs) for one in list_batches(database)] == [("y", 1)]


def test_a_key_counts_its_own_jobs(database, queue_job):
    """Broken where a key sees the tag or the jobs of another, or an administrator counts a job of two keys twice."""
    mine, other = (create_key(database, name, ("read",))[0].id for name in ("a", "b"))
    shared = queue_job("s", key=mine, quota=9, tags=("both",))
    assert queue_job("s", key=other, quota=9) == shared
    queue_job("t", key=other, quota=9, tags=("both", "theirs"))
    assert {one.tag: one.jobs for one in list_batches(database, owner=mine)} == {"both": 1}
    assert {one.tag: one.jobs for one in list_batches(database, owner=other)} == {"both": 2, "theirs": 1}
    assert {one.tag: one.jobs for one in list_batches(database)} == {"both": 2, "theirs": 1}
    with pytest.raises(BatchUnknown):
        find_batch(database, "theirs", mine)
    assert find_job(database, shared)


@pytest.mark.parametrize("database_kind", ["sqlite"], indirect=True)
def test_no_table_is_read_whole(database, queue_job):
    """Broken where the page of batches, a batch or a subject's report reads all jobs, however few it shows."""
    from garmentq.service.subjects import find_subject, list_subjects

    queue_job("a", tags=("x",), subject="Anna")
    asked: list[tuple[str, object]] = []

    def note(_connection: object, _cursor: object, sql: str, values: object, *_: object) -> None:
        asked.append((sql, values))

    event.listen(database.engine, "before_cursor_execute", note)
    for ask in (lambda: list_batches(database, owner="k"), lambda: find_batch(database, "x"),
                lambda: find_subject(database, "Anna"), lambda: list_subjects(database, key="")):  # fmt: skip
        ask()
    event.remove(database.engine, "before_cursor_execute", note)
    with database.read() as session:
        for sql, values in asked:
            if sql.startswith("SELECT"):
                rows = session.connection().exec_driver_sql(f"EXPLAIN QUERY PLAN {sql}", values).all()
                plan = " | ".join(str(row[-1]) for row in rows)
                for table in ("jobs", "job_tags", "subject_jobs", "metrics", "bodies", "scans", "subjects"):
                    assert f"SCAN {table} " not in f"{plan} ", (sql, plan)
