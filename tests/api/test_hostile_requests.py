"""Hostile files and requests: each is refused with a stable code, in time, and nothing else happens."""

from __future__ import annotations

import http.client
import os
import socket
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import httpx
import pytest
from api_client import LIMITS, local_user, serving
from api_work import ask, code_of, finish, make_key, make_ply, upload
from bad_files import FILES, PICKLES
from garmentq.service.api.server import AddressPublic, serve
from garmentq.service.settings import CHECKER
from garmentq.workers.recovery import run_job


@pytest.mark.slow
@pytest.mark.parametrize("share", [4, pytest.param(1, marks=pytest.mark.nightly)])
def test_bad_files_are_refused(client, settings, database, tmp_path, monkeypatch, share):
    """Broken where a bad file is parsed by the API, becomes a result or a fault, or leaves something behind."""
    monkeypatch.chdir(tmp_path)
    body = upload(client, -0.5, "bodies", "body.ply")
    strict = replace(settings, checker=CHECKER)

    def refuse(name, **wanted):
        answer = client.post("/v1/jobs", json=wanted)
        assert answer.status_code == 202, (name, answer.text)
        assert run_job(strict, database, answer.json()["job"], lambda: False) == "failed", name
        shown = client.get(f"/v1/jobs/{answer.json()['job']}")
        found = shown.json()
        assert found["bad_input"] and found["stage"] == "check", (name, found)
        assert found["error"]["code"].startswith(("scan.", "body.")), (name, found)
        assert str(settings.home) not in shown.text and "Traceback" not in shown.text, name

    for name, content in list(FILES.items())[::share]:
        answer = client.post("/v1/scans", params={"name": name}, content=content)
        if answer.status_code == 201:
            refuse(name, scan=answer.json()["sha256"], body=body)
        else:
            assert answer.status_code == 422 and code_of(answer).startswith(("scan.", "upload.")), (name, answer.text)
    scan = client.post("/v1/scans", params={"name": "good.ply"}, content=make_ply()).json()["sha256"]
    for name, content in PICKLES.items():
        labels = client.post("/v1/labels", params={"name": name}, content=content).json()["sha256"]
        refuse(name, scan=scan, labels=labels, settings={"keep": "1"})
        assert not (tmp_path / "pickled").exists(), name
    models = {name: content for name, content in PICKLES.items() if name.endswith(".npz")}
    for name, content in (models | {"old.json": b'{"age": 7}', "deep.json": b'{"a":' * 9000}).items():
        given = client.post("/v1/bodies", params={"name": name}, content=content).json()["sha256"]
        refuse(name, scan=scan, body=given)
        assert not (tmp_path / "pickled").exists(), name
    assert list((settings.home / "incoming").iterdir()) == [] and list((settings.home / "work").iterdir()) == []
    assert client.get("/healthz").status_code == 200


