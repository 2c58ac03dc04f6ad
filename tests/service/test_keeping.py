"""What is kept is found again or named as lost, and what is deleted is gone."""

from __future__ import annotations

import io
import json
import os
import time

import pytest
from garmentq.core.cloth.fabric import Fabric
from garmentq.core.garment.pattern import Edge, Panel, Pattern
from garmentq.service import audit
from garmentq.service.backup import BackupRefused, make_backup, restore_backup
from garmentq.service.deletion import delete_jobs, find_old_families
from garmentq.service.families import JobNotEnded
from garmentq.service.home import HomeBusy, lock_home, remove_leftovers, use_home
from garmentq.service.jobs import JobUnknown, claim, fail, find_job
from garmentq.service.kinds.recover import Recover
from garmentq.service.kinds.rows import add_pattern
from garmentq.service.models import ArtifactRow, AuditRow, JobRow, PanelRow, PatternRow, ScanRow, UploadRow
from garmentq.service.persons import PersonUnknown, delete_person, find_person
from garmentq.service.results import store_result
from garmentq.service.terms import JobTerms
from garmentq.service.verify import verify_store
from garmentq_standin import make_recovery


@pytest.fixture
def done(database, store, queue_job, tmp_path):
    """Return a function that makes a job of a name with a result."""

    def make(name: str, text: str = "<svg/>") -> str:
        job = queue_job(name)
        chosen = type("S", (), {"fabric": "x", "seed": 0})
        request = type("R", (), {"scan": tmp_path / f"{name}.ply", "settings": chosen})
        files = tmp_path / f"files-{job}"
        files.mkdir()
        (files / "pattern.svg").write_text(text)
        store_result(database, store, claim(database, job, "a", 30.0), Recover(), make_recovery(request, 1.0), files)
        return job

    return make


def age(store):
    """Make every stored file old enough to be removed."""
    for one in store.list_files():
        os.utime(store.path(one.sha256), (1.0, 1.0))


def flip(store, sha256):
    """Flip one bit of a stored file."""
    path = store.path(sha256)
    content = bytearray(path.read_bytes())
    content[0] ^= 1
    path.write_bytes(bytes(content))


def keys_of(database, store, job):
    """Return the hashes of a job's result files."""
    from garmentq.service.results import list_files

    return [row.sha256 for row in list_files(database, job)]


def test_verify_names_file_and_job(settings, database, store, done, cli):
    """Broken where damage is noticed only by whoever needs the file, or nobody is told whose it is."""
    first, second = done("first", "one"), done("second", "two")
    assert cli("verify").returncode == cli("verify", "--read-data").returncode == 0
    [damaged], [missing] = keys_of(database, store, first), keys_of(database, store, second)
    flip(store, damaged)
    store.path(missing).unlink()
    assert [fault.fault for fault in verify_store(database, store, False).faults] == ["missing"]
    found = {fault.sha256: fault for fault in verify_store(database, store, True).faults}
    assert {key: fault.fault for key, fault in found.items()} == {damaged: "damaged", missing: "missing"}
    assert [(one.owner, one.name) for one in found[damaged].named] == [(f"job {first}", "pattern.svg")]
    told = cli("verify", "--read-data")
    assert told.returncode == 11 and first in told.stdout and second in told.stdout
    lines = cli("verify", "--read-data", "--json").stdout.splitlines()
    assert {json.loads(line)["sha256"] for line in lines} == set(found)


@pytest.mark.parametrize("database_kind", ["sqlite"], indirect=True)
def test_a_backup_goes_on_past_damage(settings, database, store, done, cli, tmp_path):
    """Broken where one flipped bit stops every backup, or a backup without a file says nothing of it."""
    job, other = done("first", "one"), done("second", "two")
    flip(store, keys_of(database, store, job)[0])
    made = cli("backup", tmp_path / "a.tar")
    assert made.returncode == 11 and "1 are damaged" in made.stderr, made
    from garmentq_home import make_settings

    restored = restore_backup(make_settings(tmp_path / "other"), tmp_path / "a.tar")
    assert len(restored.missing) == 1 and find_job(database, other)


@pytest.mark.parametrize("database_kind", ["sqlite"], indirect=True)
def test_a_restore_needs_the_home_alone(settings, database, done, tmp_path):
    """Broken where a worker or the API goes on with the file that was replaced, and serves nobody."""
    done("first")
    saved = make_backup(settings, tmp_path / "a.tar")
    held = use_home(settings)
    with pytest.raises(BackupRefused, match="has this home open"):
        restore_backup(settings, saved.path, is_overwrite=True)
    os.close(held)
    assert restore_backup(settings, saved.path, is_overwrite=True).files == saved.files
    alone = lock_home(settings)
    with pytest.raises(HomeBusy):
        use_home(settings)
    os.close(alone)


