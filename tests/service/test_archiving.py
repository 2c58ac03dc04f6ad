"""An archive has all of some families and nothing of others, and nothing is deleted before it was read back."""

from __future__ import annotations

import tarfile

import pytest
from garmentq.service.archiving import ArchiveRefused, archive_jobs
from garmentq.service.backup import BackupDamaged, read_backup, restore_backup
from garmentq.service.database import open_database
from garmentq.service.jobs import JobUnknown, claim, find_job
from garmentq.service.keys import create_key, grant_job
from garmentq.service.kinds.recover import Recover
from garmentq.service.query import list_jobs
from garmentq.service.records import JobId
from garmentq.service.results import export_files, store_result
from garmentq.service.services import open_services
from garmentq.service.stores import open_store
from garmentq.service.subject_records import SubjectFields
from garmentq.service.subjects import assign_jobs, create_subject
from garmentq_home import Cli, make_settings
from garmentq_standin import make_recovery


@pytest.fixture(scope="session")
def database_kind():
    """Choose SQLite: a copy of a server's database is an SQLite file, too."""
    return "sqlite"


@pytest.fixture
def finish(database, store, queue_job, tmp_path):
    """Return a function that makes a finished job with a file of its own."""

    def make(name: str, **options) -> JobId:
        job = queue_job(name, **options)
        files = tmp_path / f"files of {name}"
        files.mkdir()
        (files / "pattern.svg").write_text(f"<svg>{name}</svg>")
        request = type(
            "R", (), {"scan": tmp_path / f"{name}.ply", "settings": type("S", (), {"fabric": "x", "seed": 0})}
        )
        store_result(database, store, claim(database, job, "a", 30.0), Recover(), make_recovery(request, 1.0), files)
        return job

    return make


def test_only_what_was_chosen_is_in_it(settings, database, finish, tmp_path):
    """Broken where another person's name, file or subject, or a key can be read in the archive."""
    anna, bertha = finish("anna"), finish("bertha")
    key, _ = create_key(database, "studio key", ("read",))
    for name, job in (("Anna Müller", anna), ("Bertha Benz", bertha)):
        create_subject(database, SubjectFields(name))
        assign_jobs(database, name, [job])
    with database.write() as session:
        grant_job(session, key.id, anna)
    services = open_services(settings)
    assert archive_jobs(services, settings, [anna], tmp_path / "a.tar") == (anna,)
    services.database.dispose()
    content = (tmp_path / "a.tar").read_bytes()
    for lost in (b"bertha", b"Bertha", b"studio key", key.id.encode()):
        assert lost not in content, lost
    assert "Anna Müller".encode() in content
    other = make_settings(tmp_path / "other")
    assert restore_backup(other, tmp_path / "a.tar").missing == ()
    opened = open_database(other)
    assert [row.id for row in list_jobs(opened)] == [anna]
    exported = export_files(opened, open_store(other), anna, tmp_path / "out")
    assert exported[0].read_text() == "<svg>anna</svg>"
    opened.dispose()


def test_what_reads_it_and_what_it_reads_come_along(settings, database, store, finish, queue_job, tmp_path):
    """Broken where a restored result lacks the job that it was made from, or a deletion takes one that is in no
    archive."""
    from garmentq.service.models import JobInputRow

    inner, outer, alone = finish("inner"), finish("outer"), finish("alone")
    with database.write() as session:
        session.add(JobInputRow(job=outer, name="inner", input=inner))
    services = open_services(settings)
    for chosen in (inner, outer):
        kept = archive_jobs(services, settings, [chosen], tmp_path / f"{chosen}.tar")
        assert set(kept) == {inner, outer} and alone not in kept
    waiting = queue_job("waiting")
    with pytest.raises(ArchiveRefused, match="has not ended"):
        archive_jobs(services, settings, [waiting], tmp_path / "w.tar")
    assert not (tmp_path / "w.tar").exists()
    services.database.dispose()


def test_a_damaged_file_stops_it(settings, database, store, finish, tmp_path):
    """Broken where jobs are deleted though the archive lacks a file of theirs, or a changed one passes for whole."""
    job = finish("anna")
    (file,) = [one for one in store.list_files() if store.get_bytes(one.sha256).startswith(b"<svg>")]
    whole = store.get_bytes(file.sha256)
    cli = Cli(settings)
    assert cli("archive", tmp_path / "good.tar", job).returncode == 0
    damaged = (tmp_path / "good.tar").read_bytes().replace(whole, whole[::-1])
    (tmp_path / "changed.tar").write_bytes(damaged)
    with pytest.raises(BackupDamaged):
        read_backup(tmp_path / "changed.tar")
    (path,) = [one for one in settings.store_path.rglob("*") if one.is_file() and one.read_bytes() == whole]
    path.chmod(0o600)
    path.write_bytes(b"other")
    done = cli("archive", tmp_path / "bad.tar", job, "--delete", "--yes")
    assert done.returncode != 0 and "archive.refused" in done.stderr
    assert find_job(database, job).state == "succeeded" and not (tmp_path / "bad.tar").exists()


def test_jobs_are_archived_and_deleted_by_a_command(settings, database, finish, tmp_path):
    """Broken where the command deletes other jobs than it archived, or none."""
    old, new = finish("old", tags=("2025",)), finish("new", tags=("2026",))
    cli, tar = Cli(settings), tmp_path / "2025.tar"
    done = cli("archive", tar, "--batch", "2025", "--delete", "--yes")
    assert done.returncode == 0 and "1 jobs are in" in done.stderr, done
    with pytest.raises(JobUnknown):
        find_job(database, old)
    assert find_job(database, new).state == "succeeded"
    assert cli("archive", tar, "--batch", "2026").returncode != 0, "the file exists"
    assert cli("archive", tar).returncode == 2 and cli("archive", tar, new, "--batch", "2026").returncode == 2
    assert "nothing to archive" in cli("archive", tmp_path / "none.tar", "--batch", "1999").stderr
    home = tmp_path / "again"
    assert cli("restore", tar, "--home", home).returncode == 0
    with tarfile.open(tar) as members:
        assert "garmentq.db" in members.getnames()
    opened = open_database(make_settings(home))
    assert [row.name for row in list_jobs(opened)] == ["old"]
    opened.dispose()
