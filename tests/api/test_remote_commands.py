"""Every command says the same of a service as of a home, with the same exit statuses."""

from __future__ import annotations

import json

import pytest
from api_client import serving
from api_work import finish, make_ply
from garmentq.cli.live import follow_batch
from garmentq.cli.main import COMMANDS, LOCAL_COMMANDS
from garmentq.core.garment.templates import list_templates
from garmentq.core.run.errors import NotFound
from garmentq.service.connection import Connection
from garmentq.service.jobs import claim, fail
from garmentq.service.keys import create_key
from garmentq.service.local_token import make_local_token
from garmentq.service.remote import RemoteBackend
from garmentq.service.submission import Order
from garmentq_standin import make_recovery  # noqa: F401


@pytest.fixture
def remote(cli, address):
    """Return a function that runs one command on the served home."""
    return lambda *words, **more: cli(*words, GARMENTQ_URL=address, **more)


@pytest.fixture
def files(tmp_path):
    """Write scan, body and a broken file."""
    (tmp_path / "skirt.ply").write_bytes(make_ply())
    (tmp_path / "body.ply").write_bytes(make_ply(-0.5))
    (tmp_path / "broken.ply").write_text("no mesh")
    return tmp_path


def test_the_same_words_and_statuses(cli, remote, files, settings, database, store):
    """Broken where a command works otherwise on a service: other output, other status, or local state is touched."""
    asked = remote("submit", files / "skirt.ply", "--body", files / "body.ply")
    assert asked.returncode == 0, asked.stderr
    job = asked.stdout.split()[0]
    assert cli("submit", files / "skirt.ply", "--body", files / "body.ply").stdout.split()[0] == job
    finish(settings, database, store, job, files / "made")
    for words in (
        ("status", "--json"), ("status", job), ("status", job[:5]), ("logs", job, "--json"), ("logs", "-f", job),
        ("result", job), ("result", job, "--json"), ("query", "--json"), ("query", "--where", "surface_rms_mm.t2s < 9"),
        ("query", "--csv"), ("query", "--where", "nosuch < 1"), ("query", "--where", "drop table"),
        ("materials",), ("materials", "denim"), ("materials", "denim", "--json"), ("materials", "nosuch"),
        ("status", "--watch"), ("keys", "list"), ("bodies", "list"), ("keys", "revoke", "nosuch"),
        ("templates", "list"), ("templates", "show", "skirt"), ("templates", "show", "nosuch"), ("materials", "--json"),
        ("status", "nosuchjob"), ("export", job, "nosuch"), ("cancel", job), ("cancel", "nosuchjob"),
        ("submit", files / "broken.ply", "--body", files / "body.ply"),
        ("submit", files / "skirt.ply"),
        ("submit", files / "skirt.ply", "--body", files / "body.ply", "--fabric", "nosuch"),
        ("submit", files / "skirt.ply", "--body", files / "body.ply", "--template", "nosuch"),
    ):  # fmt: skip
        here, there = cli(*words), remote(*words)
        assert (here.returncode, here.stdout) == (there.returncode, there.stdout), (words, there.stderr)
        assert here.stderr == there.stderr, words
    here, there = cli("export", job, "-o", files / "a"), remote("export", job, "-o", files / "b")
    assert here.returncode == there.returncode == 0
    assert {p.name: p.read_bytes() for p in (files / "a").iterdir()} == {
        p.name: p.read_bytes() for p in (files / "b").iterdir()
    }
    done = remote("run", files / "skirt.ply", "--body", files / "body.ply", "--json", "--out", files / "c")
    assert done.returncode == 0 and json.loads(done.stdout)["job"] == job
    assert (files / "c" / "pattern.svg").read_bytes() == (files / "made" / "pattern.svg").read_bytes()


