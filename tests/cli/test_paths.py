"""Paths that cannot be read or written: one line with a code, for every command that takes one."""

from __future__ import annotations

from pathlib import Path

import click
import pytest
from api_work import finish
from garmentq.cli.main import group
from garmentq.cli.output import NewFile, NewFolder
from garmentq_home import put_file

WRITTEN = {
    ("run",): ["{scan}"],
    ("dress",): ["{job}"],
    ("refit",): ["{job}"],
    ("refine",): ["{job}"],
    ("edit",): ["{job}", "--pattern", "{scan}"],
    ("animate",): ["{job}", "--motion", "walk"],
    ("export",): ["{job}"],
    ("sizes",): ["{job}"],
    ("measure",): ["builtin:female,height=1.70"],
    ("segment",): ["{scan}"],
    ("templates", "export"): ["tshirt"],
    ("bodies", "export"): ["builtin:female,height=1.70"],
    ("materials", "export"): ["denim"],
    ("bench",): ["{folder}"],
}
"""What else each command with an option for a file or folder that is written takes, by its words."""

READ = {
    ("run", "file"): ["{bad}", "--body", "builtin:female,height=1.70"],
    ("run", "labels"): ["{scan}", "--labels", "{bad}"],
    ("run", "body"): ["{scan}", "--body", "{bad}"],
    ("run", "template"): ["{scan}", "--body", "{scan}", "--template", "{bad}"],
    ("submit", "files"): ["{bad}", "--body", "builtin:female,height=1.70"],
    ("submit", "labels"): ["{scan}", "--labels", "{bad}"],
    ("submit", "body"): ["{scan}", "--body", "{bad}"],
    ("dress", "measures"): ["{job}", "--measures", "{bad}"],
    ("dress", "body"): ["{job}", "--body", "{bad}"],
    ("refit", "measures"): ["{job}", "--measures", "{bad}"],
    ("edit", "pattern"): ["{job}", "--pattern", "{bad}"],
    ("animate", "motion"): ["{job}", "--motion", "{bad}.bvh"],
    ("export", "allowance"): ["{job}", "--as", "pdf", "--allowance", "{bad}"],
    ("sizes", "table"): ["{job}", "--table", "{bad}"],
    ("match", "pairs"): ["{job}", "{job}", "--pairs", "{bad}"],
    ("segment", "scan"): ["{bad}", "--out", "{folder}"],
    ("segment", "labels"): ["{scan}", "--out", "{folder}", "--labels", "{bad}"],
    ("segment", "body"): ["{scan}", "--out", "{folder}", "--body", "{bad}"],
    ("inspect", "file"): ["{bad}"],
    ("inspect", "labels"): ["{scan}", "--labels", "{bad}"],
    ("templates import", "file"): ["{bad}", "--name", "mine"],
    ("bodies export", "spec"): ["{bad}.npz", "--out", "{folder}/body.ply"],
    ("materials import", "file"): ["{bad}"],
    ("restore", "file"): ["{bad}"],
    ("bench", "directory"): ["{bad}"],
}
"""What each command takes whose option or argument names a file that is read; `{bad}` stands for that file."""

OTHERWISE = {("archive", "file"), ("backup", "file")}
"""Arguments that are tested by themselves."""


def find_commands(command: click.Command, words: tuple[str, ...] = ()):
    """Return every command of the tree that does something, by its words."""
    if isinstance(command, click.Group):
        context = click.Context(command)
        for name in command.list_commands(context):
            yield from find_commands(command.get_command(context, name), (*words, name))
    else:
        yield words, command


@pytest.fixture
def places(settings, database, store, queue_job, tmp_path):
    """Return a finished job and a scan to fill in, and the paths that cannot be used, by what is wrong with them."""
    job = queue_job()
    finish(settings, database, store, job, tmp_path / "made")
    (tmp_path / "folder").mkdir()
    scan = put_file(tmp_path, "scan.ply")
    long = tmp_path / ("x" * 300)
    bad = {"unmade": Path("/proc/x"), "below a file": scan / "x", "long": long, "long below": long / "x"}
    return {"job": job, "scan": str(scan), "folder": str(tmp_path / "folder")}, bad


