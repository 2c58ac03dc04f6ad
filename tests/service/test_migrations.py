"""The tables from the migrations are the tables of the models."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import garmentq.migrations as migrations
import pytest
from alembic.autogenerate import compare_metadata
from alembic.config import Config
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory
from garmentq.service.batches import find_batch, list_batches
from garmentq.service.database import (
    Database,
    DatabaseTooNew,
    DatabaseUnreachable,
    DriverMissing,
    open_database,
    read_revision,
    upgrade,
)
from garmentq.service.keys import KeyBad, authenticate_token, create_key, rotate_key
from garmentq.service.models import ApiKeyRow, Base, JobFileRow, JobRow, JobTagRow, MaterialRow, OwnerRow, ScanRow
from garmentq.service.settings import ServiceSettingBad
from garmentq.service.states import State
from garmentq.service.webhooks import claim_due_messages, create_webhook, queue_trial
from garmentq_home import drop_database, drop_tables, make_database, make_settings
from sqlalchemy import MetaData, Table, create_engine, insert, inspect, select, text


def describe(engine):
    """Return everything about the tables that the two ways could differ in."""
    found = inspect(engine)
    tables = {}
    for name in sorted(set(found.get_table_names()) - {"alembic_version"}):
        columns = {c["name"]: (str(c["type"]), c["nullable"]) for c in found.get_columns(name)}
        indexes = {(i["name"], tuple(i["column_names"]), i["unique"]) for i in found.get_indexes(name)}
        keys = {
            (tuple(k["constrained_columns"]), k["referred_table"], str(k["options"]))
            for k in found.get_foreign_keys(name)
        }
        unique = {(u["name"], tuple(u["column_names"])) for u in found.get_unique_constraints(name)}
        tables[name] = (columns, indexes, keys, unique, found.get_pk_constraint(name))
    return tables


def test_models_and_migrations_agree(database, database_url, tmp_path, request):
    """Broken where a model changed without a migration, or a type means another thing on PostgreSQL."""
    bare = f"sqlite:///{tmp_path / 'models.db'}"
    if database_url:
        bare = make_database(request.getfixturevalue("postgres"))
        drop_tables(bare)
    engine = create_engine(bare)
    Base.metadata.create_all(engine)
    assert describe(engine) == describe(database.engine)
    engine.dispose()
    if database_url:
        drop_database(bare)
    with database.read() as session:
        changes = compare_metadata(MigrationContext.configure(session.connection()), Base.metadata)
    if not database_url:  # Alembic cannot read which way a column of SQLite's index runs; `describe` compared the rest
        changes = [one for one in changes if getattr(one[1], "name", "") != "ix_jobs_urgency"]
    assert changes == []


def test_head_is_the_newest_script():
    """Broken where a migration was added and `HEAD` forgotten: old databases would not be upgraded."""
    config = Config()
    config.set_main_option("script_location", str(Path(migrations.__file__).parent))
    assert ScriptDirectory.from_config(config).get_heads() == [migrations.HEAD]


def test_down_and_up_again(database):
    """Broken where a downgrade leaves something behind that the upgrade trips over."""
    from alembic import command

    config = Config()
    config.set_main_option("script_location", str(Path(migrations.__file__).parent))
    before = describe(database.engine)
    with database.write() as session:
        config.attributes["connection"] = session.connection()
        command.downgrade(config, "base")
    assert describe(database.engine) == {}
    upgrade(database)
    assert describe(database.engine) == before


def test_results_from_before_verdicts_get_one(database):
    """Broken where an old result has no verdict, its `warn` is a word that nothing knows, or it cannot go back."""
    from alembic import command

    gate = {"name": "seams", "value": 1.0, "limit": 2.0, "message": "."}
    gates = [{**gate, "verdict": word} for word in ("pass", "warn")]
    config = Config()
    config.set_main_option("script_location", str(Path(migrations.__file__).parent))
    with database.write() as session:
        config.attributes["connection"] = session.connection()
        command.downgrade(config, "0007")
        session.execute(insert(ScanRow).values(sha256="s", name="s", size=1, created=0.0, details={}))
        jobs = Table("jobs", MetaData(), autoload_with=session.connection())
        old = {"scan": "s", "name": "s", "request": {}, "version": "0.1.0", "state": "succeeded", "touched": 0.0}
        old |= {"priority": 0, "cancel": False, "attempts": 1, "fence": 1, "created": 0.0, "stage": "", "progress": 1.0}
        for job, result in (("old", {"gates": gates}), ("empty", {}), ("open", None)):
            kept = {**old, "id": job, "dedup": job, "family": job, "bad_input": False, "result": result}
            session.execute(insert(jobs).values(kept))
    upgrade(database)
    with database.read() as session:
        rows = {row.id: row for row in session.scalars(select(JobRow))}
        assert {job: row.verdict for job, row in rows.items()} == {"old": "doubtful", "empty": None, "open": None}
        assert [gate["verdict"] for gate in rows["old"].result["gates"]] == ["pass", "doubtful"]
    with database.write() as session:
        config.attributes["connection"] = session.connection()
        command.downgrade(config, "0007")
        assert '"warn"' in session.execute(text("select cast(result as text) from jobs where id = 'old'")).scalar()
    upgrade(database)


def test_jobs_from_before_listed_fields_are_listed(database):
    """Broken where an old job, in whatever state, is not found by its method, garment or file, or cannot go back."""
    from alembic import command

    config = Config()
    config.set_main_option("script_location", str(Path(migrations.__file__).parent))
    file = "a" * 64
    request = {"settings": {"method": "deform", "preset": "default"}, "body": {"sha256": file}, "files": [file, "b"]}
    fabric = dict.fromkeys(("H00", "H01", "H11", "H22", "k", "density", "thickness", "friction"), 1.0)
    with database.write() as session:
        config.attributes["connection"] = session.connection()
        command.downgrade(config, "0015")
        tables = {name: Table(name, MetaData(), autoload_with=session.connection()) for name in ("jobs", "patterns")}
        session.execute(insert(ScanRow).values(sha256="s", name="s", size=1, created=0.0, details={}))
        session.execute(insert(MaterialRow).values(id="m", name="denim", title="", sources=[], **fabric))
        old = {"scan": "s", "name": "s", "version": "0.1.0", "touched": 0.0, "bad_input": False, "request": request}
        old |= {"priority": 0, "cancel": False, "attempts": 1, "fence": 1, "created": 0.0, "stage": "", "progress": 1.0}
        for state in State:
            result = {"cpu_seconds": 3.5, "gates": []} if state == State.SUCCEEDED else None
            row = {**old, "id": state.value, "dedup": state.value, "family": state.value, "state": state.value}
            session.execute(insert(tables["jobs"]).values({**row, "result": result}))
        session.execute(insert(tables["jobs"]).values({**old, "id": "bare", "dedup": "bare", "family": "bare",
                                                       "state": "queued", "request": {}, "result": None}))  # fmt: skip
        made = {"job": "succeeded", "name": "p", "category": "skirt", "template": "t", "material": "m", "seams": 1}
        session.execute(insert(tables["patterns"]).values(made))
    upgrade(database)
    with database.read() as session:
        rows = {row.id: row for row in session.scalars(select(JobRow))}
        named = set(session.execute(select(JobFileRow.job, JobFileRow.sha256)).all())
    done = rows["succeeded"]
    assert (done.garment, done.template, done.fabric, done.body) == ("skirt", "t", "denim", None)
    assert (done.cpu_seconds, done.peak_mb, rows["failed"].cpu_seconds) == (3.5, None, None)
    assert {job: row.method for job, row in rows.items()} == {"bare": None, **{s.value: "deform" for s in State}}
    assert {(job, key) for job, key in named} == {(state.value, file) for state in State}
    with database.write() as session:
        config.attributes["connection"] = session.connection()
        command.downgrade(config, "0015")
        assert session.execute(text("select count(*) from jobs")).scalar() == len(State) + 1
    upgrade(database)


def test_jobs_from_before_lanes_have_one(database):
    """Broken where an old open edit waits behind a batch, a garment behind the next person, or it cannot go back."""
    from alembic import command

    config = Config()
    config.set_main_option("script_location", str(Path(migrations.__file__).parent))
    with database.write() as session:
        config.attributes["connection"] = session.connection()
        command.downgrade(config, "0018")
        jobs = Table("jobs", MetaData(), autoload_with=session.connection())
        session.execute(insert(ScanRow).values(sha256="s", name="s", size=1, created=0.0, details={}))
        old = {"scan": "s", "name": "s", "version": "0.1.0", "touched": 0.0, "bad_input": False, "request": {}}
        old |= {"priority": 0, "cancel": False, "attempts": 1, "fence": 1, "stage": "", "progress": 1.0}
        made = [(state.value, "recover", None, state.value, 1.0) for state in State]
        made += [("edit", "edit", None, "running", 2.0), ("look", "recover", "deform", "running", 3.0)]
        for job, kind, method, family, created in made:
            state = job if job in set(State) else "queued"
            row = {"id": job, "dedup": job, "kind": kind, "method": method, "family": family, "created": created}
            session.execute(insert(jobs).values({**old, **row, "state": state}))
    upgrade(database)
    with database.read() as session:
        rows = {row.id: (row.lane, row.family_created) for row in session.scalars(select(JobRow))}
        assert rows == {**{s.value: (2, 1.0) for s in State}, "edit": (0, 1.0), "look": (1, 1.0)}
        assert not session.scalar(select(JobRow.id).where(JobRow.preempt | (JobRow.preemptions > 0)))
    with database.write() as session:
        config.attributes["connection"] = session.connection()
        command.downgrade(config, "0018")
        assert session.execute(text("select count(*) from jobs")).scalar() == len(made)
    upgrade(database)


def test_a_newer_database_is_refused(settings, database):
    """Broken where an old program wrote into tables it does not know."""
    with database.write() as session:
        session.execute(text("update alembic_version set version_num = '9999'"))
    with pytest.raises(DatabaseTooNew):
        open_database(settings)


def test_opening_makes_the_tables_once(tmp_path):
    """Broken where a fresh home has no tables, or a second opening changes them."""
    settings = make_settings(tmp_path / "fresh")
    for _ in range(2):
        opened = open_database(settings, pooled=False)
        with opened.read() as session:
            assert read_revision(session.connection()) == migrations.HEAD
            assert session.execute(text("pragma journal_mode")).scalar() == "wal"
            assert session.execute(text("pragma foreign_keys")).scalar() == 1
        opened.dispose()


@pytest.mark.parametrize("database_kind", ["sqlite"], indirect=True)
def test_a_second_opening_leaves_the_first_its_locks(settings, database):
    """Broken where a process that opens its home twice reads old rows for ever, or finds the file damaged.

    Another process that closes the file takes itself for the last one then, and removes the log.
    """
    own = (str(os.getpid()), str((settings.home / "garmentq.db").stat().st_ino))

    def is_locked() -> bool:
        held = [line.split() for line in Path("/proc/locks").read_text().splitlines() if "->" not in line]
        return own in [(words[4], words[5].rsplit(":", 1)[1]) for words in held]

    with database.write() as session:
        session.execute(text("create table seen (x)"))
    assert is_locked()
    second = open_database(settings)
    assert is_locked()
    second.dispose()


def test_an_unreachable_database_is_one_clear_error(tmp_path):
    """Broken where a driver's traceback reaches the user."""

    opened = Database(f"sqlite:///{tmp_path / 'no' / 'such' / 'folder.db'}")
    with pytest.raises(DatabaseUnreachable), opened.read() as session:
        session.execute(text("select 1"))


