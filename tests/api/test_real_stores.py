"""The main road through the API on the databases and stores of production: upload, job, result, file, question."""

from __future__ import annotations

import json
import os
from dataclasses import replace

import httpx
import pytest
from api_client import serving
from api_work import ask, code_of, finish, make_key, make_ply, upload
from garmentq.service.database import open_database
from garmentq.service.stores import open_store
from garmentq_home import DATABASES

JSON = {"content-type": "application/json"}


@pytest.fixture(scope="module", params=DATABASES)
def database_kind(request):
    """Run every test here on both."""
    return request.param


@pytest.fixture(scope="module")
def bucket_server():
    """Start an S3 server on a free port."""
    from moto.server import ThreadedMotoServer

    started = ThreadedMotoServer("127.0.0.1", port=0, verbose=False)
    started.start()
    host, port = started.get_host_and_port()
    yield f"http://{host}:{port}"
    started.stop()


@pytest.fixture(params=["folder", "s3"])
def chosen(request, settings, monkeypatch):
    """Return settings with each kind of store."""
    if request.param == "folder":
        return settings
    monkeypatch.setenv("AWS_ACCESS_KEY_ID", "x")
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "y")
    server = request.getfixturevalue("bucket_server")
    made = replace(settings, store=f"s3://gq-{os.urandom(6).hex()}/studio", s3_endpoint=server)
    open_store(made).prepare()
    return made


def test_the_main_road(chosen, tmp_path):
    """Broken where a database or store of production answers otherwise than the embedded ones."""
    database, store = open_database(chosen), open_store(chosen)
    with serving(chosen, is_open=False) as url, httpx.Client(base_url=url, timeout=30.0) as client:
        ours, theirs = make_key(database, "ours", quota=2), make_key(database, "theirs")
        job = ask(client, headers=ours).json()["job"]
        assert ask(client, 0.1, headers=ours).status_code == 202
        full = ask(client, 0.2, headers=ours)
        assert (full.status_code, code_of(full)) == (429, "key.queue_full")
        client.headers.update(ours)
        finish(chosen, database, store, job, tmp_path / "made")
        result = client.get(f"/v1/jobs/{job}/result").json()
        assert result["state"] == "succeeded" and result["metrics"]["surface_rms_mm.t2s"] > 0
        file = next(file for file in result["files"] if file["name"] == "pattern.svg")
        content = (tmp_path / "made" / "pattern.svg").read_bytes()
        page = f"/v1/jobs/{job}/artifacts/pattern.svg"
        whole = client.get(page)
        assert whole.content == content and whole.headers["etag"] == f'"{file["sha256"]}"'
        for asked, part in (("bytes=5-9", content[5:10]), ("bytes=-7", content[-7:]), ("bytes=590-", content[590:])):
            some = client.get(page, headers={"range": asked, "if-range": whole.headers["etag"]})
            assert (some.status_code, some.content) == (206, part), asked
        for asked in ("bytes=99999-", "bytes=9-5", "lines=1-2"):
            refused = client.get(page, headers={"range": asked})
            assert refused.status_code in (400, 416) and code_of(refused) == "request.range", asked
        assert client.get(page, headers={"if-none-match": whole.headers["etag"]}).status_code == 304
        events = client.get(f"/v1/jobs/{job}/events", headers={"accept": "text/event-stream"}).text
        assert [line[7:] for line in events.splitlines() if line.startswith("event: ")][-2:] == ["succeeded", "end"]
        found = client.get("/v1/query", params={"where": "surface_rms_mm.t2s < 9", "garment": "skirt"}).json()["jobs"]
        assert [row["job"] for row in found] == [job]
        assert client.get("/v1/queue").json()["states"] == {"queued": 1, "succeeded": 1}
        ready = client.get("/readyz").json()
        assert (ready["database"], ready["store"]) == ("ok", "ok") and "no worker is up" in ready["troubles"][0]
        scraper = make_key(database, "scraper", "metrics")
        assert "garmentq_jobs{" in client.get("/metrics", headers=scraper).text
        assert client.get(page, headers=theirs).status_code == 404
        assert list((chosen.home / "incoming").iterdir()) == []
    database.dispose()


def test_words_that_a_database_cannot_hold(client):
    """Broken where PostgreSQL, which keeps no NUL and no lone surrogate, turns a strange word into a fault."""
    scan = upload(client)
    for word in ("\x00", "a\x00b", "\ud800", "\uffff", "😀" * 60, "'; drop table jobs; --", "%s%(a)s:x"):
        code = word.encode("utf-8", "surrogatepass")
        for page in ("/v1/jobs/{}", "/v1/query?garment={}", "/v1/query?sort={}", "/v1/query?where=name='{}'",
                     "/v1/templates/{}", "/v1/materials/{}", "/v1/scans/{}", "/v1/jobs/{}/artifacts/x"):  # fmt: skip
            answer = client.get(page.format("".join(f"%{byte:02x}" for byte in code)))
            assert answer.status_code in (200, 404, 422), (word, page, answer.text)
        named = client.post("/v1/scans?name=" + "".join(f"%{byte:02x}" for byte in code) + ".ply", content=make_ply())
        assert named.status_code in (201, 422), (word, named.text)
        for settings in ({"garment": word}, {"fabric": word}, {"keep": word, "labels_key": word}):
            wanted = {"scan": scan, "body": "builtin:female", "settings": settings}
            answer = client.post("/v1/jobs", content=json.dumps(wanted), headers=JSON)
            assert answer.status_code in (202, 200, 404, 422), (word, settings, answer.text)
        answer = client.post("/v1/keys", content=json.dumps({"name": word, "scopes": ["reed"]}), headers=JSON)
        assert answer.status_code == 422, (word, answer.text)
    assert client.get("/v1/query", params={"where": f"surface_rms_mm.t2s < {'9' * 400}"}).status_code in (200, 422)