def test_a_deleted_job_is_gone_with_its_files(database, store, done, queue_job):
    """Broken where rows or files of a deleted job stay, or one of another job goes with them."""
    gone, kept, open_ = done("gone", "one"), done("kept", "two"), queue_job("open")
    age(store)
    [ours], [theirs] = keys_of(database, store, gone), keys_of(database, store, kept)
    told = delete_jobs(database, store, [gone])
    assert told.jobs == (gone,) and told.files == 2, "its result and its scan; the body is another's too"
    with pytest.raises(JobUnknown):
        find_job(database, gone)
    left = {one.sha256 for one in store.list_files()}
    assert ours not in left and theirs in left
    with database.read() as session:
        assert {row.name for row in session.query(ScanRow)} == {"kept.ply", "open.ply"}
    with pytest.raises(JobNotEnded, match=open_):
        delete_jobs(database, store, [open_])
    assert verify_store(database, store, True).faults == ()


def test_a_person_is_deleted_with_all_that_was_made(database, store, done, cli, monkeypatch):
    """Broken where a body scan, or what was made of it, outlives the wish of the person."""
    from garmentq.service.submission import JobRequest, add_job

    first = done("anna")
    row = find_job(database, first)
    with database.write() as session:
        reads = JobRequest("dress", {}, row.scan, {"result": first}, JobTerms("a dress"))
        reader = add_job(session, reads).job
        session.get(JobRow, first).name = "Anna"
    other = done("berta")
    age(store)
    with pytest.raises(PersonUnknown):
        delete_person(database, store, "nobody")
    with pytest.raises(JobNotEnded, match=reader):
        delete_person(database, store, "Anna")
    fail(database, claim(database, reader, "a", 30.0), "x.y", "z", bad_input=False)
    monkeypatch.setattr("sys.stdin", io.StringIO("n\n"))
    asked = cli("delete", "--person", "Anna")
    assert asked.returncode == 7 and "command.declined" in asked.stderr and find_job(database, first), "it asks first"
    told = cli("delete", "--person", "Anna", "--yes", "--json")
    assert told.returncode == 0 and sorted(json.loads(told.stdout)["jobs"]) == sorted([first, reader]), told
    assert row.scan not in {one.sha256 for one in store.list_files()}
    assert find_job(database, other) and verify_store(database, store, True).faults == ()


def test_a_name_is_no_pattern(database, store, done, cli):
    """Broken where `_` or `%` in a name, its case, or a second ending takes another person along."""
    names = ("scan_01", "scan-01", "scanX01", "SCAN_01", "Scan_01.b", "other")
    jobs = {name: done(name, name) for name in names}
    with database.write() as session:
        for number, name in enumerate(names):
            scan = find_job(database, jobs[name]).scan
            session.add(UploadRow(key="", sha256=scan, name=f"{name}.ply", size=1, created=float(number), kinds=[]))
    for name in ("%", "scan%", "_can_01", "scan_0_", "scan_01.", "scan_01.PLY", "scan\x00", "Scan_01"):
        with pytest.raises(PersonUnknown):
            delete_person(database, store, name)
    for name in ("scan_01", "scan_01.ply"):
        found = find_person(database, name)
        assert [one.job for one in found.jobs] == [jobs["scan_01"]] and found.names == ("scan_01", "scan_01.ply")
    tried = cli("delete", "--person", "scan_01", "--dry-run", "--json")
    assert [one["name"] for one in json.loads(tried.stdout)["uploads"]] == ["scan_01.ply"], tried
    assert "scan_01.ply" in cli("delete", "--person", "scan_01", "--dry-run").stdout
    old = json.loads(cli("delete", jobs["scan_01"], "--dry-run", "--json").stdout)
    assert [one["job"] for one in old["jobs"]] == [jobs["scan_01"]]
    assert all(find_job(database, job) for job in jobs.values()), "a dry run deletes nothing"
    done_ = json.loads(cli("delete", "--person", "scan_01", "--yes", "--json").stdout)
    assert done_["jobs"] == [jobs["scan_01"]] and done_["uploads"] == 1
    assert [one["job"] for one in done_["found"]["jobs"]] == [jobs["scan_01"]]
    assert all(find_job(database, jobs[name]) for name in names[1:])
    with database.read() as session:
        assert session.query(UploadRow).count() == len(names) - 1


