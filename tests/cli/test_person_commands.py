"""A whole person on the command line, of a home and of a service: what its scan is taken for, what is said of it."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from garmentq.cli.order import split_choice, split_lists
from garmentq.core.body.builtin import builtin_body
from garmentq.core.recover.settings import SettingsBad
from garmentq.service.jobs import find_job
from garmentq_family_home import pieces, work_off
from garmentq_home import put_file

sys.path.insert(0, str(Path(__file__).parents[1] / "api"))

from api_client import serving

PERSONS = {"separator": "garmentq_person:take_apart", "person_checker": "garmentq_checker:check"}


@pytest.fixture(params=["home", "service"])
def ask(request, cli, settings):
    """Return a function that runs one command, on the home or by way of a service."""
    if request.param == "home":
        yield cli
        return
    with serving(settings) as address:
        yield lambda *words, **more: cli(*words, GARMENTQ_URL=address, **more)


@pytest.fixture
def work(settings, database):
    """Return a function that works off what is queued, with persons taken apart at once."""
    return lambda: work_off(replace(settings, **PERSONS), database)


def read_rows(done) -> list[dict]:
    """Return the objects that a command printed."""
    return [json.loads(line) for line in done.stdout.splitlines()]


def test_what_a_scan_is_taken_for(cli, database, tmp_path):
    """Breaks where an option turns a person into a garment or back, or nobody is told."""
    scan = put_file(tmp_path, "scan.ply")
    for words, kind, said in (
        ("", "person", "whole person"),
        ("--as person --body builtin:female", "person", "whole person"),
        ("--body builtin:female", "recover", "unless it shows head, hands or feet"),
        ("--as garment --body builtin:female", "recover", "treated as a garment"),
        ("--keep 1", "recover", "one garment"),
        ("--keep-colour #465faa", "recover", "one garment"),
        ("--wearing upper", "person", "whole person"),
        ("--mark upper=0,1,0", "person", "whole person"),
        ("--fabric upper:denim", "person", "whole person"),
        ("--fabric denim --body builtin:female", "recover", "unless"),
    ):
        done = cli("submit", scan, "--no-check", *words.split())
        assert done.returncode == 0, (words, done.stderr)
        assert find_job(database, done.stdout.split()[0]).kind == kind and said in done.stdout, words
    (row,) = read_rows(cli("submit", scan, "--json"))
    assert "whole person" in row["taken_as"]


def test_what_cannot_be_meant_of_a_person(cli, tmp_path):
    """Breaks where a misspelt choice is queued, or is a traceback."""
    scan = put_file(tmp_path, "scan.ply")
    for words, status, code in (
        ("--as person --keep 1", 2, "settings.bad"),
        ("--as garment", 4, "body.missing"),
        ("--as garment --body builtin:female --wearing upper", 2, "settings.bad"),
        ("--wearing hat", 4, "segment.hint_bad"),
        ("--mark upper=1,2", 4, "segment.hint_bad"),
        ("--fabric upper:nosuch", 3, "fabric.unknown"),
        ("--garment lower:hat", 2, "settings.bad"),
        ("--lock lower:hat", 2, "settings.bad"),
        ("--template lower:nosuch", 3, "template.unknown"),
        ("--template a --template b", 2, "settings.bad"),
        ("--fabric upper:denim --fabric upper:denim", 2, "settings.bad"),
    ):
        done = cli("submit", scan, *words.split())
        told = done.stdout + done.stderr
        assert done.returncode == status and f"{code}: " in told and told.count("\n") == 1, (words, told)


def test_all_garments_of_a_person(ask, work, database, tmp_path):
    """Breaks where a choice is lost on its way, a garment's files lie elsewhere, or a wait ends with the parent."""
    (tmp_path / "base.json").write_text((Path(__file__).parents[2] / "core/garment/library/skirt.json").read_text())
    words = ("--fabric", "upper:denim", "--template", f"lower:{tmp_path / 'base.json'}", "--garment", "lower:skirt")
    words += ("--template", "upper:tshirt", "--lock", "fabric", "--lock", "upper:panel:front", "--mark", "upper=0,1,0")
    words += ("--part", "neckline=crew,sleeve=cap", "--part", "upper:neckline=v")
    scan = put_file(tmp_path, "anna.ply")
    done = ask("submit", scan, *words, "--tag", "spring")
    assert done.returncode == 0, done.stderr
    root = done.stdout.split()[0]
    request = find_job(database, root).request
    assert request["choices"]["lower"]["template"]["name"] == "base.json" and request["marks"] == ["upper=0,1,0"]
    work()
    found = pieces(database, root)
    assert {word: row.state for word, row in found.items()} == {"upper": "succeeded", "lower": "succeeded"}
    chosen = {word: row.request["settings"] for word, row in found.items()}
    assert (chosen["upper"]["fabric"], chosen["upper"]["template"]) == ("denim", "tshirt")
    assert (chosen["lower"]["fabric"], chosen["lower"]["template"]) == (None, "base")
    assert (chosen["upper"]["lock"], chosen["lower"]["lock"]) == ("panel:front", "fabric")
    parts = ("sleeve=cap,neckline=v", "neckline=crew,sleeve=cap")
    assert (chosen["upper"]["parts"], chosen["lower"]["parts"]) == parts
    out = tmp_path / "out"
    done = ask("run", scan, *words, "--out", out)
    assert done.returncode == 0, done.stderr
    for name in ("report.html", "labels.npz", "upper/metrics.txt", "lower/metrics.txt", "upper/reading.npz"):
        assert (out / name).is_file(), name
    lines = done.stdout.splitlines()
    assert len(lines) == 30 and lines[3].split() == "wears upper and lower (95 %); or one-piece (5 %)".split()
    shown = ask("result", root)
    assert shown.returncode == 0 and "0.97" in shown.stdout
    rows = read_rows(ask("query", "--family", root, "--json"))
    assert {row["name"] for row in rows} == {"anna", "upper", "lower"}
    assert all(row["tags"] == ["spring"] for row in rows)
    assert [row["job"] for row in read_rows(ask("query", "--where", "confidence.upper > 0.9", "--json"))] == [root]
    done = ask("export", "--tag", "spring", "--out", out / "march")
    assert done.returncode == 0, done.stderr
    folders = {path.name for path in (out / "march").iterdir()}
    assert folders == {"anna_tshirt", "anna_tshirt_lower"} or folders == {"anna_tshirt", "anna_tshirt_upper"}
    assert (out / "march" / "anna_tshirt" / "metrics.txt").is_file()
    named = ask("export", "metrics.txt", "--family", root, "--out", out / "named")
    assert (out / "named" / "anna_tshirt" / "anna_tshirt_metrics.txt").is_file() and named.returncode == 0, named.stderr
    assert ask("subjects", "add", "Nobody", root).returncode == 3
    assert ask("subjects", "create", "Anna M\u00fcller").returncode == 0
    assert ask("subjects", "add", "Anna M\u00fcller", root).returncode == 0
    assert ask("export", "--subject", "Anna M\u00fcller", "--out", out / "anna").returncode == 0
    assert (out / "anna" / "Anna_Mueller_tshirt" / "metrics.txt").is_file()
    told = ask("status", "--tag", "spring").stdout
    assert told.startswith("spring: 3 jobs of 1 scans: 3 done; 100 %")
    assert ask("export", "--tag", "nosuch", "--out", out).returncode == 0
    assert ask("export", "--out", out).returncode == ask("export", root, "--tag", "spring").returncode == 2
    nothing = ask("query", "--name", "nobody")
    assert nothing.returncode == 0 and "no job matches" in nothing.stderr + nothing.stdout


