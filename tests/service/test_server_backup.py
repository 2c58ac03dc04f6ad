"""A server's backup is one file, of one moment, which either kind of database takes; real PostgreSQL and S3 servers."""

from __future__ import annotations

import os
import sqlite3
import tarfile
import threading
from contextlib import closing
from dataclasses import replace

import pytest
from garmentq.migrations import HEAD
from garmentq.service.backup import BackupRefused, make_backup, restore_backup
from garmentq.service.database import Database, DatabaseTooNew, open_database, upgrade
from garmentq.service.jobs import claim, find_job
from garmentq.service.keys import create_key
from garmentq.service.model_base import Base
from garmentq.service.models import EventRow, OwnerRow
from garmentq.service.reaper import record_heartbeat, remove_worker
from garmentq.service.results import load_checkpoint, save_checkpoint
from garmentq.service.store import Store
from garmentq.service.stores import open_store
from garmentq.service.webhooks import create_webhook
from garmentq_family_home import work_off
from garmentq_home import Cli, drop_database, drop_tables, make_database, make_settings
from sqlalchemy import Text, cast, func, select, text


@pytest.fixture(scope="session")
def database_kind():
    """Choose PostgreSQL."""
    return "postgresql"


@pytest.fixture(scope="module")
def bucket_server():
    """Start an S3 server on a free port."""
    from moto.server import ThreadedMotoServer

    started = ThreadedMotoServer("127.0.0.1", port=0, verbose=False)
    started.start()
    host, port = started.get_host_and_port()
    yield f"http://{host}:{port}"
    started.stop()


@pytest.fixture
def fresh(postgres, tmp_path):
    """Return settings of another host and an empty database."""
    address = make_database(postgres)
    drop_tables(address)
    yield make_settings(tmp_path / "other", database_url=address, store=str(tmp_path / "other-store"))
    drop_database(address)


@pytest.fixture
def filled(settings, database, store, queue_job, family):
    """Return the settings of a service with a family, its owner, a webhook, a running job and texts of all kinds."""
    key, _ = create_key(database, 'O\'Brien "naïve" ✂ \\x', ("read", "submit"))
    create_webhook(database, "https://example.com/a?b=%20", (), "", key.id)
    chosen, queue = family
    queue("one")
    work_off(chosen, database)
    running = queue_job("läuft", tags=("a b", "ü"))
    save_checkpoint(database, store, claim(database, running, "a", 30.0), "drape", b"half way")
    with database.write() as session:
        session.add(OwnerRow(key=key.id, job=running))
        session.execute(text('update jobs set expected_end = 1.5e300, result = \'{"a": [1, 2.50, null, "☂"]}\''))
    return settings


def read_all(database: Database) -> dict[str, list[tuple]]:
    """Return every row of every table as both databases hold them, JSON values as text."""
    found = {}
    with database.read() as session:
        for table in Base.metadata.sorted_tables:
            columns = [
                cast(one, Text) if "JSON" in repr(one.type.__dict__.get("impl")) else one for one in table.columns
            ]
            plain = select(*columns).order_by(*table.primary_key)
            found[table.name] = [tuple(row) for row in session.connection().execute(plain)]
    return found


def open_all(settings):
    """Return every row of the database of some settings."""
    opened = open_database(settings)
    try:
        return read_all(opened)
    finally:
        opened.dispose()


def test_every_row_comes_back_in_either_database(filled, fresh, tmp_path):
    """Broken where a table, a column, a type or a reference within a table is lost on the way, in either direction."""
    before = open_all(filled)
    assert sum(map(bool, before.values())) >= 10, "too little to tell"
    assert any(row for row in before["jobs"] if row[6] is not None), "a job below another"
    saved = make_backup(filled, tmp_path / "a.tar")
    restored = restore_backup(fresh, saved.path)
    assert (restored.files, restored.size) == (saved.files, saved.size) and saved.files > 0
    assert open_all(fresh) == before and (saved.missing, restored.missing) == ((), ())
    home = make_settings(tmp_path / "home2")
    restore_backup(home, saved.path)
    assert open_all(home) == before, "a laptop opens a server's backup"
    again = make_backup(home, tmp_path / "b.tar")
    restore_backup(fresh, again.path, is_overwrite=True)
    assert open_all(fresh) == before, "and a server takes a laptop's"


def test_the_restored_service_goes_on(filled, fresh, tmp_path):
    """Broken where new events get numbers that are taken, or a job that ran can neither be read nor taken back."""
    restore_backup(fresh, make_backup(filled, tmp_path / "a.tar").path)
    database, store = open_database(fresh), open_store(fresh)
    [running] = [row[0] for row in read_all(database)["jobs"] if row[3] == "läuft"]
    assert load_checkpoint(database, store, running, "drape") == b"half way"
    with database.write() as session:
        last = session.scalar(select(func.max(EventRow.id)))
        session.add(EventRow(job=running, at=0.0, kind="started", data={}))
        session.flush()
        assert session.scalar(select(func.max(EventRow.id))) == last + 1
    assert Cli(fresh)("cancel", running).returncode == 0 and find_job(database, running).cancel
    database.dispose()


def test_it_is_one_moment_of_a_busy_service(settings, database, store, queue_job, fresh, tmp_path):
    """Broken where rows and files are of different times: a checkpoint would be named that is not in the backup."""
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
        saved = [make_backup(settings, tmp_path / f"{index}.tar") for index in range(2)]
    finally:
        stop.set()
        worker.join()
    for index, one in enumerate(saved):
        assert one.missing == ()
        assert restore_backup(fresh, one.path, is_overwrite=index > 0).missing == ()
        opened = open_database(fresh)
        assert int(load_checkpoint(opened, open_store(fresh), held.job, "drape")) >= 0
        opened.dispose()


