"""Who comes in, how many at a time, and what is known of it afterwards."""

from __future__ import annotations

import io
import json
import logging
import re
import socket
import struct
import threading
import time
import zipfile
from contextlib import ExitStack, contextmanager
from functools import partial

import httpx
import pytest
import uvicorn
from api_client import LIMITS, local_user, serving
from api_work import ask, code_of, finish, make_key, make_ply, upload
from garmentq.service.api.app import make_app, read_origins
from garmentq.service.api.connections import make_protocol
from garmentq.service.api.limits import ApiLimits
from garmentq.service.api.meter import Meter, TooManyRequests
from garmentq.service.audit import list_accesses
from garmentq.service.jobs import claim, find_job
from garmentq.service.keys import KeyBad, authenticate_token, create_key
from garmentq.service.logs import JsonLines
from garmentq.service.models import ApiKeyRow, UploadRow
from garmentq.service.settings import ServiceSettingBad
from garmentq_home import wait_for

QUICK = ApiLimits(head_seconds=1.0, connections_per_address=40)


@contextmanager
def guarded(settings, limits):
    """Serve a home as `garmentq serve` does: with its protocol and its limit of connections."""
    app = make_app(settings, limits)
    options = uvicorn.Config(
        app, host="127.0.0.1", port=0, log_level="critical", http=make_protocol(limits), limit_concurrency=60,
        timeout_graceful_shutdown=1,
    )  # fmt: skip
    server = uvicorn.Server(options)
    thread = threading.Thread(target=server.run, daemon=True)
    thread.start()
    try:
        wait_for(lambda: server.started)
        yield server.servers[0].sockets[0].getsockname()
    finally:
        server.should_exit = True
        thread.join(10)
        app.state.rooms.database.dispose()


def connect(stack, place, count):
    """Open connections from another address of this machine."""
    opened = []
    for _ in range(count):
        one = stack.enter_context(socket.socket())
        one.bind(("127.0.0.2", 0))
        one.connect(place)
        one.setblocking(False)
        opened.append(one)
    return opened


def is_closed(one):
    """Return whether the other side has closed a connection."""
    try:
        return one.recv(4096) == b""
    except BlockingIOError:
        return False
    except OSError:
        return True


def test_silent_connections_shut_nobody_out(settings):
    """Broken where one address can hold every connection, or hold one for ever by a byte now and then."""
    with guarded(settings, QUICK) as place, ExitStack() as stack:
        silent = connect(stack, place, 300)
        for _ in range(3):
            answer = httpx.get(f"http://127.0.0.1:{place[1]}/healthz", timeout=10)
            assert answer.status_code == 200
        wait_for(lambda: all(is_closed(one) for one in silent))
        [drip] = connect(stack, place, 1)
        deadline = time.monotonic() + 30.0
        while not is_closed(drip):
            assert time.monotonic() < deadline, "a head that drips in must have an end"
            try:
                drip.send(b"G")
            except OSError:
                break
            time.sleep(0.1)
        with httpx.Client(base_url=f"http://127.0.0.1:{place[1]}") as client:
            for _ in range(5):
                assert client.get("/healthz").status_code == 200, "one connection, many requests"


def test_the_local_user_shows_that_the_home_is_his(settings, address, cli):
    """Broken where any user of the machine is admin of a service without keys."""
    for headers in ({}, {"authorization": "Bearer gq_local_guess"}):
        for method, path in (("GET", "/v1/jobs"), ("POST", "/v1/keys"), ("DELETE", "/v1/keys/x"), ("GET", "/metrics")):
            answer = httpx.request(method, address + path, headers=headers)
            assert answer.status_code == 401 and code_of(answer).startswith("key."), (method, path)
    token = settings.home / "api.token"
    assert token.stat().st_mode & 0o077 == 0
    assert httpx.get(f"{address}/v1/keys", headers=local_user(settings)).status_code == 200
    assert cli("status", GARMENTQ_URL=address).returncode == 0, "a command of the home's own user finds the token"
    assert cli("keys", "create", "a", GARMENTQ_URL=address).returncode == 0
    assert code_of(httpx.get(f"{address}/v1/jobs", headers=local_user(settings))) == "key.bad"


