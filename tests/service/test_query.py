"""Questions to the results: right answers, and no way to say SQL."""

from __future__ import annotations

import base64
import json
import shutil
from dataclasses import replace

import pytest
from garmentq.core.cloth.fabric import FabricEstimate
from garmentq.core.judge.estimates import summarise_estimates
from garmentq.core.recover.settings import RecoverySettings
from garmentq.service.cursors import Cursor, CursorBad, decode_cursor
from garmentq.service.database import open_database
from garmentq.service.job_pages import find_page
from garmentq.service.jobs import claim
from garmentq.service.kinds.recover import Recover
from garmentq.service.query import Condition, JobQuery, QueryBad, find_jobs, list_jobs, parse_conditions
from garmentq.service.results import (
    ResultMissing,
    export_files,
    list_files,
    report_jobs,
    store_result,
)
from garmentq.service.settings import ServiceSettings
from garmentq.service.store import Store
from garmentq.service.submission import Order, submit
from garmentq_home import drop_database, make_database, make_settings, put_file
from garmentq_standin import make_recovery, write
from hypothesis import given
from hypothesis import strategies as st
from sqlalchemy import text

KNOWN = {
    "skirt1": (FabricEstimate("k", 2e-5, 0.3, 1.9, True, "found"),),
    "skirt3": (FabricEstimate("k", 4e-5, 1.2, 1.9, False, "left open"),),
}
"""What the fit found of two skirts' cloth."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory, blank_database, database_kind):
    """Return one home to all these tests: none of them changes anything."""
    home = tmp_path_factory.mktemp("results")
    shutil.copy(blank_database, home / "garmentq.db")
    return home


@pytest.fixture(scope="module")
def database(folder, database_kind, request):
    """Open the home's database, on each kind of server."""
    address = "" if database_kind == "sqlite" else make_database(request.getfixturevalue("postgres"))
    opened = open_database(make_settings(folder, database_url=address))
    yield opened
    opened.dispose()
    if address:
        drop_database(address)


@pytest.fixture(scope="module")
def store(folder):
    """Open the home's store."""
    return Store(folder / "store")


@pytest.fixture(scope="module")
def results(database, store, folder):
    """Store skirts with t2s 1, 2, 3 mm and shirts with 2, 4 mm; give their ids by name. One more job is only queued."""
    ids = {}
    for name, rms in (("skirt1", 1.0), ("skirt2", 2.0), ("skirt3", 3.0), ("shirt2", 2.0), ("shirt4", 4.0)):
        settings = RecoverySettings(method="deform")
        order = Order(put_file(folder, f"{name}.ply"), put_file(folder, "body.ply"), settings=settings)
        ids[name] = submit(database, store, order).job
        held = claim(database, ids[name], "a", 30.0)
        files = folder / name
        files.mkdir()
        recovery = make_recovery(order, rms)
        metrics = recovery.report.metrics | summarise_estimates(KNOWN.get(name, ()))
        recovery = replace(recovery, report=replace(recovery.report, metrics=metrics))
        write(recovery, files)
        store_result(database, store, held, Recover(), recovery, files)
    submit(database, store, Order(put_file(folder, "queued.ply"), folder / "body.ply"))
    return ids


def names(rows):
    """Return the scans' names."""
    return [row.name for row in rows]


@pytest.mark.parametrize(
    ("where", "expected"),
    [
        ("surface_rms_mm.t2s < 2", {"skirt1"}),
        ("surface_rms_mm.t2s <= 2", {"skirt1", "skirt2", "shirt2"}),
        ("surface_rms_mm.t2s>2", {"skirt3", "shirt4"}),
        ("fabric.k > 1e-6", {"skirt1"}),
        ("fabric.k.identifiable = 0", {"skirt3"}),
        ("fabric.k.std < 0.5 and fabric.k.identifiable = 1", {"skirt1"}),
        ("surface_rms_mm.t2s >= 3.0", {"skirt3", "shirt4"}),
        ("surface_rms_mm.t2s = 2", {"skirt2", "shirt2"}),
        ("surface_rms_mm.t2s == 2e0", {"skirt2", "shirt2"}),
        ("surface_rms_mm.t2s != 2", {"skirt1", "skirt3", "shirt4"}),
        ("garment = skirt and surface_rms_mm.t2s < 3 and surface_rms_mm.s2t > 0.5", {"skirt2"}),
        ("name = 'shirt4'", {"shirt4"}),
        ("method = deform and garment != skirt", {"shirt2", "shirt4"}),
        ("cpu_seconds < 1", {"skirt1", "skirt2", "skirt3", "shirt2", "shirt4"}),
        ("state = queued", {"queued"}),
        ("panel_area_error < 1", set()),
        ("body = mesh:standin and fabric = cotton_poplin and attempts = 1 and surface_rms_mm.t2s > 3", {"shirt4"}),
    ],
)
def test_operators(database, results, where, expected):
    """Broken where an operator, a join or a null is treated wrongly."""
    assert set(names(find_jobs(database, parse_conditions(where)))) == expected