def test_ended_badly(remote, cli, files, database):
    """Broken where a failed job's status, a retry or a running job differs by way of asking."""
    job = remote("submit", files / "skirt.ply", "--body", files / "body.ply").stdout.split()[0]
    assert (
        remote("result", job).returncode == 3 and remote("retry", job).returncode == cli("retry", job).returncode == 4
    )
    fail(database, claim(database, job, "test", 60.0), "scan.x", "bad", bad_input=True)
    assert remote("result", job).returncode == cli("result", job).returncode == 4
    assert remote("retry", job).returncode == 0 and remote("cancel", job, "--json").stdout
    assert remote("result", job).returncode == 7
    waited = remote("submit", files / "skirt.ply", "--body", files / "body.ply", "--wait", "--timeout", "0.1")
    assert waited.returncode == 8


def test_templates_go_over(remote, cli, files, address):
    """Broken where an imported template is another one on the other side, or a job cannot use it."""
    name = list_templates()[0].name
    assert remote("templates", "export", name, "-o", files / "t.json").returncode == 0
    assert remote("templates", "import", files / "t.json", "--name", "mine").returncode == 0
    assert remote("templates", "show", "mine").stdout == cli("templates", "show", "mine").stdout
    for template in ("mine", files / "t.json", name):
        done = remote("submit", files / "skirt.ply", "--body", files / "body.ply", "--template", template)
        assert done.returncode == 0, done.stderr
        again = cli("submit", files / "skirt.ply", "--body", files / "body.ply", "--template", template)
        assert again.stdout == done.stdout, template


def test_every_command_works_or_says_why_not(remote, cli, settings):
    """Broken where a command ignores GARMENTQ_URL and works on a home of this machine instead, or hides its help."""
    asked = {
        "run", "submit", "status", "logs", "result", "export", "query", "cancel", "retry", "priority", "templates",
        "materials",
        "keys", "doctor", "dress", "refit", "refine", "edit", "animate", "match", "sizes", "measure", "webhooks",
            "share", "rename", "subjects",
    }  # fmt: skip
    files_only = {"inspect", "segment", "bodies", "bench", "completion", "man"}  # of this machine, as they are
    assert asked | files_only | set(LOCAL_COMMANDS) == set(COMMANDS) and not (asked | files_only) & set(LOCAL_COMMANDS)
    words = {
        "db": ["db", "upgrade"],
        "backup": ["backup", "x.tar"],
        "archive": ["archive", "x.tar"],
        "restore": ["restore", "x.tar"],
    }
    before = sorted(settings.home.rglob("*"))
    for name in LOCAL_COMMANDS:
        done = remote(*words.get(name, [name]))
        assert done.returncode == 2 and done.stdout == "", (name, done)
        assert done.stderr.startswith("error command.local_only: ") and len(done.stderr.splitlines()) == 1, name
        assert remote(name, "--help").stdout == cli(name, "--help").stdout
    assert [path for path in sorted(settings.home.rglob("*")) if path not in before] == []
    checks = {row["check"]: row for row in map(json.loads, remote("doctor", "--json").stdout.splitlines())}
    assert checks["service"]["ok"] and checks["queue"]["ok"] and "database" not in checks
    away = cli("doctor", "--json", GARMENTQ_URL="http://x:secret@127.0.0.1:1")
    assert away.returncode == 1 and "service.unreachable" in away.stdout and "secret" not in away.stdout + away.stderr


def test_keys_are_made_over_there(remote, cli, settings, database):
    """Broken where a key made by way of the service is another than one made at its home."""
    _, admin = create_key(database, "admin", ("admin",))
    as_admin = {"GARMENTQ_API_KEY": admin}
    made = json.loads(remote("keys", "create", "atelier", "--quota", "7", "--json", **as_admin).stdout)
    assert (made["scopes"], made["quota"]) == (["read", "submit"], 7)
    rows = [json.loads(line) for line in remote("keys", "list", "--json", **as_admin).stdout.splitlines()]
    assert rows == [json.loads(line) for line in cli("keys", "list", "--json").stdout.splitlines()]
    assert remote("status", GARMENTQ_API_KEY=made["token"]).returncode == 0
    refused = remote("keys", "list", GARMENTQ_API_KEY=made["token"])
    assert refused.returncode == 1 and refused.stderr.startswith("error key.scope_missing")
    rotated = remote("keys", "rotate", made["key"], "--hours", "1", **as_admin)
    assert rotated.returncode == 0 and rotated.stdout.startswith("gq_") and "token" in rotated.stderr
    assert remote("keys", "revoke", made["key"], **as_admin).returncode == 0
    assert "key.bad" in remote("status", GARMENTQ_API_KEY=made["token"]).stderr