def test_the_files_of_a_home_are_private(settings, database):
    """Broken where another user of the machine can read names, joints and hashes of keys."""
    from garmentq.service.database import open_database
    from garmentq_home import make_settings

    fresh = make_settings(settings.home / "fresh")
    open_database(fresh).dispose()
    assert (fresh.home / "garmentq.db").stat().st_mode & 0o077 == 0


def test_a_key_is_asked_for_before_a_body(client, settings, database):
    """Broken where a caller without a key holds a request by a body that it never ends."""
    place = (client.base_url.host, client.base_url.port)
    head = "POST /v1/jobs HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: application/json\r\nContent-Length: 1000\r\n\r\n"
    with socket.create_connection(place, timeout=10) as slow:
        slow.sendall(head.encode() + b" ")
        assert b" 401 " in slow.recv(4096)


@pytest.mark.parametrize(
    ("head", "status"),
    [
        ("Content-Length: 3\r\nTransfer-Encoding: chunked", 400),
        ("X-Long: " + "x" * 40_000, 431),
        ("Sec-Fetch-Site: cross-site", 403),
    ],
)
def test_heads_that_are_refused(client, head, status):
    """Broken where a head reads as two requests, is without end, or comes from another page."""
    with socket.create_connection((client.base_url.host, client.base_url.port), timeout=10) as opened:
        opened.sendall(f"POST /healthz HTTP/1.1\r\nHost: 127.0.0.1\r\n{head}\r\n\r\n3\r\nabc\r\n0\r\n\r\n".encode())
        assert f" {status} ".encode() in opened.recv(4096)


def test_wrong_keys_are_counted_by_address():
    """Broken where keys can be tried without end, or a stranger's tries shut out who comes by the same proxy."""
    now = [0.0]
    meter = Meter(ApiLimits(wrong_keys=3), lambda: now[0])
    meter.note_key("right")
    for _ in range(3):
        meter.check_address("10.0.0.1", "wrong")
        meter.note_wrong("10.0.0.1")
    with pytest.raises(TooManyRequests):
        meter.check_address("10.0.0.1", "wrong")
    meter.check_address("10.0.0.1", "right")
    meter.check_address("10.0.0.2", "wrong")
    now[0] += 11.0
    meter.check_address("10.0.0.1", "wrong")


def test_a_key_ends_and_its_use_is_known(database):
    """Broken where a key lives on beyond its end, or nobody can tell whether it is still used."""
    row, token = create_key(database, "guest", ("read",), days=1.0)
    assert row.expires > row.created and row.used is None
    authenticate_token(database, token)
    with database.write() as session:
        kept = session.get(ApiKeyRow, row.id)
        assert kept.used is not None
        kept.expires = 1.0
    with pytest.raises(KeyBad):
        authenticate_token(database, token)


def test_a_keys_highest_priority(client, database):
    """Broken where every key can put its jobs before all others."""
    plain, urgent = make_key(database, "plain"), create_key(database, "urgent", ("read", "submit"), priority=5)[1]
    refused = ask(client, 0.1, headers=plain, priority=1)
    assert (refused.status_code, code_of(refused)) == (403, "key.priority")
    assert ask(client, 0.1, headers=plain, priority=-3).status_code == 202
    headers = {"authorization": f"Bearer {urgent}"}
    assert ask(client, 0.2, headers=headers, priority=5).status_code == 202
    assert ask(client, 0.3, headers=headers, priority=6).status_code == 403
    job = ask(client, 0.2, headers=headers, priority=5).json()["job"]
    change = partial(client.patch, f"/v1/jobs/{job}")
    assert change(json={"priority": -2}, headers=headers).json()["priority"] == -2
    assert code_of(change(json={"priority": 6}, headers=headers)) == "key.priority"
    assert change(json={"priority": -3}, headers=plain).status_code == 404, "of another key"
    assert change(json={"priority": 101}, headers=headers).status_code == 422
    assert find_job(database, job).priority == -2


