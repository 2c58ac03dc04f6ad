"""The routes as a program meets them: files in, jobs, events, results out."""

from __future__ import annotations

import hashlib
import json

import httpx
from api_work import ask, code_of, finish, make_key, make_ply, upload
from garmentq.service.families import cancel
from garmentq.service.jobs import find_job


def test_an_upload_is_named_by_its_hash(client):
    """Broken where the bytes change on their way, or a damaged transfer is taken."""
    content = make_ply()
    answer = client.post("/v1/scans", params={"name": "a b.ply"}, content=content)
    digest = hashlib.sha256(content).hexdigest()
    assert answer.status_code == 201 and answer.json() == {"sha256": digest, "name": "a_b.ply", "size": len(content)}
    assert answer.headers["location"] == f"/v1/scans/{digest}" and answer.headers["etag"] == f'"{digest}"'
    assert client.get(f"/v1/scans/{digest}").json()["size"] == len(content)
    wrong = client.post("/v1/scans", params={"name": "a.ply"}, content=content, headers={"x-content-sha256": "0" * 64})
    assert (wrong.status_code, code_of(wrong)) == (422, "upload.damaged")


def test_a_job_is_accepted_once(client, database):
    """Broken where the same order twice is two jobs, or an answer lacks its place."""
    first, again = ask(client), ask(client)
    assert (first.status_code, again.status_code) == (202, 200)
    job = first.json()["job"]
    assert first.headers["location"] == f"/v1/jobs/{job}" and again.json()["job"] == job
    assert client.get(f"/v1/jobs/{job}").json()["state"] == "queued"
    assert [row["job"] for row in client.get("/v1/jobs").json()["jobs"]] == [job]
    assert client.post(f"/v1/jobs/{job}/cancel").json()["state"] == "cancelled"
    assert client.post(f"/v1/jobs/{job}/retry").status_code == 202
    assert code_of(client.post(f"/v1/jobs/{job}/retry")) == "job.not_ended"


def test_a_result_is_asked_for_before_its_redrape(client, database):
    """Broken where the service's default waits for re-drapes, or a setting of the closed set is taken or refused."""
    for settings, stored in (({}, "later"), ({"redrape": "wait"}, None), ({"redrape": "never"}, "never")):
        job = ask(client, force=True, settings=settings).json()["job"]
        assert find_job(database, job).request["settings"].get("redrape") == stored
    assert code_of(ask(client, settings={"redrape": "soon"})) == "settings.bad"
    described = client.get("/openapi.json").json()["components"]["schemas"]["Settings"]["properties"]["redrape"]
    assert described["default"] == "later" and described["enum"] == ["wait", "later", "never"]


def test_a_quality_is_a_setting(client, database):
    """Broken where a quality reaches no setting, wins over one that is given, or makes another order of the same."""
    ask_for = lambda **settings: ask(client, settings=settings).json()["job"]  # noqa: E731
    preview = ask_for(quality="preview")
    stored = find_job(database, preview).request["settings"]
    assert (stored["method"], stored["vertex_count"]) == ("deform", 2000) and "quality" not in stored
    assert preview == ask_for(method="deform", vertex_count=2000) == ask_for(quality="preview", method="deform")
    assert ask_for() == ask_for(quality="standard") == ask_for(quality=None)
    stored = find_job(database, ask_for(quality="preview", vertex_count=900)).request["settings"]
    assert (stored["method"], stored["vertex_count"]) == ("deform", 900)
    assert code_of(ask(client, settings={"quality": "perfect"})) == "settings.bad"
    schemas = client.get("/openapi.json").json()["components"]["schemas"]
    assert schemas["Settings"]["properties"]["quality"]["enum"] == ["preview", "standard", "fine", None]
    assert schemas["Settings"]["example"]["quality"] == "preview"


def test_a_repeated_request_may_name_the_quality_or_its_settings(client):
    """Broken where the key of a repeated request refuses the same settings in other words, or takes others."""
    token = {"idempotency-key": "one"}
    first = ask(client, headers=token, settings={"quality": "preview"}).json()["job"]
    same = ask(client, headers=token, settings={"method": "deform", "vertex_count": 2000})
    assert same.json()["job"] == first
    other = ask(client, headers=token, settings={"quality": "standard"})
    assert code_of(other) == "request.idempotency_mismatch"