@pytest.mark.parametrize("address", ["no address", "mysql://host/db", "oracle://host/db"])
def test_an_address_that_cannot_be_used_is_a_bad_setting(address):
    """Broken where a misspelt address ends in SQLAlchemy's own error."""
    with pytest.raises(ServiceSettingBad):
        Database(address)


def test_a_missing_driver_names_the_extra(monkeypatch):
    """Broken where a user without psycopg reads `No module named psycopg` and not what to install."""
    monkeypatch.setitem(sys.modules, "psycopg", None)
    with pytest.raises(DriverMissing, match=r"garmentq\[postgres\]"):
        Database("postgresql://me:secret@host/db")


def test_no_postgres_behind_an_address_is_one_clear_error():
    """Broken where the driver's traceback or the password reaches the user."""
    opened = Database("postgresql://me:secret@127.0.0.1:1/db", pooled=False)
    with pytest.raises(DatabaseUnreachable) as caught, opened.read() as session:
        session.execute(text("select 1"))
    assert "secret" not in caught.value.message


def test_keys_and_webhooks_from_before_rotation(database):
    """Broken where a token or a secret of before ends with the new columns, or with their removal."""
    from alembic import command

    config = Config()
    config.set_main_option("script_location", str(Path(migrations.__file__).parent))
    key, token = create_key(database, "studio", ("read",))
    hook, secret = create_webhook(database, "https://studio.example/", [], "", key.id)
    with database.write() as session:
        config.attributes["connection"] = session.connection()
        command.downgrade(config, "0019")
        command.upgrade(config, "head")
    assert authenticate_token(database, token).key == key.id
    queue_trial(database, hook.id)
    (message,) = claim_due_messages(database, 1)
    assert (message.secret, message.earlier_secret) == (secret, None)
    _, newer = rotate_key(database, key.id)
    with database.write() as session:
        config.attributes["connection"] = session.connection()
        command.downgrade(config, "0019")
        command.upgrade(config, "head")
    assert authenticate_token(database, newer).key == key.id
    with pytest.raises(KeyBad):
        authenticate_token(database, token)


