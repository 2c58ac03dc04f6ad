"""Many scans at once: folders, tables, and refusals that say whose they are."""

from __future__ import annotations

import json

import pytest
from garmentq.cli import exits
from garmentq.cli import run as run_command
from garmentq.service.jobs import find_job
from garmentq.service.query import list_jobs
from garmentq_home import put_file


@pytest.fixture
def scans(tmp_path):
    """Write a folder of scans with what lies beside scans."""
    folder = tmp_path / "scans"
    folder.mkdir()
    for name in ("b.ply", "a.ply", "body.ply"):
        put_file(folder, name)
    (folder / "notes.txt").write_text("x")
    return folder


def test_a_folder_stands_for_its_scans(cli, scans, tmp_path):
    """Broken where a folder is refused as a file that cannot be read, or what is no scan is handed in."""
    done = cli("submit", scans, "--body", "builtin:female,height=1.7", "--json")
    rows = [json.loads(line) for line in done.stdout.splitlines()]
    assert [row["file"].rsplit("/", 1)[1] for row in rows] == ["a.ply", "b.ply", "body.ply"], done
    (tmp_path / "empty").mkdir()
    done = cli("submit", tmp_path / "empty")
    assert done.returncode == 4 and "submit.folder_empty" in done.stderr


def test_a_table_has_a_row_for_each_scan(cli, scans, database):
    """Broken where a row's body, name or tags are another row's, or a misspelt column is passed over."""
    table = scans / "batch.csv"
    table.write_text(
        "\ufeffscan,body,name,tags,units\na.ply,body.ply,Anna,spring;hall 2,cm\nb.ply,,,,\n", encoding="utf-8"
    )
    done = cli("submit", table, "--body", "builtin:female,height=1.7", "--json")
    assert done.returncode == 0, done.stderr
    first, second = (find_job(database, json.loads(line)["job"]).request for line in done.stdout.splitlines())
    assert first["body"]["name"] == "body.ply" and second["body"] == "builtin:female,height=1.7"
    assert first["settings"]["units"] == "cm" and second["settings"]["units"] is None
    assert sorted(row.name for row in list_jobs(database)) == ["Anna", "b"]
    for text in ("scan,bodie\na.ply,x\n", "body\nx\n", "scan\na.ply,x,y\n", "scan,body\n,x\n"):
        table.write_text(text)
        done = cli("submit", table)
        assert done.returncode == 4 and "submit.table_bad" in done.stderr, (text, done)


def test_refusals_say_whose_they_are(cli, scans):
    """Broken where four scans are refused by four equal lines."""
    done = cli("submit", scans / "a.ply", scans / "gone.ply", scans / "b.ply", "--as", "garment")
    lines = [[word.strip() for word in line.split("  ") if word] for line in done.stdout.splitlines()]
    assert [(line[0], line[-2]) for line in lines] == [("-", "a.ply"), ("-", "gone.ply"), ("-", "b.ply")]


def test_a_bad_file_is_told_without_a_worker(cli, scans, database):
    """Broken where a file that cannot be read is queued behind good ones, or stops them, or its line is elsewhere."""
    (scans / "aa.ply").write_text("no mesh")
    done = cli("submit", scans, "--body", "builtin:female,height=1.7")
    lines = [[word.strip() for word in line.split("  ") if word] for line in done.stdout.splitlines()]
    assert done.returncode == 4 and done.stderr == "", done
    assert [line[-2] for line in lines] == ["aa.ply", "a.ply", "b.ply", "body.ply"]
    assert lines[0][0] == "-" and lines[0][-1].startswith("scan.magic: "), "its header tells, before any is read"
    queued = [line[0] for line in lines if line[0] != "-"]
    assert sorted(queued) == sorted(row.id for row in list_jobs(database))
    unchecked = cli("submit", scans / "aa.ply", "--body", "builtin:female,height=1.7", "--no-check")
    assert unchecked.returncode == 0 and len(list_jobs(database)) == 4


def test_whoever_waits_without_a_worker_is_told(cli, scans):
    """Broken where a wait that nobody can end says nothing."""
    words = ("submit", scans / "a.ply", "--body", "builtin:female,height=1.7", "--wait", "--timeout", "0.1")
    assert "no worker is up" in cli(*words).stderr


def test_one_ctrl_c_is_for_all_garments(cli, scans, monkeypatch):
    """Broken where each garment of a scan needs a Ctrl-C of its own."""
    from garmentq.workers import embedded

    waited = []
    monkeypatch.setattr(run_command, "wait_and_show", lambda *given: waited.append(given) or exits.DETACHED)
    monkeypatch.setattr(embedded, "ensure_services", lambda *given: [])
    done = cli("run", scans / "a.ply", "--body", "builtin:female", "--keep", "1", "--keep", "2")
    assert done.returncode == exits.DETACHED and len(waited) == 1, done


def test_what_a_person_stopped_stays_down(cli, scans, monkeypatch):
    """Broken where a waiting `run` starts again what `garmentq down` stopped a moment ago."""
    from garmentq.workers import embedded

    def wait(*given):
        cli("down")
        given[3].keep_up()

    monkeypatch.setattr(run_command, "wait_and_show", wait)
    started = []
    monkeypatch.setattr(embedded, "ensure_services", lambda *given: started.append(given) or [])
    done = cli("run", scans / "a.ply", "--body", "builtin:female")
    assert done.returncode == exits.UNREACHABLE and "service.stopped" in done.stderr and len(started) == 1


def test_many_dead_jobs_are_tried_again_at_once(cli, scans, database):
    """Broken where an outage's hundred jobs need a command each, or one that ended otherwise is run again."""
    from garmentq.service.jobs import claim, fail

    jobs = [cli("submit", scans / name, "--body", "builtin:female").stdout.split()[0] for name in ("a.ply", "b.ply")]
    for job, code in zip(jobs, ("job.crashed", "scan.truncated"), strict=True):
        fail(database, claim(database, job, "w", 30.0), code, "x", bad_input=False)
    assert cli("retry").returncode == cli("retry", jobs[0], "--state", "dead").returncode == 2
    assert cli("retry", "--state", "dead", "--json").stdout == ""
    done = cli("retry", "--state", "failed", "--error", "job.crashed", "--json")
    assert [json.loads(line)["job"] for line in done.stdout.splitlines()] == [jobs[0]]
    assert (find_job(database, jobs[0]).state, find_job(database, jobs[1]).state) == ("queued", "failed")
    assert cli("retry", "--state", "failed").returncode == 0 and find_job(database, jobs[1]).state == "queued"