def test_what_is_old_is_found(database, done, queue_job, cli):
    """Broken where an open or a young job is deleted for its age."""
    old, young, open_ = done("old"), done("young"), queue_job("open")
    with database.write() as session:
        session.get(JobRow, old).finished -= 100 * 86400.0
    assert find_old_families(database, 90 * 86400.0) == [old]
    assert cli("delete", "--older-than", "90d", "--yes").returncode == 0
    assert find_job(database, young) and find_job(database, open_)
    assert cli("delete").returncode == cli("delete", "--older-than", "soon").returncode == 2


@pytest.mark.parametrize("database_kind", ["sqlite"], indirect=True)
def test_leftovers_are_swept(settings, store):
    """Broken where what a killed process left fills the disk for ever, or a transfer under way is swept off."""
    places = [settings.home / "incoming" / "a", store.root / "incoming" / "b", settings.home / "work" / "c" / "d"]
    for place in places:
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_bytes(b"x")
    assert remove_leftovers(settings) == 0
    assert remove_leftovers(settings, time.time() + 2 * 86400.0) == 3
    assert not any(place.exists() for place in places)


def test_the_longest_names_fit_the_rows(database, queue_job):
    """Broken where a pattern passes the check and its job crashes at the very end, in the row of a panel."""
    import numpy as np

    square = np.array([[0.0, 0.0], [0.1, 0.0], [0.1, 0.1], [0.0, 0.1]])
    name = "\u00c4rmel \u8896 " + "x" * 191
    panel = Panel(name, square, (Edge(),) * 4, label="y" * 200)
    pattern = Pattern("n" * 100, (panel,), (), category="c" * 32)
    job = queue_job()
    fabric = Fabric("f", 100.0, 10.0, 100.0, 30.0, 1e-5, 0.15)
    with database.write() as session:
        add_pattern(session, job, pattern, fabric, ("c" * 32, "t" * 200))
    with database.read() as session:
        assert session.get(PanelRow, (job, name)).label == "y" * 200
        assert session.get(PatternRow, job).category == "c" * 32


def test_no_text_of_an_error_is_refused_by_a_database(settings, database, queue_job, monkeypatch):
    """Broken where NUL or half a letter in a message makes a failed job `dead` after three attempts."""
    from garmentq.core.run.errors import BadInput
    from garmentq.workers import recovery

    def refuse(*_):
        raise BadInput("a\x00b\ud800c\u202ed\x1b[2J")

    monkeypatch.setattr(recovery, "unpack", refuse)
    job = queue_job()
    assert recovery.run_job(settings, database, job, lambda: False) == "failed"
    assert find_job(database, job).error_message == "a?b?c?d?[2J"


def test_old_accesses_are_forgotten(database):
    """Broken where the audit log keeps personal data for longer than it says, or loses what is younger."""
    ages = {"old": audit.KEPT_DAYS + 1.0, "young": audit.KEPT_DAYS - 1.0}
    with database.write() as session:
        for subject, days in ages.items():
            at = time.time() - 86400.0 * days
            session.add(AuditRow(at=at, key="", action="deleted", subject=subject, address="", request=""))
    assert audit.forget_accesses(database) == 1
    assert [access.subject for access in audit.list_accesses(database)] == ["young"]


def test_the_log_keeps_no_person(database):
    """Broken where the name of a person who was deleted stays in the log for a year."""
    for path in ("/v1/persons/Anna%20B", "/v1/persons/Anna/x", "/v1/templates/mine"):
        audit.record_access(database, "", "DELETE 200", path, ("", ""))
    assert [one.subject for one in audit.list_accesses(database)] == ["/v1/templates/mine"] + ["/v1/persons/{name}"] * 2


def test_an_export_is_its_keys(database, store, done):
    """Broken where a key that shares a job finds the file that another one made of it."""
    from garmentq.service.exports import find_export
    from garmentq.service.keys import create_key, grant_job
    from garmentq.service.results import RESULT, ResultMissing
    from garmentq.service.submission import JobRequest, add_job

    first = done("first")
    scan = find_job(database, first).scan
    keys = [create_key(database, name, ("read",), 1)[0].id for name in ("a", "b")]
    with database.write() as session:
        made = add_job(session, JobRequest("export", {}, scan, {"result": first}, JobTerms("cut"))).job
        session.get(JobRow, made).state = "succeeded"
        grant_job(session, keys[0], made)
        session.add(ArtifactRow(job=made, kind=RESULT, name="pieces.pdf", sha256=scan, size=1, created=1.0))
    assert {find_export(database, first, "pieces.pdf", key).sha256 for key in ("", keys[0])} == {scan}
    with pytest.raises(ResultMissing):
        find_export(database, first, "pieces.pdf", keys[1])
