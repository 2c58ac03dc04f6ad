"""Families on the command line, of a home and of a service: whoever asks for a job is told of all below it."""

from __future__ import annotations

import json

import pytest
from api_work import finish, make_ply
from garmentq.cli.family import arrange
from garmentq.cli.live import follow_batch
from garmentq.service.families import make_children, release_waiting_jobs
from garmentq.service.jobs import claim, fail, find_job
from garmentq.service.kinds.kind import ChildRequest
from garmentq.service.local import LocalBackend

NAME, SLEEVE = "Fr\u00fchling \u6625", "\u00c4rmel"


@pytest.fixture(params=["home", "service"])
def ask(request, cli):
    """Return a function that runs one command, on the home or by way of a service."""
    if request.param == "home":
        return cli
    address = request.getfixturevalue("address")
    return lambda *words, **more: cli(*words, GARMENTQ_URL=address, **more)


@pytest.fixture
def files(tmp_path):
    """Write scan and body."""
    (tmp_path / "skirt.ply").write_bytes(make_ply())
    (tmp_path / "body.ply").write_bytes(make_ply(-0.5))
    return tmp_path


@pytest.fixture
def family(cli, files, settings, database, store):
    """Return a job that succeeded, and the two jobs that it made; the second waits for the first."""
    done = cli("submit", files / "skirt.ply", "--body", files / "body.ply", "--name", NAME, "--tag", "spring")
    root = done.stdout.split()[0]
    assert done.returncode == 0, done.stderr
    finish(settings, database, store, root, files / "made")
    request = find_job(database, root).request
    with database.write() as session:
        hem = ChildRequest("hem", "recover", request, (SLEEVE,))
        made = make_children(session, root, [ChildRequest(SLEEVE, "recover", request), hem])
    return root, made[SLEEVE], made["hem"]


def rows_of(done) -> list[dict]:
    """Return the objects that a command printed."""
    assert done.returncode in (0, 5, 7), done
    return [json.loads(line) for line in done.stdout.splitlines()]


def test_children_stand_under_their_parent(ask, family):
    """Breaks where a child is told as a job of its own, a name loses its letters, or a question misses the family."""
    root, sleeve, hem = family
    for words in (("status",), ("status", root)):
        lines = ask(*words).stdout.splitlines()
        places = [next(i for i, line in enumerate(lines) if job in line) for job in family]
        assert places == list(range(places[0], places[0] + 3)), words
        assert NAME in lines[places[0]] and "  \u00c4rmel" in lines[places[1]] and "  hem" in lines[places[2]]
    assert [row["job"] for row in rows_of(ask("status", root, "--json"))] == [root, sleeve, hem]
    assert [row["job"] for row in rows_of(ask("status", hem, "--json"))] == [hem]
    shown = rows_of(ask("status", root, "--json"))
    assert [row["state"] for row in shown] == ["succeeded", "queued", "waiting"]
    assert shown[2]["waits"] == [sleeve] and shown[1]["parent"] == root and shown[1]["tags"] == ["spring"]
    for words, found in (
        (("--family", root), {root, sleeve, hem}), (("--tag", "spring"), {root, sleeve, hem}),
        (("--name", NAME), {root}), (("--kind", "recover", "--state", "waiting"), {hem}),
        (("--tag", "autumn"), set()), (("--where", f"parent = {root}"), {sleeve, hem}),
    ):  # fmt: skip
        assert {row["job"] for row in rows_of(ask("query", *words, "--json"))} == found, words


def test_a_family_stops_and_goes_on_together(ask, family, database):
    """Breaks where a command on a parent says nothing of its children, or runs again what succeeded."""
    root, sleeve, hem = family
    stopped = rows_of(ask("cancel", root, "--json"))
    assert [(row["job"], row["state"]) for row in stopped] == [
        (root, "succeeded"), (sleeve, "cancelled"), (hem, "cancelled")
    ]  # fmt: skip
    assert ask("result", root).returncode == 7
    again = rows_of(ask("retry", root, "--json"))
    assert [row["state"] for row in again] == ["succeeded", "queued", "waiting"]
    assert "result.missing" in ask("result", root).stderr and ask("result", root).returncode == 3


def test_who_waits_waits_for_all(ask, family, files, settings, database, store):
    """Breaks where a wait ends with the parent, a child's files are not brought out, or its failure is lost."""
    root, sleeve, hem = family
    words = ("submit", files / "skirt.ply", "--body", files / "body.ply", "--wait", "--timeout", "0.1")
    assert ask(*words).returncode == 8
    finish(settings, database, store, sleeve, files / "sleeve")
    assert release_waiting_jobs(database) == 1
    fail(database, claim(database, hem, "test", 60.0), "cloth.x", "torn", bad_input=False)
    assert ask(*words).returncode == 5
    rows = follow_batch(LocalBackend(settings), [root], 60.0)
    assert [row.id for row in rows] == [root, sleeve, hem]
    followed = ask("logs", "-f", root)
    assert followed.returncode == 0 and "\u00c4rmel: " in followed.stdout and "hem: code=cloth.x" in followed.stdout
    assert {row["job"] for row in rows_of(ask("logs", root, "--json"))} == {root, sleeve, hem}
    done = ask("run", files / "skirt.ply", "--body", files / "body.ply", "--out", files / "out", "--json")
    assert done.returncode == 5 and "cloth.x" in done.stderr
    assert [row["job"] for row in rows_of(done)] == [root, sleeve, hem]
    assert (files / "out" / "pattern.svg").is_file() and (files / "out" / "\u00c4rmel" / "pattern.svg").is_file()
    assert [row["job"] for row in rows_of(ask("result", root, "--json"))] == [root, sleeve, hem]


def test_the_order_of_a_family(family, settings):
    """Breaks where a job whose parent is not listed is lost, or a root is moved by its children."""
    root, sleeve, hem = LocalBackend(settings).find_jobs_by_id(family)
    assert [(depth, job.id) for depth, job in arrange([hem, sleeve, root])] == [
        (0, root.id), (1, sleeve.id), (1, hem.id)
    ]  # fmt: skip
    assert [(depth, job.id) for depth, job in arrange([hem, sleeve])] == [(0, hem.id), (0, sleeve.id)]
    assert arrange([]) == []