def test_sort_and_limit(database, results):
    """Broken where a job without the metric comes first, or the limit cuts before the sort."""
    skirts = [Condition("garment", "=", "skirt")]
    assert names(find_jobs(database, skirts, sort="-surface_rms_mm.t2s", limit=2)) == ["skirt3", "skirt2"]
    assert names(find_jobs(database, skirts, sort="surface_rms_mm.t2s")) == ["skirt1", "skirt2", "skirt3"]
    assert names(find_jobs(database, sort="surface_rms_mm.t2s"))[-1] == "queued"
    assert names(find_jobs(database, sort="-surface_rms_mm.t2s"))[-1] == "queued"
    assert names(find_jobs(database, sort="-created"))[0] == "queued"


@pytest.mark.parametrize(
    "where",
    [
        "1=1; drop table jobs",
        "surface_rms_mm.t2s < 4; drop table jobs --",
        "surface_rms_mm.t2s < 4 or 1=1",
        "surface_rms_mm.t2s < (select 1)",
        "jobs.id = x",
        "x' or '1'='1 < 2",
        "surface_rms_mm.t2s",
        "< 4",
        "",
        "name = 'a' union select sql from sqlite_master",
        "surface_rms_mm.t2s <> 4",
        "surface_rms_mm.t2s like 4",
        "surface_rms_mm.t2s < 4 and",
        "surface_rms_mm.t2s < four",
        "no_such_metric < 4",
        "name < a",
        "ｎame = a",
        "owner = a",
    ],
)
def test_hostile_or_wrong_text_is_refused(database, results, where):
    """Broken where anything but NAME OPERATOR VALUE gets through."""
    with pytest.raises(QueryBad):
        find_jobs(database, parse_conditions(where))
    assert len(list_jobs(database)) == 6


@pytest.mark.parametrize("value", ["x' or '1'='1", "%", "_", "skirt1'; drop table jobs; --", ":name", "?"])
def test_values_are_bound(database, results, value):
    """Broken where a value became part of the statement, or a pattern."""
    assert find_jobs(database, [Condition("name", "=", value)]) == []
    with database.read() as session:
        assert session.execute(text("select count(*) from jobs")).scalar() == 6


@pytest.mark.parametrize("sort", ["id; drop table jobs", "-", "", "jobs.created", "random()", "1"])
def test_a_sort_is_a_name(database, results, sort):
    """Broken where an order by could be typed."""
    with pytest.raises(QueryBad):
        find_jobs(database, sort=sort)


def test_limit_has_a_range(database, results):
    """Broken where a negative limit meant all."""
    for limit in (0, -1, 10**9):
        with pytest.raises(QueryBad):
            find_jobs(database, limit=limit)


def test_a_metric_on_an_empty_database_is_no_error(tmp_path, blank_database):
    """Broken where the first question on a fresh home fails."""
    shutil.copy(blank_database, tmp_path / "garmentq.db")
    database = open_database(make_settings(tmp_path), pooled=False)
    assert find_jobs(database, parse_conditions("surface_rms_mm.t2s < 4")) == []
    for bad in ("x;y", "1", "a b"):
        with pytest.raises(QueryBad):
            find_jobs(database, sort=bad)


def test_a_stored_result_comes_back(database, store, results, tmp_path):
    """Broken where a row of the result is missing or belongs to another job."""
    job = results["skirt2"]
    row = next(row for row in list_jobs(database) if row.id == job)
    (found,) = report_jobs(database, [row], ServiceSettings())
    assert found.state == "succeeded" and found.garment == "skirt" and found.fabric == "cotton_poplin"
    assert found.metrics == {"surface_rms_mm.t2s": 2.0, "surface_rms_mm.s2t": 1.0, "panel_area_error": None}
    assert found.gates[0].verdict == "pass" and found.warnings == ["this is a stand-in"]
    with database.read() as session:
        panel = session.execute(text("select name, area from panels where job = :job"), {"job": job}).one()
        assert panel.name == "front" and abs(panel.area - 0.01) < 1e-12
        assert session.execute(text("select count(*) from materials")).scalar() == 1, "one fabric, one row"
        assert session.execute(text("select count(*) from bodies")).scalar() == 5
    (path,) = export_files(database, store, job, tmp_path / "out")
    assert "2.0" in path.read_text()
    assert [file.name for file in list_files(database, job)] == ["metrics.txt"]
    with pytest.raises(ResultMissing, match=r"metrics\.txt"):
        export_files(database, store, job, tmp_path / "out", ["../../x"])
    with pytest.raises(ResultMissing):
        export_files(database, store, "nosuchjob", tmp_path / "out")


