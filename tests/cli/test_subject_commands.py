"""Subjects and batches by command: orders, lists, tables, exports and deletions name people."""

from __future__ import annotations

import csv
import io
import json
from datetime import datetime

import pytest
from garmentq.cli.export_folders import prefix_files, write_plain
from garmentq.service.jobs import JobUnknown, claim, fail, find_job, find_jobs_by_id
from garmentq.service.subjects import find_subject, list_subjects
from garmentq_home import put_file

BODY = "builtin:female,height=1.7"


def read_rows(done) -> list[dict]:
    """Return the JSON lines of a command."""
    return [json.loads(line) for line in done.stdout.splitlines()]


def test_a_subject_by_command(cli, database, tmp_path):
    """Broken where a record cannot be made, changed or emptied, or a date is another day's."""
    words = ("--consented", "2026-11-22", "--consent", "form 7", "--keep", "90d", "--keep", "2030-01-31")
    (made,) = read_rows(cli("subjects", "create", "Anna", *words, "--json"))
    assert datetime.fromtimestamp(made["consented"]).date().isoformat() == "2026-11-22"
    assert (made["consent"], made["keep_days"], made["jobs"]) == ("form 7", 90.0, 0)
    assert datetime.fromtimestamp(made["keep_until"]).date().isoformat() == "2030-01-31"
    assert cli("subjects", "create", "Anna").returncode == 4
    assert cli("subjects", "update", "Anna", "--name", "Anne", "--keep", "never", "--note", "x").returncode == 0
    found = find_subject(database, "Anne")
    assert (found.note, found.consent, found.keep_days, found.keep_until) == ("x", "form 7", None, None)
    assert cli("subjects", "update", "Anne", "--keep", "soon").returncode == 2
    job = cli("submit", put_file(tmp_path, "a.ply"), "--body", BODY).stdout.split()[0]
    assert cli("subjects", "add", "Anne", job[:6]).returncode == 0
    shown = cli("subjects", "show", "Anne").stdout
    assert job in shown and "a.ply" in shown
    assert [row["name"] for row in read_rows(cli("subjects", "list", "--json"))] == ["Anne"]
    assert cli("subjects", "show", "Anna").returncode == 3
    assert cli("cancel", job).returncode == 0
    (dry,) = read_rows(cli("subjects", "delete", "Anne", "--dry-run", "--json"))
    assert [one["job"] for one in dry["jobs"]] == [job] and find_job(database, job)
    assert cli("subjects", "delete", "Anne", "--yes").returncode == 0 and list_subjects(database) == []


def test_a_deletion_without_an_answer_names_the_option(cli, database, tmp_path, monkeypatch):
    """Broken where a script learns that it was interrupted, which it was not, or something is deleted."""
    job = cli("submit", put_file(tmp_path, "a.ply"), "--body", BODY, "--subject", "Anna").stdout.split()[0]
    assert cli("cancel", job).returncode == 0
    for words in (("delete", job), ("delete", "--subject", "Anna"), ("subjects", "delete", "Anna")):
        monkeypatch.setattr("sys.stdin", io.StringIO(""))
        refused = cli(*words)
        assert refused.returncode == 2 and find_job(database, job)
        assert "error command.unconfirmed: " in refused.stderr and "--yes" in refused.stderr
        assert "interrupted" not in refused.stderr
    monkeypatch.setattr("sys.stdin", io.StringIO("n\n"))
    declined = cli("subjects", "delete", "Anna")
    assert declined.returncode == 7 and "command.declined" in declined.stderr and find_job(database, job)
    monkeypatch.setattr("sys.stdin", io.StringIO("y\n"))
    assert cli("delete", job).returncode == 0
    with pytest.raises(JobUnknown):
        find_job(database, job)


def test_a_table_of_orders_names_subjects(cli, database, tmp_path):
    """Broken where the persons of a table of scans are one, or two scans of a person are two."""
    for name in ("a.ply", "b.ply", "c.ply"):
        put_file(tmp_path, name)
    (tmp_path / "t.csv").write_text("scan,subject,tags\na.ply,Anna,m\nb.ply,Anna,m\nc.ply,Bo,m\n")
    done = cli("submit", tmp_path / "t.csv", "--body", BODY)
    assert done.returncode == 0, done.stderr
    assert {one.name: one.jobs for one in list_subjects(database)} == {"Anna": 2, "Bo": 1}
    assert len(read_rows(cli("query", "--subject", "Anna", "--batch", "m", "--json"))) == 2
    assert len(read_rows(cli("status", "--subject", "Bo", "--json"))) == 1
    assert cli("status", "--batch", "m").stdout.startswith("m: 3 jobs of 3 scans: 3 queued; 0 %; time to go unknown")


