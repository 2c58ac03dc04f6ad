"""Lists of jobs are read by index whoever owns them, and files are deleted by name, however long the tables are."""

from __future__ import annotations

import pytest
from garmentq.service.database import Database
from garmentq.service.deletion import delete_jobs
from garmentq.service.families import JobNotEnded
from garmentq.service.jobs import JobUnknown
from garmentq.service.keys import create_key
from garmentq.service.models import LISTED_FIELDS, JobFileRow, JobInputRow, JobRow, MetricRow, OwnerRow, ScanRow
from garmentq.service.query import NUMBERS, TEXTS, QueryBad, find_jobs, parse_conditions
from garmentq.service.states import State
from sqlalchemy import event, insert, select, text

COUNT = 3000
"""More jobs than are named one by one."""


@pytest.fixture
def key(database: Database) -> str:
    """Return the key of many jobs, every tenth failed."""
    made = create_key(database, "studio", scopes=("read",))[0].id
    with database.write() as session:
        session.execute(insert(ScanRow), [{"sha256": "0" * 64, "name": "s", "size": 1, "created": 0.0, "details": {}}])
        session.execute(insert(JobRow), [describe(number) for number in range(COUNT)])
        session.execute(insert(OwnerRow), [{"key": made, "job": f"{n:012x}"} for n in range(COUNT)])
    return made


def describe(number: int) -> dict[str, object]:
    """Return the values of one job's row."""
    is_failed = number % 10 == 0
    return {
        "id": f"{number:012x}", "dedup": f"{number:064x}", "scan": "0" * 64, "name": f"n{number % 7}",
        "request": {}, "version": "1", "state": State.FAILED if is_failed else State.SUCCEEDED,
        "error_code": "x.y" if is_failed else None, "touched": 0.0, "created": float(number),
        "method": None if number % 3 == 0 else ("deform", "hybrid")[number % 2],
        "cpu_seconds": None if number < 2900 else float(number % 13),
    }  # fmt: skip


@pytest.mark.parametrize("sort", ["-created", "name", "-name", "method", "-method", "-cpu_seconds", "cpu_seconds"])
@pytest.mark.parametrize("offset", [0, 90, 250, 2950])
def test_pages_have_one_order(database: Database, key: str, sort: str, offset: int) -> None:
    """Breaks where a page repeats or leaves out jobs, or those without the column are not last, the newest first."""
    name, falls = sort.removeprefix("-"), sort.startswith("-")
    rows = [describe(number) for number in range(COUNT)]
    known = [row for row in rows if row[name] is not None]
    known.sort(key=lambda row: (row[name], row["created"]), reverse=falls)
    rest = sorted((row for row in rows if row[name] is None), key=lambda row: -float(str(row["created"])))
    wanted = [row["id"] for row in known + rest][offset : offset + 60]
    assert [row.id for row in find_jobs(database, (), sort, (60, offset), key)] == wanted


@pytest.mark.parametrize(
    ("where", "count"),
    [("state = failed", 300), ("error = x.y and name = n0", 43), ("method = deform", 1000), ("cpu_seconds >= 12", 7)],
)
def test_rare_and_common_conditions_count_alike(database: Database, key: str, where: str, count: int) -> None:
    """Breaks where a condition that few or many jobs meet leaves out some, or another key sees them."""
    found = find_jobs(database, parse_conditions(where), limit=5000, owner=key)
    assert len(found) == count == len({row.id for row in found})
    assert find_jobs(database, parse_conditions(where), limit=50, owner="nobody") == []


@pytest.mark.parametrize("database_kind", ["sqlite"], indirect=True)
@pytest.mark.parametrize("sort", ["-created", "-method", "name", "-cpu_seconds", "state"])
def test_no_list_is_sorted_by_the_database(database: Database, key: str, sort: str) -> None:
    """Breaks where the jobs of a key are all read and sorted in order to show the first."""
    asked: list[tuple[str, object]] = []
    engine = database.engine

    def note(_connection: object, _cursor: object, sql: str, values: object, *_: object) -> None:
        asked.append((sql, values))

    event.listen(engine, "before_cursor_execute", note)
    find_jobs(database, (), sort, 50, key)
    event.remove(engine, "before_cursor_execute", note)
    with database.read() as session:
        plans = []
        for sql, values in asked:
            if "FROM jobs" in sql and "ORDER BY" in sql:
                rows = session.connection().exec_driver_sql(f"EXPLAIN QUERY PLAN {sql}", values).all()
                plans.append(" ".join(str(row[-1]) for row in rows))
    assert plans and not [plan for plan in plans[:1] if "TEMP B-TREE FOR ORDER BY" in plan], plans


def test_every_field_of_lists_has_an_index() -> None:
    """Breaks where jobs can be sorted by a column that has no index."""
    keys = {field.key for field in (*TEXTS.values(), *NUMBERS.values())}
    assert keys - set(LISTED_FIELDS) == {"id", "family", "parent", "created"}


def test_a_job_lists_its_request(database: Database, queue_job) -> None:
    """Breaks where a job's own columns do not say what its request says, or its files are not named."""
    job = queue_job()
    with database.read() as session:
        row = session.get_one(JobRow, job)
        assert row.method == row.request["settings"]["method"]
        named = set(session.scalars(select(JobFileRow.sha256).where(JobFileRow.job == job)))
        assert row.scan in named
        assert session.scalar(text("select count(*) from jobs")) == 1


def test_a_misspelt_field_names_the_nearest(database: Database, key: str) -> None:
    """Breaks where a typing error is answered by a list of all fields alone."""
    with database.write() as session:
        session.execute(insert(MetricRow), [{"job": f"{1:012x}", "name": "hausdorff_mm", "value": 1.0}])
    with pytest.raises(QueryBad, match="there is no 'garmet'; did you mean garment"):
        find_jobs(database, (), "garmet", 50, key)


def test_families_are_deleted_at_once_or_not_at_all(database: Database, store, queue_job) -> None:
    """Breaks where one of many that still runs lets the others go, or a job that reads another of them stops all."""
    jobs = [queue_job(f"n{number}") for number in range(4)]
    with pytest.raises(JobNotEnded):
        delete_jobs(database, store, jobs)
    with database.write() as session:
        session.execute(text("update jobs set state = 'succeeded'"))
        session.add(JobInputRow(job=jobs[1], name="result", input=jobs[0]))
    assert set(delete_jobs(database, store, jobs[:3]).jobs) == set(jobs[:3])
    assert [row.id for row in find_jobs(database)] == [jobs[3]]
    with pytest.raises(JobUnknown):
        delete_jobs(database, store, [jobs[3], jobs[0]])
    assert [row.id for row in find_jobs(database)] == [jobs[3]]
