"""A row that cannot be read is named, and everything else goes on."""

from __future__ import annotations

import json

import pytest
from garmentq.service.backup import make_backup, restore_backup
from garmentq.service.columns import Checked, RowDamaged
from garmentq.service.database import DatabaseDamaged, open_database
from garmentq.service.garbage import collect_garbage
from garmentq.service.health import read_queue
from garmentq.service.jobs import claim, fail, find_job
from garmentq.service.metrics import prometheus_text
from garmentq.service.models import Base, JobRow
from garmentq.service.query import Condition, count_states, find_jobs, list_jobs
from garmentq.service.reaper import reap, republish_stalled_jobs
from garmentq.service.results import report_jobs
from garmentq.service.states import State
from garmentq.service.verify import verify_store
from garmentq.service.webhooks import create_webhook
from garmentq.workers.recovery import run_job
from garmentq_home import make_settings
from sqlalchemy import text

TIED = ("id", "scan", "parent", "dedup")
"""Columns with a constraint that refuses the tests' values."""

JOBS = [column.name for column in JobRow.__table__.columns if column.name not in TIED]


@pytest.fixture
def spoil(database):
    """Return a function that writes what no program of ours writes; `value` is SQL."""

    def write(column: str, value: str, job: str, table: str = "jobs", key: str = "id") -> None:
        with database.write() as session:
            session.execute(text(f"update {table} set {column} = {value} where {key} = :job"), {"job": job})

    return write


@pytest.fixture
def reopen(settings):
    """Return a function that opens the database anew, as a process does that has met no damage yet."""
    opened = []

    def open_again(of=settings):
        opened.append(open_database(of))
        return opened[-1]

    yield open_again
    for one in opened:
        one.dispose()


@pytest.fixture
def two(database_kind, queue_job, spoil):
    """Return a job with a damaged row, one whose state is none, and a sound one."""
    cut, sleeping, sound = queue_job("cut"), queue_job("sleeping"), queue_job("sound")
    spoil("request", "substr(request, 1, 40)" if database_kind == "sqlite" else "'[]'", cut)
    spoil("state", "'sleeping'", sleeping)
    return cut, sleeping, sound


def test_one_row_is_named(database, two):
    """Broken where a damaged row is a traceback, or nobody is told which one it is."""
    cut, sleeping, sound = two
    for job, column in ((cut, "request"), (sleeping, "state")):
        with pytest.raises(RowDamaged, match=rf"jobs '{job}' \({column}\).*garmentq verify") as told:
            find_job(database, job)
        assert told.value.code == "service.row_damaged"
    assert find_job(database, sound).name == "sound"
    assert {(one.table, one.key, one.columns) for one in database.find_damaged()} == {
        ("jobs", cut, ("request",)), ("jobs", sleeping, ("state",)),
    }  # fmt: skip


def test_lists_go_on(database, settings, two, reopen, caplog):
    """Broken where one damaged row empties every list, or is left out without a word."""
    cut, sleeping, sound = two
    assert [row.id for row in list_jobs(database)] == [sound]
    assert cut in caplog.text and sleeping in caplog.text and "service.row_damaged" in caplog.text
    assert [row.id for row in find_jobs(reopen())] == [sound]
    for name, value in (("method", "x"), ("preset", "x"), ("cpu_seconds", 1.0), ("garment", "x"), ("tag", "x")):
        assert find_jobs(reopen(), [Condition(name, "=", value)]) == []
    assert count_states(reopen()) == {State.QUEUED: 1}
    assert read_queue(reopen()).states == {State.QUEUED: 1}
    assert 'garmentq_jobs{state="queued",queue="cpu"} 1.0' in prometheus_text(reopen())
    assert [one.id for one in report_jobs(database, list_jobs(database), settings)] == [sound]


@pytest.mark.parametrize("database_kind", ["sqlite"], indirect=True)
def test_every_command_says_it(settings, two, cli, tmp_path):
    """Broken where a command ends in a traceback, or with a status that says that all is well."""
    cut, sleeping, sound = two
    for words in (("status",), ("query",), ("query", "--where", "method = deform")):
        told = cli(*words)
        assert told.returncode == 0 and cut not in told.stdout, told
    assert sound in cli("status").stdout
    told = cli("status", cut)
    assert told.returncode == 9 and "error service.row_damaged: " in told.stderr and cut in told.stderr, told
    told = cli("verify")
    assert told.returncode == 11 and cut in told.stdout and sleeping in told.stdout, told
    rows = [json.loads(line) for line in cli("verify", "--json").stdout.splitlines()]
    assert {(one["table"], one["key"], *one["columns"]) for one in rows} == {
        ("jobs", cut, "request"), ("jobs", sleeping, "state"),
    }  # fmt: skip
    told = cli("gc", "--delete", "--grace-hours", "0", "--json")
    assert (told.returncode, json.loads(told.stdout)["removed"]) == (11, 0)
    found = [json.loads(line) for line in cli("doctor", "--json").stdout.splitlines()]
    [line] = [one for one in found if one["check"] == "rows"]
    assert not line["ok"] and cut in line["message"] and sleeping in line["message"]