def test_a_doubtful_person_is_brought_out(ask, work, tmp_path):
    """Breaks where labels and report of a doubtful person cannot be had, or its status is that of success."""
    scan, out = put_file(tmp_path, "unsure.ply"), tmp_path / "out"
    root = ask("submit", scan).stdout.split()[0]
    work()
    shown = ask("result", root)
    assert shown.returncode == 4 and "error segment.unsure" in shown.stderr
    assert f"garmentq export {root}" in shown.stdout
    assert ask("export", root, "labels.npz", "--out", out).returncode == 0 and (out / "labels.npz").is_file()
    (row,) = read_rows(ask("result", root, "--json"))
    assert row["state"] == "failed" and {file["name"] for file in row["files"]} >= {"labels.npz", "report.html"}


def test_parts_in_front(tmp_path):
    """Breaks where a lock's own colon is taken for a part's, or what comes twice passes."""
    assert split_choice("fabric", ("denim", "upper:linen")) == ("denim", {"upper": "linen"})
    assert split_choice("template", ("a:b", "one-piece:x:y")) == ("a:b", {"one-piece": "x:y"})
    assert split_lists(("panel:front", "upper:panel:a", "upper:fabric")) == {
        "": "panel:front", "upper": "panel:a,fabric"
    }  # fmt: skip
    with pytest.raises(SettingsBad):
        split_choice("fabric", ("a", "b"))


@pytest.mark.parametrize(
    ("name", "said", "what"),
    [
        ("whole", (), "person"),
        pytest.param("suit", (), "garment", marks=pytest.mark.nightly),
        pytest.param("suit", ("--as", "garment"), "garment", marks=pytest.mark.nightly),
    ],
)
def test_inspect_says_what_a_file_is(cli, tmp_path, monkeypatch, name, said, what):
    """Breaks where a whole person on a body is shown as a garment, or a suit from neck to ankles as a person."""
    monkeypatch.setattr("garmentq.service.inspect_scan.inspect_person", lambda *_: {"as": "person"})
    wearer = "builtin:female,height=1.70"
    body = builtin_body(wearer)
    corners = body.vertices[body.faces]
    is_suit = (corners[..., 1].max(axis=1) < body.joint("neck")[1]) & (np.abs(corners[..., 0]).max(axis=1) < 0.6)
    is_suit &= corners[..., 1].min(axis=1) > body.joint("left_ankle")[1]
    mesh = trimesh.Trimesh(body.vertices, body.faces if name == "whole" else body.faces[is_suit], process=False)
    mesh.remove_unreferenced_vertices()
    mesh.export(tmp_path / f"{name}.ply")
    done = cli("inspect", tmp_path / f"{name}.ply", "--body", wearer, *said, "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["as"] == what