def test_an_upload_is_used_as_what_it_came_in_as(client, database):
    """Broken where a file that a route for labels took is read as a body."""
    labels = client.post("/v1/labels?name=body.npz", content=b"PK\3\4").json()["sha256"]
    wanted = {"scan": upload(client), "body": labels}
    refused = client.post("/v1/jobs", json=wanted)
    assert (refused.status_code, code_of(refused)) == (404, "upload.unknown")
    assert "labels" in refused.json()["detail"]
    assert client.post("/v1/jobs", json={"scan": labels, "body": "builtin:female"}).status_code == 404
    with database.write() as session:
        session.get(UploadRow, ("", labels)).kinds = []
    assert client.post("/v1/jobs", json=wanted).status_code == 202, "an upload of an earlier version has no kind"


def test_every_answer_has_an_id_and_a_policy(client, caplog):
    """Broken where an answer cannot be found in the log, or a page may run what it likes."""
    seen = set()
    for path in ("/healthz", "/v1/jobs", "/v1/nosuch", "/docs", "/openapi.json"):
        answer = client.get(path)
        seen.add(answer.headers["x-request-id"])
        assert "default-src 'none'" in answer.headers["content-security-policy"]
        assert answer.headers["x-content-type-options"] == "nosniff"
    assert len(seen) == 5
    document = answer.json()
    settings = document["components"]["schemas"]["Settings"]
    assert settings["properties"]["method"]["enum"] == ["deform", "inverse", "hybrid"] and settings["description"]
    events = document["paths"]["/v1/jobs/{job}/events"]["get"]["responses"]
    assert set(events["200"]["content"]) == {"application/json", "text/event-stream"}
    assert all(events[key]["content"][kind]["example"]["status"] == int(key) for key in events if key != "200"
               for kind in events[key]["content"])  # fmt: skip
    page = client.get("/docs")
    assert page.status_code == 200 and "/v1/jobs/{job}/result.zip" in page.text
    assert "<script" not in page.text and not re.search(r"(src|href|url|action)\W{1,3}(https?:)?//", page.text)
    from garmentq.service.logs import REQUEST

    token = REQUEST.set("abc")
    line = json.loads(JsonLines().format(logging.LogRecord("a", 20, __file__, 1, "x", (), None)))
    REQUEST.reset(token)
    assert line["request"] == "abc"


