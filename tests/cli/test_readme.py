"""Every command of the README, typed as it stands there: what it asks for, and that it ends well."""

from __future__ import annotations

import shlex
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from garmentq.service.models import JobRow
from garmentq.service.query import list_jobs
from garmentq_family_home import work_off
from garmentq_home import put_file

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
PERSONS = {"separator": "garmentq_person:take_apart", "person_checker": "garmentq_checker:check"}

KEPT = {
    "garmentq run garment.ply --body body.ply": [("recover", None, True)],
    "garmentq run garment.ply --body body.ply --out result": [("recover", None, True)],
    "garmentq run person.ply --labels labels.npz --keep 1": [("recover", "1", False)],
    "garmentq run person.ply --keep 1 --keep 2 --out result": [("recover", "1", False), ("recover", "2", False)],
    "garmentq submit scans/*.ply --body body.ply": [("recover", None, True)] * 2,
    "garmentq submit scans/*.ply --body scans/body.obj --wait": [("recover", None, True)] * 2,
}
"""Commands that there were before whole persons could be handed in, each with its jobs: kind, what is kept, and whether
there is a body."""

QUICK = (
    "garmentq status", "garmentq status --watch", "garmentq templates list", "garmentq materials",
    "garmentq materials export denim -o cloth.json",
    "garmentq query --garment skirt --where 'surface_rms_mm.t2s < 4' --sort -created --json",
    "garmentq query --sort -created --json", "garmentq templates export skirt -o skirt.json",
    "garmentq templates import mine.json --name mine", "garmentq bodies export builtin:female,height=1.70 -o body.ply",
)  # fmt: skip
"""Commands that ask for no job."""

NEW = (
    "garmentq run garment.ply --body body.ply --quality preview",
    "garmentq run scan.ply", "garmentq run scan.ply --labels parts/labels.npz",
    "garmentq run scan.ply --wearing one-piece --template one-piece:dress",
)  # fmt: skip
"""Commands on whole persons."""

ELSEWHERE = (
    "bench",
    "inspect",
    "segment",
    "serve",
    "worker",
    "up",
    "keys",
    "db",
    "logs",
    "result",
    "export",
    "sizes",
    "dress",
    "refit",
    "refine",
    "animate",
    "doctor",
    "measure",
)
"""Commands that other tests run: they take long, never end, or need a job's id."""


@pytest.fixture
def type_in(cli, settings, database, tmp_path, monkeypatch):
    """Return a function that runs a command among the files that the README names, with a worker that is quick."""
    (tmp_path / "scans").mkdir()
    for name in ("garment.ply", "person.ply", "scan.ply", "body.ply", "labels.npz"):
        put_file(tmp_path, name)
    (tmp_path / "parts").mkdir()
    put_file(tmp_path / "parts", "labels.npz")
    for name in ("a.ply", "b.ply", "body.obj"):
        put_file(tmp_path / "scans", name)
    shutil.copy(ROOT / "core/garment/library/skirt.json", tmp_path / "mine.json")
    monkeypatch.chdir(tmp_path)
    chosen = replace(settings, **PERSONS)

    def work(*_):
        work_off(chosen, database)
        return []

    monkeypatch.setattr("garmentq.workers.embedded.ensure_services", work)
    monkeypatch.setattr("garmentq.cli.submit._wait", lambda *_: work() or 0)

    def run(line: str):
        words = []
        for word in shlex.split(line)[1:]:
            words += sorted(map(str, Path().glob(word))) if "*" in word else [word]
        return cli(*words)

    return run


def read_commands() -> list[str]:
    """Return the commands of the README's blocks, without comments."""
    blocks = README.split("```")[1::2]
    lines = [part.strip() for block in blocks for line in block.splitlines() for part in line.split("#")[0].split(";")]
    return [line for line in lines if line.startswith("garmentq ")]


def describe(row: JobRow) -> tuple[str, str | None, bool]:
    """Return a job's kind, what is kept, and whether there is a body."""
    return row.kind, row.request["settings"]["keep"], row.request["body"] is not None


@pytest.mark.parametrize("line", KEPT)
def test_a_command_means_what_it_meant(line, type_in, database):
    """Breaks where a command that somebody has in a script asks for something else since persons can be handed in."""
    done = type_in(line)
    assert done.returncode == 0, done.stderr
    assert sorted(map(describe, list_jobs(database)), key=str) == KEPT[line]
    if line.endswith("--out result"):
        keeps = [keep for _, keep, _ in KEPT[line]]
        wanted = [Path("result", keep, "metrics.txt") for keep in keeps if keep] or [Path("result", "metrics.txt")]
        assert all(path.is_file() for path in wanted)


def test_a_scan_with_nothing_else(type_in, database):
    """Breaks where a raw scan is refused for want of labels and body, or its garments' files lie elsewhere."""
    done = type_in("garmentq run scan.ply --out result")
    assert done.returncode == 0, done.stderr
    assert sorted((row.kind, row.name) for row in list_jobs(database)) == [
        ("person", "scan"), ("recover", "lower"), ("recover", "upper")
    ]  # fmt: skip
    for name in ("report.html", "labels.npz", "upper/metrics.txt", "lower/metrics.txt"):
        assert Path("result", name).is_file(), name


@pytest.mark.parametrize("line", (*QUICK, *NEW))
def test_a_command_ends_well(line, type_in):
    """Breaks where a command of the README is refused."""
    done = type_in(line)
    assert done.returncode == 0, done.stderr


def test_nothing_of_the_readme_is_left_out():
    """Breaks where the README shows a command that no test types."""
    shown = read_commands()
    assert len(shown) > 20
    typed = {*KEPT, *QUICK, *NEW, "garmentq run scan.ply --out result"}
    assert {line for line in shown if line.split()[1] not in ELSEWHERE} <= typed
