"""A home of an older version: its tables are brought up to date, and its jobs run, resume and show."""

from __future__ import annotations

import base64
import json
from pathlib import Path

import pytest
from garmentq.core.recover.settings import RecoverySettings
from garmentq.service.database import Database, open_database, upgrade
from garmentq.service.families import release_waiting_jobs, retry
from garmentq.service.jobs import find_job, read_events
from garmentq.service.keys import list_keys
from garmentq.service.models import ArtifactRow, OwnerRow
from garmentq.service.query import JobQuery, find_jobs
from garmentq.service.reaper import dispatch, reap
from garmentq.service.results import export_files, report_jobs
from garmentq.service.states import State
from garmentq.service.submission import Order, submit
from garmentq.workers.recovery import run_job
from garmentq_home import drop_tables
from garmentq_standin import STEPS, hold_gate
from sqlalchemy import select, text

DATA = Path(__file__).parent / "data"
DONE, BAD, CRASHED, CANCELLED = "1eced26b40f7", "c49ad11c4a5d", "816ff98f988f", "320a6865fde8"
INTERRUPTED, STOPPED = "a8a1a4393be6", "338b53c02985"
QUEUED, PLAIN, GPU = "d1a4a477136b", "f8f7fa38ca61", "2dab21d00d52"


@pytest.fixture
def old(settings, database_url, store):
    """Make a home as revision 0005 left it, open it with this version, and give its database."""
    if database_url:
        drop_tables(database_url)
    else:
        (settings.home / "garmentq.db").unlink()
    before = Database(settings.database, pooled=False)
    upgrade(before, "0005")
    with before.write() as session:
        for line in (DATA / "old_home.sql").read_text(encoding="utf-8").splitlines():
            if not line.startswith("--"):
                session.connection().exec_driver_sql(line)
        for table in ("events", "outbox") if database_url else ():  # keys were given, so their sequences stand at 1
            session.execute(text(f"select setval('{table}_id_seq', (select max(id) from {table}))"))
    before.dispose()
    for key, content in json.loads((DATA / "old_home_files.json").read_text()).items():
        assert store.put_bytes(base64.b64decode(content)).sha256 == key
    opened = open_database(settings, is_upgraded=True)
    yield opened
    opened.dispose()


def never():
    """Never drain."""
    return False


def test_jobs_of_every_state_are_families_of_their_own(settings, old):
    """Broken where the migration loses a job, or leaves one that nobody can query or show."""
    rows = {row.id: row for row in find_jobs(old)}
    assert {row.state for row in rows.values()} == set(State) - {State.WAITING} and len(rows) == 9
    assert all((row.kind, row.parent, row.family) == ("recover", None, row.id) for row in rows.values())
    assert {row.request["settings"]["fabric"] for row in rows.values()} == {None}, "the default is not said"
    assert [row.id for row in find_jobs(old, JobQuery({"family": BAD}).conditions)] == [BAD]
    reports = {job.id: job for job in report_jobs(old, list(rows.values()), settings)}
    done = reports[DONE]
    assert (done.garment, done.fabric, done.metrics["surface_rms_mm.t2s"]) == ("skirt", "cotton_poplin", 5.0)
    assert (done.gates[0].verdict, done.children, done.inputs, done.tags) == ("pass", [], {}, [])
    assert reports[BAD].error.code == "scan.truncated" and reports[CRASHED].error.code == "job.worker_lost"
    [key] = list_keys(old)
    with old.read() as session:
        assert session.scalars(select(OwnerRow.job).where(OwnerRow.key == key.id)).all() == [DONE]


def test_queued_jobs_run_and_interrupted_ones_resume(settings, old, store, tmp_path, monkeypatch):
    """Broken where an old request is not understood, a lease is not taken back, or a checkpoint is not found."""
    marks = tmp_path / "marks"
    monkeypatch.setenv("STANDIN_MARKS", str(marks))
    hold_gate(marks, STEPS)
    assert reap(old, 3) == 2 and release_waiting_jobs(old) == 0
    assert find_job(old, STOPPED).state == State.CANCELLED, "it was asked to stop before the upgrade"
    for job in (CRASHED, CANCELLED):
        retry(old, job)
    sent = []
    dispatch(old, lambda job, queue: sent.append(job))
    assert {INTERRUPTED, QUEUED, PLAIN, GPU, CANCELLED} <= set(sent)
    crashing = find_job(old, CRASHED)
    with old.write() as session:  # it would kill this process; that it is queued again is what is asked here
        session.execute(text("update jobs set queue = 'none' where id = :job"), {"job": crashing.id})
    outcomes = [run_job(settings, old, job, never) for job in (QUEUED, PLAIN, CANCELLED, INTERRUPTED, GPU)]
    assert outcomes == ["succeeded"] * 5
    steps = [int(line.split()[0]) for line in marks.read_text().splitlines()]
    assert steps == list(range(20, STEPS)), "from the checkpoint that the old version kept"
    for job in (QUEUED, INTERRUPTED, DONE):
        assert find_job(old, job).state == State.SUCCEEDED
        assert [path.name for path in export_files(old, store, job, tmp_path / job)] == ["metrics.txt"]
    assert [event.kind for event in read_events(old, INTERRUPTED)][-1] == "succeeded"
    with old.read() as session:
        kept = session.scalars(select(ArtifactRow.kind).where(ArtifactRow.job == INTERRUPTED)).all()
    assert kept == ["result"], "checkpoints are let go"


def put_old_file(folder: Path, name: str) -> Path:
    """Write a file as the old home's stand-in took it for a mesh: its bytes are those of the stored requests."""
    path = folder / name
    path.write_text(f"ply\n{name} \n")
    return path


def test_the_same_order_is_still_the_same_job(old, store, tmp_path, monkeypatch):
    """Broken where the request or its hash is written otherwise: everything known would be computed once more."""
    body, skirt = put_old_file(tmp_path, "body.ply"), put_old_file(tmp_path, "skirt.ply")
    assert submit(old, store, Order(skirt, body)).is_new, "another version, another result"
    monkeypatch.setattr("garmentq.service.submission.__version__", "0.1.0")
    again = submit(old, store, Order(skirt, body))
    assert (again.job, again.is_new, again.state) == (DONE, False, State.SUCCEEDED)
    chosen = RecoverySettings(template="mine", seed=3)
    template = put_old_file(tmp_path, "mine.json")
    order = Order(put_old_file(tmp_path, "shirt3.ply"), body, template, chosen)
    assert submit(old, store, order).job == QUEUED