def test_a_preview_is_refined_by_its_owner(client, settings, database, store, tmp_path):
    """Broken where another key refines a preview, a reader does, or a job that is none is refined."""
    ours, theirs, reader = (make_key(database, name, *s) for name, s in (("o", ()), ("t", ()), ("r", ("read",))))
    job = ask(client, headers=ours, settings={"quality": "preview"}).json()["job"]
    refine = lambda headers, of=job: client.post(f"/v1/jobs/{of}/refine", headers=headers)  # noqa: E731
    assert code_of(refine(ours)) == "job.input_not_ended"
    finish(settings, database, store, job, tmp_path / "files")
    assert code_of(refine(theirs)) == "job.unknown" and code_of(refine(reader)) == "key.scope_missing"
    made = refine(ours)
    assert made.status_code == 202 and made.headers["location"] == f"/v1/jobs/{made.json()['job']}"
    assert refine(ours).status_code == 200 and refine(ours).json()["job"] == made.json()["job"]
    assert code_of(refine(ours, made.json()["job"])) == "job.not_preview"


def test_an_idempotency_key_makes_a_forced_job_once(client, database):
    """Broken where a repeated request makes a second job, or another request passes under the same key."""
    headers = {"idempotency-key": "abc"}
    scan = upload(client)
    wanted = {"scan": scan, "body": "builtin:female,height=1.70", "force": True}
    jobs = {client.post("/v1/jobs", json=wanted, headers=headers).json()["job"] for _ in range(3)}
    assert len(jobs) == 1
    cancel(database, *jobs)
    again = client.post("/v1/jobs", json=wanted, headers=headers)
    assert again.json() == {"job": next(iter(jobs)), "state": "cancelled", "is_new": False, "understood": None}
    other = client.post("/v1/jobs", json=wanted | {"priority": 3}, headers=headers)
    assert (other.status_code, code_of(other)) == (422, "request.idempotency_mismatch")
    assert client.post("/v1/jobs", json=wanted, headers={"idempotency-key": "d"}).json()["job"] not in jobs


def test_events_resume(client, settings, database, store, tmp_path):
    """Broken where a client that comes back misses an event, sees one twice, or waits for ever."""
    job = ask(client).json()["job"]
    finish(settings, database, store, job, tmp_path / "out")
    listed = client.get(f"/v1/jobs/{job}/events").json()
    assert [event["kind"] for event in listed["events"]] == ["queued", "started", "succeeded"]
    stream = {"accept": "text/event-stream"}
    whole = client.get(f"/v1/jobs/{job}/events", headers=stream)
    assert whole.headers["content-type"].startswith("text/event-stream")
    ids = [int(line[4:]) for line in whole.text.splitlines() if line.startswith("id: ")]
    assert ids == [event["id"] for event in listed["events"]]
    rest = client.get(f"/v1/jobs/{job}/events", headers=stream | {"last-event-id": str(ids[0])}).text
    assert [int(line[4:]) for line in rest.splitlines() if line.startswith("id: ")] == ids[1:]
    assert rest.endswith('event: end\ndata: {"state": "succeeded"}\n\n')
    assert client.get(f"/v1/jobs/{job}/events", params={"after": ids[-1]}).json()["events"] == []


def test_artifacts_come_in_ranges(client, settings, database, store, tmp_path):
    """Broken where a range gives other bytes, an ETag is not the hash, or a copy is left behind."""
    job = ask(client).json()["job"]
    assert code_of(client.get(f"/v1/jobs/{job}/result")) == "result.missing"
    finish(settings, database, store, job, tmp_path / "out")
    result = client.get(f"/v1/jobs/{job}/result").json()
    assert result["state"] == "succeeded" and result["metrics"]["surface_rms_mm.t2s"] == 3.0
    files = {file["name"]: file for file in result["files"]}
    url = f"/v1/jobs/{job}/artifacts/pattern.svg"
    whole = client.get(url)
    assert hashlib.sha256(whole.content).hexdigest() == files["pattern.svg"]["sha256"]
    assert whole.headers["etag"] == f'"{files["pattern.svg"]["sha256"]}"'
    part = client.get(url, headers={"range": "bytes=100-199"})
    assert part.status_code == 206 and part.content == whole.content[100:200]
    assert client.get(url, headers={"range": "bytes=99999-"}).status_code == 416
    assert client.get(url, headers={"if-none-match": whole.headers["etag"]}).status_code == 304
    assert code_of(client.get(f"/v1/jobs/{job}/artifacts/nosuch")) == "result.missing"
    assert client.get(f"/v1/bodies/of/{job}").json()["source"] == "mesh:standin"
    assert list((settings.home / "incoming").iterdir()) == []


