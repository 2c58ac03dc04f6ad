"""The command line as a user meets it: help, exit statuses, and what goes to which stream."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import click
import pytest
from click.testing import CliRunner
from garmentq.cli.main import COMMANDS, group
from garmentq.cli.run import name_folders
from garmentq.service.database import DatabaseUnreachable
from garmentq.service.families import cancel
from garmentq.service.jobs import claim, fail, find_job
from garmentq.service.local import LocalBackend
from garmentq_home import put_file

ROOT = Path(__file__).parents[2]


def walk(command, path=("garmentq",)):
    """Return every command with its words."""
    yield path, command
    if isinstance(command, click.Group):
        context = click.Context(command)
        for name in command.list_commands(context):
            yield from walk(command.get_command(context, name), (*path, name))


WALKED = list(walk(group))


@pytest.mark.parametrize(("path", "command"), WALKED, ids=[" ".join(path) for path, _ in WALKED])
def test_every_command_is_explained(path, command):
    """Broken where a command has no help, no example, an option without help, or no line in docs/reference/cli.md."""
    answer = CliRunner().invoke(group, [*path[1:], "--help"])
    assert answer.exit_code == 0
    assert "Example:" in answer.output and f"  {' '.join(path)}" in answer.output
    for parameter in command.params:
        if isinstance(parameter, click.Option):
            assert parameter.help, f"{parameter.name} has no help"
    line = f"`{' '.join(path)}"
    page = ROOT / "docs" / "reference" / "cli.md"
    assert line in page.read_text(encoding="utf-8"), f"{page} lacks {line}"


def test_the_list_of_commands_tells_what_they_tell():
    """Broken where a command's first line changed and the list in `garmentq --help` did not."""
    context = click.Context(group)
    for name, text in COMMANDS.items():
        command = group.get_command(context, name)
        assert command.name == name
        assert command.get_short_help_str(limit=200).rstrip(".") == text.rstrip(".")


def test_a_misspelt_command_is_told():
    """Broken where a letter too many sends a user to the list of forty commands."""
    assert "Did you mean `garmentq submit`?" in CliRunner().invoke(group, ["submitt"]).output


def test_help_is_light():
    """Broken where something heavy is imported before it is needed; torch alone costs seconds."""
    script = (
        "import sys, runpy\n"
        "sys.argv = ['garmentq', '--help']\n"
        "try:\n    runpy.run_module('garmentq.cli.main', run_name='__main__')\n"
        "except SystemExit:\n    pass\n"
        "heavy = 'torch numpy scipy numba open3d igl trimesh celery sqlalchemy rich redis'.split()\n"
        "print(sorted(set(heavy) & set(sys.modules)))\n"
    )

    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


def test_bad_input_ends_in_one_line(cli, tmp_path):
    """Broken where a file, body, template or name that cannot be used gives a traceback or another status than 4."""
    body, good = put_file(tmp_path, "body.ply"), put_file(tmp_path, "good.ply")
    broken, zipped = tmp_path / "broken.ply", put_file(tmp_path, "scan.zip")
    broken.write_text("no mesh")
    cases = [
        (("run", tmp_path / "nosuch.ply", "--body", body), 4, "scan.missing"),
        (("run", tmp_path, "--body", body), 4, "scan.missing"),
        (("run", zipped, "--body", body), 4, "scan.archive"),
        (("run", good, "--keep", "1", "--labels", tmp_path / "nosuch.npz"), 4, "scan.labels_unreadable"),
        (("run", good, "--as", "garment"), 4, "body.missing"),
        (("run", good, "--body", tmp_path / "nosuch.ply"), 4, "body.unreadable"),
        (("run", good, "--body", "builtin:female,height=9"), 4, "body.spec_bad"),
        (("run", good, "--body", body, "--template", "nosuch"), 3, "template.unknown"),
        (("run", good, "--body", body, "--template", "trousers", "--part", "neckline=v"), 4, "part.conflict"),
        (("run", good, "--body", body, "--fabric", "nosuch"), 3, "fabric.unknown"),
        (("run", good, "--body", body, "--garment", "hat"), 2, "settings.bad"),
        (("status", "nosuchjob"), 3, "job.unknown"),
        (("query", "--where", "drop table jobs"), 2, "query.bad"),
        (("templates", "import", broken, "--name", "x"), 4, "pattern."),
        (("templates", "show", "nosuch"), 3, "template.unknown"),
    ]
    for words, status, code in cases:
        done = cli(*words)
        assert done.returncode == status, (words, done.stderr)
        assert done.stdout == "" and len(done.stderr.strip().splitlines()) == 1, (words, done.stderr)
        assert done.stderr.startswith(f"error {code}"), (words, done.stderr)
    for words in (("run",), ("nosuch",), ("run", good, "--vertices", "3"), ("query", "--limit", "0")):
        assert cli(*words).returncode == 2
    assert cli("status", "--json").stdout == ""
    done = cli.start("run", zipped, "--body", body)
    assert done.returncode == 4 and done.stderr.startswith("error scan.archive") and done.stderr.count("\n") == 1