def test_a_table_for_people(cli, database, tmp_path):
    """Broken where a spreadsheet shows seconds since 1970, no person, or hides why a job failed."""
    job = cli("submit", put_file(tmp_path, "a.ply"), "--body", BODY, "--subject", "=Anna").stdout.split()[0]
    fail(database, claim(database, job, "w", 30.0), "scan.empty", "The scan has no points.", bad_input=True)
    (row,) = csv.DictReader(io.StringIO(cli("query", "--csv").stdout))
    assert list(row) == ["job", "person", "name", "garment", "state", "verdict", "error", "created", "finished"]
    assert (row["job"], row["person"], row["error"]) == (job, "'=Anna", "scan.empty: The scan has no points.")
    created = datetime.fromisoformat(row["created"])
    assert created.tzinfo is not None and abs(created.timestamp() - find_job(database, job).created) <= 1.0
    (row,) = csv.DictReader(io.StringIO(cli("query", "--csv", "--columns", "all").stdout))
    assert {"kind", "attempts", "family", "started"} <= set(row)
    (row,) = csv.DictReader(io.StringIO(cli("query", "--csv", "--columns", "name, state").stdout))
    assert row == {"name": "a", "state": "failed"}
    assert cli("query", "--csv", "--columns", "nosuch").returncode == cli("query", "--columns", "all").returncode == 2


def test_deletions_by_batch_family_and_subject(cli, database, tmp_path):
    """Broken where a batch, a family or a person cannot be deleted, or more goes than was meant."""
    jobs = {}
    for name, words in {"a": ("--tag", "m"), "b": ("--tag", "m"), "c": ("--subject", "Anna"), "d": ()}.items():
        jobs[name] = cli("submit", put_file(tmp_path, f"{name}.ply"), "--body", BODY, *words).stdout.split()[0]
        assert cli("cancel", jobs[name]).returncode == 0
    assert cli("delete", "--batch", "m", "--subject", "Anna").returncode == 2
    (dry,) = read_rows(cli("delete", "--batch", "m", "--dry-run", "--json"))
    assert {one["job"] for one in dry["jobs"]} == {jobs["a"], jobs["b"]}
    for words, left in (
        (("--batch", "m"), {"c", "d"}), (("--subject", "Anna"), {"d"}), (("--family", jobs["d"][:6]), set()),
    ):  # fmt: skip
        done = cli("delete", *words, "--yes")
        assert done.returncode == 0, done.stderr
        assert {row.id for row in find_jobs_by_id(database, list(jobs.values()))} == {jobs[name] for name in left}
    assert list_subjects(database) == []
    assert cli("delete", "--subject", "Anna", "--yes").returncode == 3


@pytest.mark.parametrize(
    ("name", "plain"),
    [
        ("Anna M\u00fcller tshirt", "Anna_Mueller_tshirt"), ("Ame\u0301lie/../x", "Amelie_.._x"),
        ("A\u0308nne", "Aenne"),
        ("--as (2)", "as_2"), ("\u041e\u043b\u044c\u0433\u0430 skirt", "\u041e\u043b\u044c\u0433\u0430_skirt"),
        ("\x1b[31m", "31m"), ("...", "garment"), ("\u00c5se \u00d8", "Ase_Oe"),
    ],
)  # fmt: skip
def test_names_of_files(name, plain):
    """Broken where a person's name makes a path that a program cannot open, that leaves the folder, or is empty."""
    assert write_plain(name) == plain


def test_a_file_says_person_and_garment(tmp_path):
    """Broken where files of two persons in one folder cannot be told apart."""
    (tmp_path / "detail.ply").write_text("x")
    (path,) = prefix_files("Anna_Mueller_tshirt", [tmp_path / "detail.ply"])
    assert path == tmp_path / "Anna_Mueller_tshirt_detail.ply" and path.read_text() == "x"