def test_every_path_is_tried():
    """Broken where a new command takes a path that no test here hands a bad one."""
    written, read = set(), set()
    for words, command in find_commands(group):
        for param in command.params:
            if param.name == "home" or not isinstance(param.type, click.Path):
                continue
            if isinstance(param.type, NewFile | NewFolder):
                written.add(words)
            else:
                read.add((" ".join(words), param.name))
    assert written == set(WRITTEN)
    assert read - OTHERWISE <= set(READ)


@pytest.mark.parametrize("words", WRITTEN, ids=" ".join)
def test_what_cannot_be_written(cli, places, tmp_path, words):
    """Broken where a path that cannot be made ends in a traceback, or only after the work is done."""
    fill, bad = places
    given = [part.format(**fill) for part in WRITTEN[words]]
    is_file = words[-1] == "export" and len(words) > 1
    end = "/x.ply" if is_file else ""
    wrong = {name: f"{path}{end}" for name, path in bad.items()}
    wrong["of the other kind"] = fill["folder"] if is_file else fill["scan"]
    if not is_file:
        wrong["full"] = "/dev/full"
    for name, path in wrong.items():
        done = cli(*words, *given, "--out", path)
        assert done.returncode == 2 and done.stdout == "", (name, done)
        lines = done.stderr.strip().splitlines()
        if name in ("of the other kind", "full"):  # click says so of what is there
            assert "is a directory" in lines[-1] or "is a file" in lines[-1] or "output.unwritable" in lines[-1]
        else:
            assert len(lines) == 1 and lines[0].startswith("error output.unwritable: "), (name, lines)
    assert {path.name for path in tmp_path.iterdir()} == {"body.ply", "folder", "home", "made", "scan.ply", "shirt.ply"}


def test_a_full_disk(cli, places, tmp_path):
    """Broken where a disk that fills while a file is written ends in a traceback."""
    fill, _ = places
    out = tmp_path / "folder"
    for name in ("body.ply", "denim.json", "tshirt.json", "pattern.svg"):
        (out / name).symlink_to("/dev/full")
    for command in (
        ("bodies", "export", "builtin:female,height=1.70", "--out", out / "body.ply"),
        ("materials", "export", "denim", "--out", out / "denim.json"),
        ("templates", "export", "tshirt", "--out", out / "tshirt.json"),
        ("export", fill["job"], "pattern.svg", "--out", out),
    ):
        done = cli(*command)
        assert done.returncode == 2 and done.stdout == "", done
        assert done.stderr.startswith("error output.unwritable: ") and len(done.stderr.splitlines()) == 1


def test_a_backup_that_cannot_be_written(cli, places):
    """Broken where a backup to a place that there cannot be ends in a traceback."""
    for path in places[1].values():
        done = cli("backup", path)
        assert done.returncode == 2 and len(done.stderr.splitlines()) == 1, done
        assert done.stderr.startswith("error output.unwritable: ")


@pytest.mark.parametrize(("words", "name"), READ, ids=lambda one: str(one))
def test_what_cannot_be_read(cli, places, words, name):
    """Broken where a file that cannot be read ends in a traceback, or as a fault of garmentq."""
    fill, bad = places
    for path in (*bad.values(), Path("/proc/self/mem"), Path(fill["folder"])):
        given = [part.format(**fill, bad=path) for part in READ[words, name]]
        done = cli(*words.split(), *given)
        assert done.returncode in (2, 3, 4), (path, done)
        is_told = "rror" in done.stderr or (words == "submit" and done.stdout.startswith("- "))
        assert is_told and "Traceback" not in done.stderr, done
        assert "Missing" not in done.stderr and "nexpected" not in done.stderr, done