def test_questions_and_libraries(client, settings, database, store, tmp_path):
    """Broken where a question or a library answers otherwise than the command line does."""
    job = ask(client).json()["job"]
    finish(settings, database, store, job, tmp_path / "out")
    found = client.get("/v1/query", params={"where": "surface_rms_mm.t2s < 4", "garment": "skirt"}).json()["jobs"]
    assert [row["job"] for row in found] == [job]
    assert client.get("/v1/query", params={"where": "surface_rms_mm.t2s > 4"}).json()["jobs"] == []
    bad = client.get("/v1/query", params={"where": "drop table jobs"})
    assert (bad.status_code, code_of(bad)) == (422, "query.bad")
    names = [row["name"] for row in client.get("/v1/templates").json()["templates"]]
    pattern = client.get(f"/v1/templates/{names[0]}")
    assert pattern.status_code == 200 and json.loads(pattern.content)
    kept = client.put("/v1/templates/mine", content=pattern.content)
    assert kept.status_code == 201 and kept.json()["panels"] > 0
    assert code_of(client.put(f"/v1/templates/{names[0]}", content=pattern.content)) == "template.name_bad"
    assert code_of(client.get("/v1/templates/nosuch")) == "template.unknown"
    assert client.get("/v1/materials/denim").json()["name"] == "denim"
    assert code_of(client.get("/v1/materials/nosuch")) == "fabric.unknown"
    own = client.get("/v1/materials/denim").json() | {"name": "mine"}
    assert client.put("/v1/materials/mine", json=own).json() == own == client.get("/v1/materials/mine").json()
    assert code_of(client.put("/v1/materials/denim", json=own | {"name": "denim"})) == "fabric.shipped"
    assert code_of(client.put("/v1/materials/mine", json=own | {"k": -1.0})) == "fabric.out_of_range"
    assert code_of(client.put("/v1/materials/mine", json=own | {"sources": {}})) == "fabric.source_bad"
    assert client.put("/v1/materials/yours", json=own).status_code == 422
    assert code_of(client.delete("/v1/materials/denim")) == "fabric.shipped"
    assert client.delete("/v1/materials/mine").json() == own
    assert code_of(client.delete("/v1/materials/mine")) == "fabric.unknown"
    assert client.get("/healthz").status_code == 200 and client.get("/readyz").json()["store"] == "ok"


def test_another_keys_job_is_unknown(client, database):
    """Broken where a key sees, stops or finds the job of another, or uses its uploads."""
    ours, theirs = make_key(database, "ours"), make_key(database, "theirs")
    admin = make_key(database, "admin", "admin")
    job = ask(client, headers=ours).json()["job"]
    for method, path in (
        ("get", ""), ("get", "/events"), ("get", "/result"), ("get", "/artifacts"), ("get", "/artifacts/x"),
        ("post", "/cancel"), ("post", "/retry"),
    ):  # fmt: skip
        answer = client.request(method, f"/v1/jobs/{job}{path}", headers=theirs)
        unknown = client.request(method, f"/v1/jobs/abcdefabcdef{path}", headers=theirs)
        assert (answer.status_code, code_of(answer)) == (404, "job.unknown"), path
        assert answer.json()["detail"].replace(job, "") == unknown.json()["detail"].replace("abcdefabcdef", "")
    assert find_job(database, job).state == "queued"
    for path in ("/v1/jobs", "/v1/query"):
        assert client.get(path, headers=theirs).json()["jobs"] == []
        assert len(client.get(path, headers=ours).json()["jobs"]) == 1
        assert len(client.get(path, headers=admin).json()["jobs"]) == 1
    assert client.get(f"/v1/jobs/{job[:6]}", headers=theirs).status_code == 404
    assert client.get(f"/v1/jobs/{job[:6]}", headers=ours).json()["job"] == job
    digest = hashlib.sha256(make_ply()).hexdigest()
    stolen = client.post("/v1/jobs", json={"scan": digest, "body": "builtin:female,height=1.7"}, headers=theirs)
    assert (stolen.status_code, code_of(stolen)) == (404, "upload.unknown")
    own = ask(client, headers=theirs).json()
    assert own["job"] != job and own["is_new"], "who has the same files has a job of its own"
    assert client.get(f"/v1/jobs/{job}", headers=theirs).status_code == 404


