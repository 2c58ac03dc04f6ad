"""A backup brings everything back, or says that it cannot."""

from __future__ import annotations

import json
import tarfile
import threading

import pytest
from garmentq.service.backup import BackupDamaged, BackupRefused, make_backup, restore_backup
from garmentq.service.database import open_database
from garmentq.service.jobs import claim, find_job
from garmentq.service.kinds.recover import Recover
from garmentq.service.query import list_jobs
from garmentq.service.results import export_files, load_checkpoint, save_checkpoint, store_result
from garmentq.service.stores import open_store
from garmentq_home import make_settings
from garmentq_standin import make_recovery


@pytest.fixture(scope="session")
def database_kind():
    """Choose SQLite: a server's database has its own tools."""
    return "sqlite"


@pytest.fixture
def filled(database, store, queue_job, tmp_path):
    """Return the ids of a finished, a running and a queued job."""
    done, running, queued = (queue_job(name) for name in ("done", "running", "queued"))
    request = type("R", (), {"scan": tmp_path / "done.ply", "settings": type("S", (), {"fabric": "x", "seed": 0})})
    files = tmp_path / "files"
    files.mkdir()
    (files / "pattern.svg").write_text("<svg/>")
    store_result(database, store, claim(database, done, "a", 30.0), Recover(), make_recovery(request, 1.0), files)
    save_checkpoint(database, store, claim(database, running, "a", 30.0), "drape", b"half way")
    store.put_bytes(b"named by nobody")
    return done, running, queued


def test_round_trip(settings, database, filled, tmp_path):
    """Broken where a job, a result, a checkpoint or an event is not what it was."""
    saved = make_backup(settings, tmp_path / "a.tar")
    other = make_settings(tmp_path / "other")
    restored = restore_backup(other, saved.path)
    assert (restored.files, restored.size, restored.missing) == (saved.files, saved.size, ())
    opened, store = open_database(other), open_store(other)
    done, running, _ = filled
    assert [row.id for row in list_jobs(opened)] == [row.id for row in list_jobs(database)]
    assert {row.id: row.state for row in list_jobs(opened)} == dict(
        zip(filled, ("succeeded", "running", "queued"), strict=True)
    )
    assert export_files(opened, store, done, tmp_path / "out")[0].read_text() == "<svg/>"
    assert load_checkpoint(opened, store, running, "drape") == b"half way"
    assert b"named by nobody" not in {store.get_bytes(one.sha256) for one in store.list_files()}
    opened.dispose()


def test_it_is_one_moment_of_a_busy_queue(settings, database, store, queue_job, tmp_path):
    """Broken where rows and files of a backup are of different times: a checkpoint would be named that is not in it."""
    held = claim(database, queue_job(), "a", 30.0)
    save_checkpoint(database, store, held, "drape", b"0")
    stop, wrote = threading.Event(), threading.Event()

    def work():
        step = 0
        while not stop.is_set():
            step += 1
            save_checkpoint(database, store, held, "drape", b"%d" % step)
            wrote.set()

    worker = threading.Thread(target=work)
    worker.start()
    try:
        assert wrote.wait(20.0)
        for index in range(3):
            saved = make_backup(settings, tmp_path / f"{index}.tar")
            assert saved.missing == ()
    finally:
        stop.set()
        worker.join()
    for index in range(3):
        other = make_settings(tmp_path / f"home{index}")
        assert restore_backup(other, tmp_path / f"{index}.tar").missing == ()
        opened = open_database(other)
        assert int(load_checkpoint(opened, open_store(other), held.job, "drape")) >= 0
        opened.dispose()


def test_nothing_is_overwritten_unless_told(settings, database, filled, queue_job, tmp_path):
    """Broken where a slip of the hand loses a backup, or the jobs of a home."""
    saved = make_backup(settings, tmp_path / "a.tar")
    with pytest.raises(BackupRefused):
        make_backup(settings, saved.path)
    later = queue_job("later")
    with pytest.raises(BackupRefused):
        restore_backup(settings, saved.path)
    assert find_job(database, later).state == "queued"
    database.dispose()
    restore_backup(settings, saved.path, is_overwrite=True)
    opened = open_database(settings)
    assert {row.id for row in list_jobs(opened)} == set(filled)
    opened.dispose()


@pytest.mark.parametrize("damage", ["cut", "flip", "stray", "link", "text", "missing"])
def test_a_damaged_backup_leaves_no_database(settings, filled, damage, tmp_path):
    """Broken where half a backup, or one that was tampered with, becomes a home."""
    path = make_backup(settings, tmp_path / "a.tar").path
    content = path.read_bytes()
    if damage == "cut":
        path.write_bytes(content[: len(content) // 2])
    elif damage == "flip":
        path.write_bytes(content.replace(b"<svg/>", b"<svg!>"))
    elif damage == "text":
        path.write_text("no tar file")
    elif damage == "missing":
        path.unlink()
    else:
        with tarfile.open(path, "a") as archive:
            member = tarfile.TarInfo("../../evil" if damage == "stray" else "store/" + "0" * 64)
            member.type, member.linkname = (
                (tarfile.REGTYPE, "") if damage == "stray" else (tarfile.SYMTYPE, "/etc/passwd")
            )
            archive.addfile(member)
    other = make_settings(tmp_path / "other")
    with pytest.raises(BackupDamaged):
        restore_backup(other, path)
    assert not (other.home / "garmentq.db").exists() and not (tmp_path.parent / "evil").exists()
    assert not list(other.home.glob(".restore-*"))


def test_the_commands(cli, settings, filled, tmp_path):
    """Broken where the commands do not do what the functions do, or their refusal is not status 4."""
    done = cli("backup", tmp_path / "a.tar", "--json")
    assert json.loads(done.stdout)["files"] > 3
    assert cli("restore", tmp_path / "a.tar").returncode == 4
    assert cli("restore", tmp_path / "a.tar", "--home", tmp_path / "new").returncode == 0
    rows = [json.loads(line)["job"] for line in cli("status", "--json", "--home", tmp_path / "new").stdout.splitlines()]
    assert set(rows) == set(filled)
    assert "is at revision" in cli("db", "upgrade", "--home", tmp_path / "new").stderr