def test_head_zip_and_pages(client, settings, database, store, tmp_path):
    """Broken where HEAD is refused or has a body, the archive is not the files, or a page leaves a job out."""
    jobs = [ask(client, mark / 10).json()["job"] for mark in range(3)]
    finish(settings, database, store, jobs[0], tmp_path / "out")
    whole = client.get(f"/v1/jobs/{jobs[0]}/artifacts/pattern.svg")
    head = client.head(f"/v1/jobs/{jobs[0]}/artifacts/pattern.svg")
    assert (head.status_code, head.content) == (200, b"") and head.headers["etag"] == whole.headers["etag"]
    packed = client.get(f"/v1/jobs/{jobs[0]}/result.zip")
    with zipfile.ZipFile(io.BytesIO(packed.content)) as archive:
        assert archive.testzip() is None
        finished = client.get(f"/v1/jobs/{jobs[0]}").json()["finished"]
        for member in archive.infolist():
            assert member.date_time == time.gmtime(finished)[:5] + (time.gmtime(finished)[5] // 2 * 2,)
            assert struct.unpack("<HHBl", member.extra[:9]) == (0x5455, 5, 1, int(finished))
        assert {name: archive.read(name) for name in archive.namelist()} == {
            path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()
        }
    assert packed.content == client.get(f"/v1/jobs/{jobs[0]}/result.zip").content
    pages = [client.get("/v1/jobs", params={"limit": 1, "offset": at}).json()["jobs"] for at in range(4)]
    assert [row["job"] for page in pages for row in page] == jobs[::-1] and pages[3] == []
    assert len(client.get("/v1/query", params={"offset": 2}).json()["jobs"]) == 1


def test_what_is_deleted_is_gone(client, settings, database, store, tmp_path):
    """Broken where a scan, or what was made of it, stays after its owner deleted it, or another's goes with it."""
    ours, theirs = make_key(database, "ours"), make_key(database, "theirs")
    job, other = ask(client, headers=ours).json()["job"], ask(client, headers=theirs).json()["job"]
    refused = client.delete(f"/v1/jobs/{job}", headers=ours)
    assert (refused.status_code, code_of(refused)) == (409, "job.not_ended")
    assert client.delete(f"/v1/jobs/{other}", headers=ours).status_code == 404
    finish(settings, database, store, job, tmp_path / "out")
    files = client.get(f"/v1/jobs/{job}/artifacts", headers=ours).json()["files"]
    done = client.delete(f"/v1/jobs/{job}", headers=ours)
    assert done.status_code == 200 and done.json()["jobs"] == [job], done.text
    assert client.get(f"/v1/jobs/{job}", headers=ours).status_code == 404 and files
    assert find_job(database, other).id == other
    scan = find_job(database, other).scan
    gone = client.delete(f"/v1/scans/{scan}", headers=ours)
    assert gone.status_code == 200 and gone.json()["uploads"] == 1 and gone.json()["files"] == 0
    assert store.size(scan) and client.get(f"/v1/scans/{scan}", headers=ours).status_code == 404
    assert client.get(f"/v1/scans/{scan}", headers=theirs).status_code == 200
    wanted = {("DELETE 200", f"/v1/jobs/{job}"), ("DELETE 200", f"/v1/scans/{scan}"), ("POST 202", "/v1/jobs")}
    wait_for(lambda: wanted <= {(row.action, row.subject) for row in list_accesses(database)})
    done = [(row.action, row.subject) for row in list_accesses(database)]
    assert not any(action.startswith("DELETE 4") for action, _ in done)


def test_shared_jobs_by_setting(settings, database):
    """Broken where one key's cancel takes another's job away."""
    from dataclasses import replace

    with serving(replace(settings, share_jobs=1), LIMITS, is_open=False) as url, httpx.Client(base_url=url) as client:
        ours, theirs = make_key(database, "ours"), make_key(database, "theirs")
        job = ask(client, headers=ours).json()["job"]
        same = ask(client, headers=theirs).json()
        assert (same["job"], same["state"], same["is_new"]) == (job, "queued", False)
        assert claim(database, job, "w", 60.0)
        assert client.post(f"/v1/jobs/{job}/cancel", headers=theirs).json()["state"] == "running"
        assert not find_job(database, job).cancel
        assert client.get(f"/v1/jobs/{job}", headers=theirs).status_code == 404
        assert client.post(f"/v1/jobs/{job}/cancel", headers=ours).json()["state"] == "running"
        assert find_job(database, job).cancel, "the last one's wish counts"


def test_readiness_tells_what_stands_still(client, settings, database, store):
    """Broken where a service that takes jobs which nobody does looks healthy, or the question writes something."""
    ask(client)
    before = len(list(store.list_files()))
    told = httpx.get(f"{client.base_url}/readyz").json()
    assert (told["database"], told["store"]) == ("ok", "ok") and "no worker is up" in told["troubles"][0]
    assert len(list(store.list_files())) == before
    store.root.rename(store.root.with_name("away"))
    answer = httpx.get(f"{client.base_url}/readyz")
    assert answer.status_code == 503 and "store.unreachable" in answer.json()["detail"]
    refused = client.post("/v1/scans", params={"name": "a.ply"}, content=make_ply())
    assert refused.status_code == 503 and str(settings.home) not in refused.text


def test_origins_of_pages(settings, monkeypatch):
    """Broken where a page that was let in cannot ask, one that was not can, or everything may be let in."""
    monkeypatch.setenv("GARMENTQ_API_ORIGINS", "https://studio.example")
    with serving(settings, is_open=False) as url:
        asked = {"origin": "https://studio.example", "access-control-request-method": "POST"}
        told = httpx.options(f"{url}/v1/jobs", headers=asked)
        assert told.headers["access-control-allow-origin"] == "https://studio.example"
        foreign = httpx.options(f"{url}/v1/jobs", headers=asked | {"origin": "https://other.example"})
        assert "access-control-allow-origin" not in foreign.headers
    for text in ("*", "studio.example", "https://a/b", "null"):
        monkeypatch.setenv("GARMENTQ_API_ORIGINS", text)
        with pytest.raises(ServiceSettingBad):
            read_origins()