def test_an_unreachable_service_is_status_9(cli, tmp_path):
    """Broken where a script cannot tell a missing server from a bad file."""
    (tmp_path / "file").write_text("")
    done = cli("submit", tmp_path / "file", "--home", tmp_path / "file" / "home")
    assert done.returncode == 9 and done.stderr.startswith("error service.")
    done = cli("up", GARMENTQ_BROKER_URL="redis://:pssst@127.0.0.1:1/0")
    assert done.returncode == 9 and "pssst" not in done.stderr


def test_statuses_of_ended_jobs(cli, database, queue_job):
    """Broken where a script cannot tell how a job ended."""
    bad, fault, stopped, waiting = (queue_job(name) for name in ("bad", "fault", "stopped", "waiting"))
    fail(database, claim(database, bad, "a", 30.0), "scan.no_faces", "no faces", bad_input=True)
    fail(database, claim(database, fault, "a", 30.0), "job.crashed", "a bug", bad_input=False)
    cancel(database, stopped)
    expected = {bad: (4, "scan.no_faces"), fault: (5, "job.crashed"), stopped: (7, ""), waiting: (3, "result.missing")}
    for job, (status, code) in expected.items():
        done = cli("result", job)
        assert done.returncode == status and code in done.stderr
    assert cli("retry", waiting).returncode == 4
    assert cli("retry", fault, stopped).returncode == 0
    assert [find_job(database, job).state for job in (fault, stopped)] == ["queued"] * 2
    assert json.loads(cli("cancel", fault, "--json").stdout) == {"job": fault, "state": "cancelled"}


def test_submit_goes_on_after_a_bad_file(cli, tmp_path):
    """Broken where one bad file keeps the others out of the queue, or `submit` waits where nobody checks."""
    files = [put_file(tmp_path, "a.ply"), tmp_path / "nosuch.ply", put_file(tmp_path, "b.ply")]
    done = cli("submit", *files, "--body", put_file(tmp_path, "body.ply"), "--json")
    rows = [json.loads(line) for line in done.stdout.splitlines()]
    assert done.returncode == 4 and done.stderr == ""
    assert {row["file"]: row["job"] is not None for row in rows} == {
        str(file): file.name != "nosuch.ply" for file in files
    }
    assert next(row["error"]["code"] for row in rows if row["job"] is None) == "scan.missing"
    again = cli("submit", files[0], "--body", tmp_path / "body.ply")
    assert again.stdout.split()[0] in [row["job"] for row in rows] and again.returncode == 0


def test_a_priority_changes_after_submission(cli, database, queue_job):
    """Broken where a batch cannot be moved by its tag, a mistyped job is passed over, or no place is shown."""
    jobs = [queue_job(name, tags=("spring",)) for name in ("a", "b")]
    assert cli("priority", jobs[1][:8], "--to", "7").returncode == 0 and find_job(database, jobs[1]).priority == 7
    assert "queued, place 1" in cli("status", jobs[1]).stdout and "queued, place 2" in cli("status", jobs[0]).stdout
    done = cli("priority", "--batch", "spring", "--to", "-5", "--json")
    assert [json.loads(line)["priority"] for line in done.stdout.splitlines()] == [-5, -5]
    assert {find_job(database, job).priority for job in jobs} == {-5}
    assert cli("priority", "nosuch", "--to", "1").returncode == 3 and cli("priority", "--to", "1").returncode == 2