@pytest.mark.parametrize("database_kind", ["sqlite"], indirect=True)
def test_a_backup_keeps_a_damaged_row(settings, store, two, cli, tmp_path, reopen):
    """Broken where a damaged row stops every backup, is lost in it, or the files that its rest names are not in it."""
    told = cli("backup", tmp_path / "a.tar")
    assert told.returncode == 11 and two[0] in told.stderr and "are missing" not in told.stderr, told
    other = make_settings(tmp_path / "other")
    restored = restore_backup(other, tmp_path / "a.tar")
    assert {one.key for one in restored.rows} == set(two[:2]) and restored.missing == ()
    assert {one.key for one in reopen(other).find_damaged()} == set(two[:2])
    assert restored.files == len(list(store.list_files()))
    assert make_backup(settings, tmp_path / "b.tar").rows == restored.rows


def test_gc_spares_what_a_damaged_row_may_name(database, store, two):
    """Broken where the file of a job whose request is cut is taken for garbage."""
    kept = {one.sha256 for one in store.list_files()}
    store.put_bytes(b"named by nobody")
    found = collect_garbage(database, store, -60.0, is_delete=True)
    assert found.removed == 0 and len(found.damaged) == 2 and len(found.files) <= 3
    assert {one.sha256 for one in store.list_files()} > kept
    assert {row.key for row in verify_store(database, store, True).rows} == set(two[:2])


def test_a_worker_takes_the_next_job(settings, database, store, two, reopen):
    """Broken where a damaged row stands before every other job for ever, or ends the process that meets it."""
    cut, sleeping, sound = two
    with database.write() as session:
        session.execute(text("update jobs set priority = 9 where id != :job"), {"job": sound})
    assert run_job(settings, reopen(), cut, lambda: False) == "unclaimed"
    assert run_job(settings, reopen(), sound, lambda: False) == "succeeded"
    assert run_job(settings, reopen(), sleeping, lambda: False) == "unclaimed"


def test_the_dispatcher_goes_on(database, queue_job, spoil):
    """Broken where the lease of one damaged row keeps those of all dead workers from ending."""
    damaged, sound = queue_job("damaged"), queue_job("sound")
    for job in (damaged, sound):
        claim(database, job, "dead", -1.0)
    spoil("request", "'[1]'", damaged)
    assert reap(database, 3) == 1 and find_job(database, sound).state == State.QUEUED
    assert republish_stalled_jobs(database, -60.0, lambda: True) >= 0


def test_a_damaged_webhook_ends_no_job(database, queue_job, spoil):
    """Broken where no job can end any more because of an address that cannot be told of it."""
    hook, _ = create_webhook(database, "https://studio.example/", (), "")
    spoil("states", "'{}'", hook.id, "webhooks")
    held = claim(database, queue_job(), "a", 30.0)
    fail(database, held, "x.y", "z", bad_input=False)
    assert find_job(database, held.job).state == State.FAILED


@pytest.mark.parametrize("database_kind", ["sqlite"], indirect=True)
def test_each_column_of_a_job(database, queue_job, spoil):
    """Broken where a column holds what Python cannot read, and the row is neither named nor left out."""
    job, sound = queue_job("damaged"), queue_job("sound")
    for column in JOBS:
        spoil(column, "x'ff'", job)
        assert [one.columns for one in database.find_damaged()] == [(column,)]
        assert [row.id for row in list_jobs(database)] == [sound]
        with pytest.raises(RowDamaged, match=job):
            find_job(database, job)
        spoil(column, f"(select {column} from jobs where id = '{sound}')", job)


@pytest.mark.parametrize("database_kind", ["sqlite"], indirect=True)
def test_a_text_that_is_none(database, queue_job, spoil):
    """Broken where a flipped bit in a name is told as a database that does not answer."""
    job, sound = queue_job("damaged"), queue_job("sound")
    spoil("name", "cast(x'61ff62' as text)", job)
    with pytest.raises(RowDamaged, match=rf"jobs '{job}' \(name\)"):
        find_job(database, job)
    assert [row.id for row in list_jobs(database)] == [sound]


@pytest.mark.parametrize("database_kind", ["sqlite"], indirect=True)
@pytest.mark.parametrize("wrong", [b"CREATE TABLE j\xeabs", b"CREATE TABLE jobz"])
def test_a_damaged_definition(settings, database, queue_job, reopen, wrong):
    """Broken where a flipped bit in a table's definition is a traceback, or a database that does not answer."""
    queue_job()
    database.dispose()
    path = settings.home / "garmentq.db"
    content = path.read_bytes()
    assert content.count(b"CREATE TABLE jobs") == 1
    path.write_bytes(content.replace(b"CREATE TABLE jobs", wrong))
    with pytest.raises(DatabaseDamaged, match=r"is damaged.*garmentq restore"):
        list_jobs(reopen())


@pytest.mark.parametrize("database_kind", ["sqlite"], indirect=True)
def test_every_column_is_checked(database):
    """Broken where a new column reads without a look; a number that SQLite grows itself needs none."""
    unchecked = {str(c) for t in Base.metadata.sorted_tables for c in t.columns if not isinstance(c.type, Checked)}
    assert unchecked == {"events.id", "outbox.id", "audit.id"} and database.find_damaged() == []