def test_a_bucket_may_be_left_to_its_own_tools(filled, fresh, bucket_server, tmp_path, monkeypatch):
    """Broken where the small backup of a large bucket has files, or does not say which of them the bucket lost."""
    monkeypatch.setenv("AWS_ACCESS_KEY_ID", "x")
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "y")
    bucket = f"s3://gq-{os.urandom(6).hex()}/studio"
    remote = replace(filled, store=bucket, s3_endpoint=bucket_server)
    opened, old = open_store(remote), Store(filled.store_path)
    opened.prepare()
    for one in old.list_files():
        opened.put_bytes(old.get_bytes(one.sha256))
    whole = Cli(remote)("backup", tmp_path / "whole.tar")
    slim = Cli(remote)("backup", tmp_path / "slim.tar", "--without-files")
    assert whole.returncode == slim.returncode == 0, (whole, slim)
    with tarfile.open(tmp_path / "slim.tar") as archive:
        assert archive.getnames() == ["garmentq.db", "about.json"]
    there = replace(fresh, store=bucket, s3_endpoint=bucket_server)
    files = make_backup(remote, tmp_path / "c.tar").files
    restored = restore_backup(there, tmp_path / "slim.tar")
    assert (restored.files, restored.missing) == (files, ())
    lost = next(opened.list_files()).sha256
    opened.remove(lost, 1e12)
    done = Cli(there)("restore", tmp_path / "slim.tar", "--overwrite")
    assert done.returncode == 11 and "1 files that the database names are missing" in done.stderr
    assert restore_backup(there, tmp_path / "whole.tar", is_overwrite=True).missing == ()
    assert opened.get_bytes(lost)


def test_a_damaged_row_is_kept_and_named(filled, database, fresh, tmp_path):
    """Broken where one bad row makes a service that cannot be saved, or vanishes from its backup."""
    with database.write() as session:
        session.execute(text("update jobs set state = 'sleeping' where name = 'läuft'"))
    saved = make_backup(filled, tmp_path / "a.tar")
    assert [(row.table, row.columns) for row in saved.rows] == [("jobs", ("state",))]
    restored = restore_backup(fresh, saved.path)
    assert restored.rows == saved.rows
    opened = Database(fresh.database, pooled=False)
    with opened.read() as session:
        assert session.execute(text("select name from jobs where state = 'sleeping'")).scalar() == "läuft"
    opened.dispose()


def test_what_is_there_is_kept_unless_told(filled, database, tmp_path):
    """Broken where a slip of the hand empties a service, or live workers go on with replaced rows."""
    saved, before = make_backup(filled, tmp_path / "a.tar"), read_all(database)
    for refused in (lambda: make_backup(filled, saved.path), lambda: restore_backup(filled, saved.path)):
        with pytest.raises(BackupRefused):
            refused()
    record_heartbeat(database, "host:1", "cpu", 1, 30.0)
    with pytest.raises(BackupRefused, match="workers are alive"):
        restore_backup(filled, saved.path, is_overwrite=True)
    remove_worker(database, "host:1")
    (tmp_path / "cut.tar").write_bytes(saved.path.read_bytes()[:20000])
    assert Cli(filled)("restore", tmp_path / "cut.tar", "--overwrite").returncode == 4
    assert read_all(database) == before
    database.dispose()
    assert restore_backup(filled, saved.path, is_overwrite=True).files == saved.files


def find_revision(path) -> str:
    """Return the revision of the database in a backup."""
    with tarfile.open(path) as archive:
        archive.extract("garmentq.db", path.parent, filter="data")
    with closing(sqlite3.connect(path.parent / "garmentq.db")) as opened:
        return opened.execute("select version_num from alembic_version").fetchone()[0]


def test_an_upgrade_and_the_way_back(fresh, tmp_path):
    """Broken where a backup of the version before is lost to the new one, or the way back does not end at the old."""
    earlier = f"{int(HEAD) - 1:04}"
    home = make_settings(tmp_path / "home")
    home.home.mkdir(mode=0o700)
    old = Database(home.database, pooled=False)
    upgrade(old, earlier)
    with old.write() as session:
        session.execute(text("insert into locks (name, owner, until) values ('l', 'host', 1.5)"))
    old.dispose()
    before = make_backup(home, tmp_path / "before.tar")
    assert find_revision(before.path) == earlier
    assert Cli(home)("status").returncode == 9 and Cli(home)("db", "upgrade").returncode == 0
    assert find_revision(make_backup(home, tmp_path / "after.tar").path) == HEAD
    back = make_settings(tmp_path / "back")
    restore_backup(back, before.path)
    opened = Database(back.database, pooled=False)
    with opened.read() as session:
        assert session.execute(text("select version_num from alembic_version")).scalar() == earlier
        assert session.execute(text("select until from locks")).scalar() == 1.5
    opened.dispose()
    restore_backup(fresh, before.path)
    assert open_all(fresh)["locks"] == [("l", "host", 1.5)], "a new version takes it as its own"
    with closing(sqlite3.connect(tmp_path / "garmentq.db")) as newer:
        newer.execute("update alembic_version set version_num = '9999'")
        newer.commit()
    with tarfile.open(tmp_path / "newer.tar", "w") as archive:
        archive.add(tmp_path / "garmentq.db", "garmentq.db")
        (tmp_path / "about.json").write_text("{}")
        archive.add(tmp_path / "about.json", "about.json")
    with pytest.raises(DatabaseTooNew):
        restore_backup(fresh, tmp_path / "newer.tar", is_overwrite=True)