def test_a_batch_is_one_question(remote, files, settings, database, store, address, monkeypatch):
    """Broken where waiting for a batch asks for each job by itself, or goes on asking for those that have ended."""
    scans = []
    for index in range(12):
        scans.append(files / f"skirt{index}.ply")
        scans[-1].write_bytes(make_ply(0.01 * index))
    asked = remote("submit", *scans, "--body", files / "body.ply")
    jobs = [line.split()[0] for line in asked.stdout.splitlines()]
    assert len(set(jobs)) == 12
    sent = []
    ask_really = Connection.request

    def ask(self, method, url, *rest, **options):
        sent.append((method, url, len(options.get("json", {}).get("jobs", ()))))
        if len(sent) == 2:
            for job in jobs[:11]:
                finish(settings, database, store, job, files / f"made-{job}")
        if len(sent) == 4:
            fail(database, claim(database, jobs[11], "test", 60.0), "scan.x", "bad", bad_input=True)
        return ask_really(self, method, url, *rest, **options)

    monkeypatch.setattr(Connection, "request", ask)
    with RemoteBackend(address, make_local_token(settings.home)) as client:
        rows = follow_batch(client, jobs, 60.0)
    assert [row.id for row in rows] == jobs and {row.state for row in rows[:11]} == {"succeeded"}
    assert (rows[11].state, rows[11].error.code, rows[11].bad_input) == ("failed", "scan.x", True)
    assert {(method, url) for method, url, _ in sent} == {("POST", "/v1/jobs/states")}
    assert [count for _, _, count in sent][:3] == [12, 12, 1] and len(sent) <= 5
    with RemoteBackend(address, make_local_token(settings.home)) as client, pytest.raises(NotFound):
        client.find_jobs_by_id([jobs[0], "0" * 12])


def test_keys_by_command(cli, files, settings):
    """Broken where a key made by the command does not open, or a revoked one still does."""
    made = json.loads(cli("keys", "create", "atelier", "--json").stdout)
    with serving(settings, is_open=False) as url:
        bare = cli("status", GARMENTQ_URL=url)
        assert bare.returncode == 1 and bare.stderr.startswith("error key.missing")
        assert cli("status", GARMENTQ_URL=url, GARMENTQ_API_KEY=made["token"]).returncode == 0
        assert "token" not in cli("keys", "list", "--json").stdout
        assert cli("keys", "revoke", made["key"]).returncode == 0
        assert "key.bad" in cli("status", GARMENTQ_URL=url, GARMENTQ_API_KEY=made["token"]).stderr
    assert cli("keys", "revoke", "nosuch").returncode == 3
    assert cli("serve", "--host", "0.0.0.0", "--port", "1").returncode == 4


def test_an_unreachable_service_is_status_9(cli):
    """Broken where a script cannot tell a missing service from a bad file."""
    for url in ("http://127.0.0.1:1", "nonsense", "http://"):
        done = cli("status", GARMENTQ_URL=url)
        assert done.returncode == 9 and done.stderr.startswith("error service."), (url, done)
        assert len(done.stderr.splitlines()) == 1


def test_the_client_follows_a_job(address, settings, database, store, files):
    """Broken where the typed client loses events, or a forced job is doubled by a repeated request."""
    with RemoteBackend(address, make_local_token(settings.home)) as client:
        order = Order(files / "skirt.ply", files / "body.ply")
        job = client.submit(order).job
        finish(settings, database, store, job, files / "made")
        assert [event.kind for event in client.follow(job)] == ["queued", "started", "succeeded"]
        assert client.find_job(job).garment == "skirt"
        with pytest.raises(NotFound) as error:
            client.find_job("abcdef")
        assert error.value.code == "job.unknown"
    _, token = create_key(database, "x", ("read",))
    with RemoteBackend(address, token) as client, pytest.raises(Exception, match="scope"):
        client.submit(order)