@pytest.mark.slow
def test_submit_waits_for_the_check(cli, tmp_path):
    """Broken where a file that cannot be used is not named, an ill file keeps a good one back, or no status tells."""
    broken, body = tmp_path / "broken.ply", put_file(tmp_path, "body.ply")
    broken.write_text("no mesh")
    good = put_file(tmp_path, "good.ply")
    try:
        assert cli.start("up", "--workers", "2").returncode == 0
        done = cli("submit", good, broken, "--body", body, "--wait")
        second, first = done.stdout.splitlines()  # its header tells
        assert done.returncode == 4 and second.split()[:3] == ["-", "broken.ply", "scan.magic:"]
        again = cli("submit", good, broken, "--body", body, "--json")
        rows = [json.loads(line) for line in again.stdout.splitlines()]
        assert again.returncode == 4 and [row["job"] for row in rows] == [None, first.split()[0]]
        assert rows[1]["state"] == "succeeded" and rows[1]["error"] is None
        assert rows[0]["error"]["code"] == "scan.magic"
        ran = cli("run", broken, "--body", body)
        assert ran.returncode == 4 and ran.stderr.splitlines()[-1].startswith("error scan.truncated")
    finally:
        cli("down")


@pytest.mark.slow
def test_run_shows_and_keeps_the_result(cli, tmp_path):
    """Broken where the main command does not bring its result out, mixes streams, or runs a known job again."""
    scan, body = put_file(tmp_path, "skirt.ply"), put_file(tmp_path, "body.ply")
    try:
        done = cli.start("run", scan, "--body", body, "--workers", "1", "--out", tmp_path / "out", "--json")
        assert done.returncode == 0, done.stderr
        found = json.loads(done.stdout)
        assert found["state"] == "succeeded" and found["garment"] == "skirt"
        assert Path(found["files"]["metrics.txt"]) == tmp_path / "out" / "metrics.txt"
        assert (tmp_path / "out" / "metrics.txt").is_file()
        job = found["job"]
        shown = cli("run", scan, "--body", body)
        assert shown.returncode == 0 and "succeeded" in shown.stderr
        assert len(shown.stdout.splitlines()) == 10
        for word in (job, "skirt", "surface", "passed", "metrics.txt"):
            assert word in shown.stdout
        for command in (("run", scan, "--body", body), ("result", job)):
            every = cli(*command, "--verbose").stdout
            for word in (job, "surface_rms_mm.t2s", "penetration", "metrics.txt"):
                assert word in every
        done = cli("run", put_file(tmp_path, "bad.ply"), "--body", body)
        assert done.returncode == 4 and "error scan.truncated" in done.stderr and "Traceback" not in done.stderr
        done = cli("run", put_file(tmp_path, "slow.ply"), "--body", body, "--timeout", "0.5")
        assert done.returncode == 8 and "continues" in done.stderr
        rows = cli("query", "--garment", "skirt", "--where", "surface_rms_mm.t2s < 6", "--json").stdout.splitlines()
        assert [json.loads(row)["job"] for row in rows] == [job]
        kinds = [json.loads(line)["kind"] for line in cli("logs", job, "--json").stdout.splitlines()]
        assert kinds[:2] == ["queued", "started"] and kinds[-1] == "succeeded"
        copied = cli("export", job, "--out", tmp_path / "copy").stdout.strip()
        assert Path(copied).read_text() == (tmp_path / "out" / "metrics.txt").read_text()
        assert cli("export", job, "nosuch").returncode == 3
    finally:
        done = cli("down", "--json")
    assert json.loads(done.stdout)["stopped"] == ["worker", "broker"]


@pytest.mark.parametrize(
    "words", [("templates", "export", "skirt"), ("materials", "export", "denim"), ("bodies", "export", "builtin:male")]
)
def test_a_file_that_cannot_be_written_is_refused(words, cli, tmp_path):
    """Broken where a folder that is not there, or is the file, ends in a traceback."""
    for out in (tmp_path / "none" / "file.ply", tmp_path):
        done = cli(*words, "-o", out)
        assert (done.returncode, done.stdout) == (2, "") and "Traceback" not in done.stderr