def test_keys_scopes_and_quota(client, database):
    """Broken where a key does more than it may, or a revoked one opens the service again."""
    admin = make_key(database, "admin", "admin")
    assert (client.get("/v1/jobs").status_code, code_of(client.get("/v1/jobs"))) == (401, "key.bad")
    assert code_of(httpx.get(f"{client.base_url}/v1/jobs")) == "key.missing"
    assert code_of(client.get("/v1/jobs", headers={"authorization": "Bearer gq_wrong"})) == "key.bad"
    made = client.post("/v1/keys", json={"name": "small", "quota": 1}, headers=admin)
    assert made.status_code == 201 and made.json()["token"].startswith("gq_")
    small = {"authorization": f"Bearer {made.json()['token']}"}
    assert code_of(client.get("/v1/keys", headers=small)) == "key.scope_missing"
    assert code_of(client.put("/v1/templates/x", content=b"{}", headers=small)) == "key.scope_missing"
    assert ask(client, 0.1, headers=small).status_code == 202
    full = ask(client, 0.2, headers=small)
    assert (full.status_code, code_of(full)) == (429, "key.queue_full") and full.headers["retry-after"]
    assert ask(client, 0.1, headers=small).status_code == 200
    reader = make_key(database, "reader", "read")
    assert client.get("/v1/jobs", headers=reader).status_code == 200
    assert client.post("/v1/scans", params={"name": "a.ply"}, content=b"", headers=reader).status_code == 403
    listed = client.get("/v1/keys", headers=admin)
    assert "token" not in listed.text and len(listed.json()["keys"]) == 3
    for row in listed.json()["keys"]:
        assert client.delete(f"/v1/keys/{row['key']}", headers=admin).status_code in (200, 401)
    assert client.get("/v1/jobs").status_code == 401 and client.get("/v1/jobs", headers=admin).status_code == 401


def test_every_route_has_an_example(client):
    """Broken where a route is added without an example or a summary."""
    page = client.get("/openapi.json").json()
    count = 0
    for path, methods in page["paths"].items():
        for method, route in methods.items():
            count += 1
            assert route["summary"], (method, path)
            contents = [
                c for code, a in route["responses"].items() if code[0] == "2" for c in a.get("content", {}).values()
            ]
            assert any("example" in c for c in contents), (method, path)
    assert count >= 28
    assert client.get("/docs").status_code == 200


def test_patterns_are_matched(client, database):
    """Broken where equal patterns differ, a pair is overruled, or a job that a key does not own can be compared."""
    equal = client.get("/v1/match", params={"first": "skirt", "second": "skirt"}).json()
    assert [pair["paired_by"] for pair in equal["pairs"]] == ["name"] * 2
    assert max(abs(pair["outline_mm"]) for pair in equal["pairs"]) < 1e-6
    given = {"first": "skirt", "second": "skirt", "pair": ["front:back", "back:front"]}
    crossed = client.get("/v1/match", params=given).json()
    assert {(pair["first"], pair["second"]) for pair in crossed["pairs"]} == {("front", "back"), ("back", "front")}
    bad = client.get("/v1/match", params={**given, "pair": ["nosuch:front"]})
    assert (bad.status_code, code_of(bad)) == (422, "match.pairs_bad")
    assert client.get("/v1/match", params={**given, "pair": ["front"]}).status_code == 422
    assert code_of(client.get("/v1/match", params={"first": "nosuch", "second": "skirt"})) == "template.unknown"


def test_files_are_checked_before_a_job_is_queued(client):
    """Broken where a file that cannot be used is queued although a check was requested, or without a word."""
    body = {"body": "builtin:female,height=1.70", "check": True}
    good = client.post("/v1/jobs", json={"scan": upload(client), **body})
    assert good.status_code == 202 and good.json()["understood"]["scan"]["units"] == "m"
    bad = client.post("/v1/scans", params={"name": "bad.ply"}, content=b"no mesh at all").json()["sha256"]
    refused = client.post("/v1/jobs", json={"scan": bad, **body})
    assert (refused.status_code, code_of(refused)) == (422, "scan.truncated")
    assert [row["job"] for row in client.get("/v1/jobs").json()["jobs"]] == [good.json()["job"]]
    unchecked = client.post("/v1/jobs", json={"scan": bad, **body, "check": False})
    assert unchecked.status_code == 202 and unchecked.json()["understood"] is None