def test_tags_from_before_batches_are_batches(database):
    """Broken where the jobs of an old database, in whatever state and of whatever key, are in no batch, or go back."""
    from alembic import command

    config = Config()
    config.set_main_option("script_location", str(Path(migrations.__file__).parent))
    with database.write() as session:
        config.attributes["connection"] = session.connection()
        command.downgrade(config, "0016")
        jobs = Table("jobs", MetaData(), autoload_with=session.connection())
        session.execute(insert(ScanRow).values(sha256="s", name="s", size=1, created=0.0, details={}))
        key = {"id": "k", "name": "k", "hash": "h", "scopes": [], "quota": 1, "created": 0.0}
        session.execute(insert(ApiKeyRow).values(key))
        for number, state in enumerate(State):
            row = {"id": state.value, "dedup": state.value, "family": state.value, "state": state.value, "scan": "s"}
            row |= {"name": "s", "request": {}, "version": "1", "touched": 0.0, "created": float(number)}
            row |= {"priority": 0, "cancel": False, "attempts": 1, "fence": 1, "stage": "", "progress": 1.0}
            session.execute(insert(jobs).values({**row, "bad_input": False}))
            session.execute(insert(JobTagRow).values(job=state.value, tag="march"))
            if state == State.SUCCEEDED:
                session.execute(insert(JobTagRow).values(job=state.value, tag="own"))
                session.execute(insert(OwnerRow).values(key="k", job=state.value))
    upgrade(database)
    assert [one.tag for one in list_batches(database)] == ["march", "own"]
    assert {one.tag: one.jobs for one in list_batches(database, owner="k")} == {"march": 1, "own": 1}
    assert find_batch(database, "march").states == dict.fromkeys(State, 1)
    with database.write() as session:
        config.attributes["connection"] = session.connection()
        command.downgrade(config, "0016")
        assert session.scalar(text("select count(*) from jobs")) == len(State)
    upgrade(database)