def test_templates_come_and_go(cli, tmp_path):
    """Broken where an exported template is no pattern, an import loses something, or a shipped one can be hidden."""
    path = tmp_path / "skirt.json"
    assert cli("templates", "export", "skirt", "-o", path).returncode == 0
    assert cli("templates", "import", path, "--name", "mine").returncode == 0
    assert cli("templates", "import", path, "--name", "skirt").returncode == 2
    assert cli("templates", "import", path, "--name", "../x").returncode == 2
    rows = {
        json.loads(line)["name"]: json.loads(line) for line in cli("templates", "list", "--json").stdout.splitlines()
    }
    assert rows["mine"]["source"] == "imported" and rows["skirt"]["source"] == "shipped"
    ours, theirs = (json.loads(cli("templates", "show", name, "--json").stdout) for name in ("mine", "skirt"))
    assert ours["panels"] == theirs["panels"] and ours["seams"] == theirs["seams"]
    scan, body = put_file(tmp_path, "scan.ply"), put_file(tmp_path, "body.ply")
    job = cli("submit", scan, "--body", body, "--template", "mine").stdout.split()[0]
    found = json.loads(cli("status", job, "--json").stdout)
    assert found["settings"]["template"] == "mine"


def test_materials(cli):
    """Broken where a fabric has no source for a number, or the library is empty."""
    rows = [json.loads(line) for line in cli("materials", "--json").stdout.splitlines()]
    assert len(rows) >= 12
    assert all(rows[0][name] > 0 for name in ("H00", "H11", "H22", "k", "density"))
    assert json.loads(cli("materials", "denim", "--json").stdout)["sources"]["density"]


def test_own_materials(cli, tmp_path):
    """Broken where a fabric that was exported, renamed and imported is another one, or a shipped one is lost."""
    path = tmp_path / "mine.csv"
    assert cli("materials", "export", "denim", "-o", path).returncode == 0
    assert cli("materials", "import", path).stderr.startswith("error fabric.shipped")
    path.write_text(path.read_text().replace("\ndenim,", "\nmine,"))
    assert cli("materials", "import", path).returncode == 0
    mine, denim = (json.loads(cli("materials", name, "--json").stdout) for name in ("mine", "denim"))
    assert mine | {"name": "denim"} == denim
    assert cli("materials", "delete", "denim").returncode == 2 and cli("materials", "delete", "mine").returncode == 0
    assert cli("materials", "mine").returncode == 3


def test_doctor_hides_secrets(cli):
    """Broken where `doctor` fails on a sound machine, or prints a password."""
    rows = {row["check"]: row for row in map(json.loads, cli("doctor", "--json").stdout.splitlines())}
    assert rows["packages"]["ok"] and rows["database"]["ok"] and rows["store"]["ok"] and rows["broker"]["ok"]
    done = cli("doctor", GARMENTQ_BROKER_URL="redis://:pssst@127.0.0.1:1/0")
    assert done.returncode == 1 and "pssst" not in done.stdout + done.stderr and "***" in done.stdout


def test_the_options_of_run():
    """Broken where an option of `run` was renamed."""
    answer = CliRunner().invoke(group, ["run", "--help"]).output
    for option in "body template garment fabric method preset units up vertices home out json".split():
        assert f"--{option}" in answer


@pytest.mark.parametrize(("error", "status"), [(KeyboardInterrupt, 130), (DatabaseUnreachable, 9)])
def test_whatever_stops_the_wait_the_jobs_are_named(cli, tmp_path, monkeypatch, error, status):
    """Broken where Ctrl-C, or a service that goes away, while files are checked keeps the ids of queued jobs back."""
    whole = LocalBackend.submit

    def submit(backend, order, is_checked):
        if order.scan.stem == "b":
            raise error()
        return whole(backend, order, is_checked)

    monkeypatch.setattr(LocalBackend, "submit", submit)
    files = [put_file(tmp_path, f"{name}.ply") for name in "abc"]
    done = cli("submit", *files, "--body", "builtin:female", "--json")
    rows = [json.loads(line) for line in done.stdout.splitlines()]
    assert done.returncode == status and rows[0]["state"] == "queued", done
    assert len(rows) == (1 if error is KeyboardInterrupt else 3)


def test_files_of_a_family_stay_in_its_folder(tmp_path):
    """Broken where a child without a name, or with a name longer than a file's may be, has its files elsewhere."""
    names = {"a": "", "b": "", "c": "é" * 255, "d": "../x", "e": "front"}
    root = SimpleNamespace(id="root", parent=None, name="root")
    family = [root, *(SimpleNamespace(id=job, parent="root", name=name) for job, name in names.items())]
    folders = name_folders(family, tmp_path)
    assert len(set(folders.values())) == 6 and all(folders[job].parent == tmp_path for job in names)
    for folder in folders.values():
        folder.mkdir(exist_ok=True)