def test_the_api_never_loads_a_reader(settings):
    """Broken where handling uploads, jobs or templates brings a mesh library into the API's process."""
    script = """
import sys
from pathlib import Path
from starlette.testclient import TestClient
from api_work import ask, upload
from garmentq.core.garment.garmentcode import save_pattern
from garmentq.core.garment.templates import load_template
from garmentq.service.api.app import make_app
from garmentq_home import make_settings
home = Path(sys.argv[1])
save_pattern(load_template("skirt"), home / "t.json")
app = make_app(make_settings(home))
token = {"authorization": f"Bearer {app.state.rooms.local_token}"}
with TestClient(app, base_url="http://127.0.0.1", headers=token) as client:
    assert ask(client, template="skirt").status_code == 202
    labels = client.post("/v1/labels?name=l.npz", content=b"no labels").json()["sha256"]
    wanted = {"scan": upload(client), "labels": labels, "settings": {"keep": "1", "garment": "skirt"}}
    assert client.post("/v1/jobs", json=wanted).status_code == 202
    assert client.put("/v1/templates/mine", content=(home / "t.json").read_bytes()).status_code == 201
    bad = client.put("/v1/templates/bad", content=b"[" * 100000)
    assert bad.status_code == 422 and bad.json()["code"].startswith("pattern."), bad.text
sys.stdout.write(" ".join({"trimesh", "igl", "numba", "torch", "open3d"} & set(sys.modules)))
"""
    command = [sys.executable, "-W", "ignore", "-c", script, str(settings.home)]
    path = os.pathsep.join([str(Path(__file__).parent), *sys.path])
    done = subprocess.run(command, env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout == ""


def test_no_name_is_a_path(client, settings, database, store, tmp_path):
    """Broken where a name leads out of a folder: at upload, in a template's name, an id, or a file's name."""
    (tmp_path / "secret").write_text("secret")
    before = {path for path in tmp_path.rglob("*") if settings.home not in path.parents}
    for name in ("../../../etc/cron.d/x.ply", "/etc/x.ply", "..\\..\\x.ply", ".ply", "a\x00b.ply", "x" * 250 + ".ply"):
        answer = client.post("/v1/scans", params={"name": name}, content=make_ply())
        if answer.status_code == 201:
            assert "/" not in answer.json()["name"] and not answer.json()["name"].startswith(".")
        else:
            assert answer.status_code == 422, (name, answer.text)
    job = ask(client).json()["job"]
    finish(settings, database, store, job, settings.home / "made")
    for name in ("../../secret", "..%2f..%2fsecret", "/etc/passwd", "%2e%2e/secret", "pattern.svg/../../secret"):
        for path in (
            f"/v1/jobs/{job}/artifacts/{name}",
            f"/v1/templates/{name}",
            f"/v1/jobs/{name}",
            f"/v1/scans/{name}",
        ):
            connection = http.client.HTTPConnection(client.base_url.host, client.base_url.port, timeout=10)
            connection.request("GET", path, headers=local_user(settings))  # as it is: httpx would tidy the dots
            answer = connection.getresponse()
            text = answer.read()
            connection.close()
            assert answer.status in (404, 405, 422) and b"root:" not in text and b"secret" != text, path
    wanted = {"scan": upload(client), "body": "../../secret"}
    assert code_of(client.post("/v1/jobs", json=wanted)) == "request.bad"
    wanted = {"scan": upload(client), "body": "builtin:female,height=1.7", "template": "../../secret"}
    assert code_of(client.post("/v1/jobs", json=wanted)) == "request.bad"
    assert {path for path in tmp_path.rglob("*") if settings.home not in path.parents} == before


def test_a_link_in_the_store_is_not_followed_to_other_bytes(client, settings, database, store, tmp_path):
    """Broken where a file of the store that was replaced by a link is handed out."""
    job = ask(client).json()["job"]
    finish(settings, database, store, job, tmp_path / "out")
    file = client.get(f"/v1/jobs/{job}/artifacts").json()["files"][0]
    place = store.path(file["sha256"])
    place.unlink()
    place.symlink_to("/etc/passwd")
    answer = client.get(f"/v1/jobs/{job}/artifacts/{file['name']}")
    assert answer.status_code == 503 and code_of(answer) == "store.damaged"


def test_uploads_are_capped_while_they_stream(client, settings):
    """Broken where a body beyond the cap is taken, with or without its length, or a partial file stays."""
    big = b"x" * (LIMITS.upload_bytes + 1)
    told = client.post("/v1/scans", params={"name": "a.ply"}, content=big)
    assert (told.status_code, code_of(told)) == (413, "request.too_large")
    untold = client.post(
        "/v1/scans", params={"name": "a.ply"}, content=(big[i : i + 65536] for i in range(0, len(big), 65536))
    )
    assert (untold.status_code, code_of(untold)) == (413, "request.too_large")
    json_bomb = client.post("/v1/jobs", content=b"[" * 100_000, headers={"content-type": "application/json"})
    assert json_bomb.status_code == 413
    deep = client.post("/v1/jobs", content=b"[" * 60_000, headers={"content-type": "application/json"})
    assert 400 <= deep.status_code < 500, deep.text
    assert list((settings.home / "incoming").iterdir()) == []


def test_slow_and_vanished_clients(client, settings):
    """Broken where a client that falls silent holds a request, or one that leaves leaves its file."""
    key = local_user(settings)["authorization"].encode()
    head = b"POST /v1/scans?name=a.ply HTTP/1.1\r\nHost: 127.0.0.1\r\nAuthorization: " + key
    head += b"\r\nContent-Length: 1000\r\n\r\nply\n"
    place = (client.base_url.host, client.base_url.port)
    with socket.create_connection(place, timeout=10) as slow:
        slow.sendall(head)
        assert b" 408 " in slow.recv(4096)
    with socket.create_connection(place, timeout=10) as gone:
        gone.sendall(head)
    deadline = time.monotonic() + 5
    while list((settings.home / "incoming").iterdir()) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert list((settings.home / "incoming").iterdir()) == []
    assert client.get("/healthz").status_code == 200


def test_pages_of_others_cannot_ask(client):
    """Broken where a page in the user's browser can queue jobs in a service without keys."""
    for headers in ({"origin": "http://evil.example"}, {"host": "evil.example"}, {"origin": "null"}):
        answer = client.get("/v1/jobs", headers=headers)
        assert (answer.status_code, code_of(answer)) == (403, "request.foreign_origin"), headers
    assert client.get("/v1/jobs", headers={"origin": "http://localhost:3000"}).status_code == 200


def test_a_public_address_needs_a_key(settings, database):
    """Broken where a service without keys listens to everybody, or a revoked key counts."""
    with pytest.raises(AddressPublic):
        serve(settings, "0.0.0.0", 1)
    with serving(settings, is_open=False) as url:
        assert httpx.get(f"{url}/v1/jobs").status_code == 401
        header = make_key(database, "a")
        assert httpx.get(f"{url}/v1/jobs", headers=header).status_code == 200


def test_names_are_escaped_everywhere(client, cli, settings, database, store, tmp_path):
    """Broken where a name carries terminal escapes, HTML or a formula into a log, a page or a table."""
    evil = "=cmd|'/c calc'!A1<script>\x1b[31m\u202e.ply"
    scan = client.post("/v1/scans", params={"name": evil}, content=make_ply()).json()
    assert set(scan["name"]) <= set("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-")
    job = client.post(
        "/v1/jobs", json={"scan": scan["sha256"], "body": upload(client, -0.5, "bodies", "b.ply")}
    ).json()["job"]
    answer = client.get("/v1/jobs/\x1b[31m<script>alert(1)</script>".replace("\x1b", "%1b"))
    assert answer.status_code == 404 and "\x1b" not in answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    assert answer.headers["x-content-type-options"] == "nosniff"
    finish(settings, database, store, job, tmp_path / "out")
    svg = client.get(f"/v1/jobs/{job}/artifacts/pattern.svg")
    assert svg.headers["content-type"] == "image/svg+xml" and svg.headers["x-content-type-options"] == "nosniff"
    assert "default-src 'none'" in svg.headers["content-security-policy"]
    assert svg.headers["content-disposition"].startswith("attachment")
    for words in (("status",), ("query", "--csv"), ("logs", job)):
        shown = cli(*words).stdout
        assert "\x1b" not in shown and "<script>" not in shown
        assert not any(cell.startswith(("=", "+", "@")) for line in shown.splitlines() for cell in line.split(","))


def test_streams_are_counted(client, database):
    """Broken where one key can hold any number of event streams."""
    job = ask(client).json()["job"]
    headers = {"accept": "text/event-stream"}
    with client.stream("GET", f"/v1/jobs/{job}/events", headers=headers) as one:
        first = one.iter_lines()  # held: a stream whose iterator is dropped is closed
        next(first)
        with client.stream("GET", f"/v1/jobs/{job}/events", headers=headers) as two:
            second = two.iter_lines()
            next(second)
            third = client.get(f"/v1/jobs/{job}/events", headers=headers)
            assert (third.status_code, code_of(third)) == (429, "request.streams_full")


def test_a_full_disk_is_507(client, settings, monkeypatch):
    """Broken where a disk without room is a fault, or leaves half a file."""

    def full(descriptor):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    answer = client.post("/v1/scans", params={"name": "a.ply"}, content=make_ply(0.7))
    assert (answer.status_code, code_of(answer)) == (507, "store.full")
    assert list((settings.home / "incoming").iterdir()) == []