def test_a_verdict_is_a_question(database, results):
    """Broken where a good result cannot be told from a bad one by a query, or a job without a result counts as good."""
    assert {row.id for row in find_jobs(database, parse_conditions("verdict = pass"))} == set(results.values())
    assert find_jobs(database, parse_conditions("verdict = fail")) == []
    assert {row.verdict for row in find_jobs(database, parse_conditions("state = queued"))} == {None}


SORTS = ("-created", "created", "name", "-name", "job", "state", "verdict", "-attempts", "finished",
         "surface_rms_mm.t2s", "-surface_rms_mm.t2s")  # fmt: skip


@pytest.mark.parametrize("sort", SORTS)
@pytest.mark.parametrize("limit", [1, 2, 4])
def test_pages_are_the_list(database, results, sort, limit):
    """Broken where a page repeats or leaves out a job at equal values, or at the first job without a value."""
    query, found = JobQuery(sort=sort, limit=limit), []
    while query is not None:
        page = find_page(database, query)
        assert page.total == 6 and len(page.rows) == min(limit, 6 - len(found))
        found += page.rows
        query = replace(query, cursor=page.next) if page.next else None
    assert [row.id for row in found] == [row.id for row in find_jobs(database, sort=sort)]


def test_a_new_job_shifts_no_page(tmp_path, blank_database):
    """Broken where the second page begins at a number of jobs, not after the last one of the first."""
    shutil.copy(blank_database, tmp_path / "garmentq.db")
    database, store = open_database(make_settings(tmp_path), pooled=False), Store(tmp_path / "store")
    add = lambda name: submit(database, store, Order(put_file(tmp_path, f"{name}.ply"), put_file(tmp_path, "b.ply")))  # noqa: E731
    for name in "abcd":
        add(name)
    first = find_page(database, JobQuery(limit=2))
    add("e")
    second = find_page(database, JobQuery(limit=2, cursor=first.next))
    assert (names(first.rows), names(second.rows)) == (["d", "c"], ["b", "a"])
    assert (first.total, second.total, second.next) == (4, 5, None)
    offset = find_page(database, JobQuery(limit=2, offset=2))
    assert names(offset.rows) == ["c", "b"]


def test_the_total_is_that_of_the_conditions(database, results, monkeypatch):
    """Broken where the total counts the page, other jobs, or goes on counting in a long table."""
    query = JobQuery({"garment": "skirt"}, limit=1)
    assert find_page(database, query).total == 3
    monkeypatch.setattr("garmentq.service.job_pages.MAX_TOTAL_COUNT", 2)
    assert find_page(database, query).total is None and find_page(database, JobQuery()).total == 6


def encode(*values) -> str:
    """Return what a cursor of these values would be."""
    return base64.urlsafe_b64encode(json.dumps(values).encode()).decode().rstrip("=")


@pytest.mark.parametrize(
    ("sort", "cursor"),
    [
        ("-created", ""), ("-created", "x"), ("-created", "é" * 9), ("-created", "A" * 2000), ("-created", encode(1)),
        ("-created", encode("created", 1.0, 1.0, "a")), ("-created", encode("-created", "1", 1.0, "a")),
        ("-created", encode("-created", float("nan"), 1.0, "a")), ("-created", encode("-created", 1.0, True, "a")),
        ("-attempts", encode("-attempts", 10**400, 1.0, "a")), ("-attempts", encode("-attempts", 10**12, 1.0, "a")),
        ("-attempts", encode("-attempts", 1.5, 1.0, "a")),
        ("name", encode("name", 1.0, 1.0, "a")), ("name", encode("name", "a\x00", 1.0, "a")),
        ("name", encode("name", ["a"], 1.0, "a")), ("state", encode("state", "asleep", 1.0, "a")),
        ("surface_rms_mm.t2s", encode("surface_rms_mm.t2s", "4", 1.0, "a")), ("-created", encode(*["["] * 200)),
    ],
)  # fmt: skip
def test_a_wrong_cursor_is_refused(database, results, sort, cursor):
    """Broken where a cursor of another list gives a page of this one, or reaches the database as it is."""
    with pytest.raises(CursorBad):
        find_page(database, JobQuery(sort=sort, cursor=cursor))


def test_a_page_has_one_beginning(database, results):
    """Broken where an offset beside a cursor is quietly dropped."""
    page = find_page(database, JobQuery(limit=1))
    with pytest.raises(QueryBad):
        find_page(database, JobQuery(limit=1, offset=1, cursor=page.next))


@given(
    value=st.none() | st.text(max_size=255) | st.floats(allow_nan=False, allow_infinity=False),
    created=st.floats(0, 4e9),
)
def test_a_cursor_comes_back(value, created):
    """Broken where a name in another script, or the last digit of a time, is lost on the way."""
    cursor = Cursor("-name", value, created, "3685ecfd4f81")
    if isinstance(value, str) and not value.isprintable():
        with pytest.raises(CursorBad):
            decode_cursor(cursor.encode(), "-name")
    else:
        assert decode_cursor(cursor.encode(), "-name") == cursor
