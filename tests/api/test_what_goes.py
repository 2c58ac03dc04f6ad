"""What a key may delete and be told over HTTP: persons, templates, webhooks, and events without hosts."""

from __future__ import annotations

import time

import pytest
from api_client import carrying
from api_work import ask, code_of, finish, make_key, make_ply
from garmentq.service.deletion import YOUNG_SECONDS
from garmentq.service.jobs import claim
from garmentq.service.models import ScanRow, UploadRow
from garmentq.service.requeueing import release


@pytest.fixture
def keys(database):
    """Return the headers of two keys and of an administrator."""
    return [make_key(database, name, *scopes) for name, scopes in (("a", ()), ("b", ()), ("root", ("admin",)))]


def test_a_person_goes(client, keys, settings, database, store, tmp_path, monkeypatch):
    """Broken where anything of a scan is left, another key's goes too, or what forbids it is not named."""
    monkeypatch.setattr("garmentq.service.deletion.YOUNG_SECONDS", -YOUNG_SECONDS)
    mine, other, _ = keys
    job = ask(client, headers=mine).json()["job"]
    running = ask(client, 0.5, headers=mine, name="skirt", force=True).json()["job"]
    finish(settings, database, store, job, tmp_path / "made")
    foreign = ask(client, 0.25, headers=other).json()["job"]
    assert code_of(client.delete("/v1/persons/nobody", headers=mine)) == "person.unknown"
    refused = client.delete("/v1/persons/skirt", headers=mine)
    assert (refused.status_code, code_of(refused)) == (409, "job.not_ended") and running in refused.json()["detail"]
    assert client.get(f"/v1/jobs/{job}/result", headers=mine).status_code == 200, "nothing went"
    assert client.post(f"/v1/jobs/{running}/cancel", headers=mine).status_code == 200
    done = client.delete("/v1/persons/skirt", headers=mine)
    assert done.status_code == 200, done.text
    assert client.get("/v1/jobs", headers=mine).json() == {"jobs": [], "total": 0, "next": None}
    assert [one["job"] for one in client.get("/v1/jobs", headers=other).json()["jobs"]] == [foreign]
    with database.read() as session:
        assert [row.name for row in session.query(UploadRow) if row.name.startswith("skirt")] == ["skirt.ply"]
        assert session.query(ScanRow).count() == 1
    kept = {store.path(one.sha256).read_bytes() for one in store.list_files()}
    assert make_ply(0.25) in kept and not {make_ply(), make_ply(0.5), b"<svg/>" * 100} & kept


def test_a_person_is_listed_first(client, keys, settings, database, store, tmp_path):
    """Broken where a name is a pattern, a dry run deletes, or the operator is not told that it goes over other keys."""
    mine, other, root = keys
    job = ask(client, headers=mine, name="scan_01").json()["job"]
    theirs = ask(client, headers=other, name="scan_01").json()["job"]
    near = ask(client, 0.25, headers=mine, name="scan-01").json()["job"]
    for one in (job, theirs, near):
        finish(settings, database, store, one, tmp_path / one)
    for wrong in ("%25", "scan%25", "SCAN_01", "scan_0_"):
        for call in (client.get, client.delete):
            assert code_of(call(f"/v1/persons/{wrong}", headers=mine)) == "person.unknown"
    found = client.get("/v1/persons/scan_01", headers=mine).json()
    assert [one["job"] for one in found["jobs"]] == [job] and len(found["keys"]) == 1
    assert found["names"] == ["scan_01", "skirt.ply"] and [one["name"] for one in found["uploads"]] == ["skirt.ply"]
    tried = client.delete("/v1/persons/scan_01", params={"dry_run": True}, headers=mine).json()
    assert tried == {**tried, "found": found, "dry_run": True, "jobs": [], "uploads": 0}
    every = client.delete("/v1/persons/scan_01", params={"dry_run": True}, headers=root).json()["found"]
    assert {one["job"] for one in every["jobs"]} == {job, theirs} and len(every["keys"]) == 2
    done = client.delete("/v1/persons/scan_01", headers=mine).json()
    assert done["jobs"] == [job] and done["found"] == found
    for one, headers in ((theirs, other), (near, mine)):
        assert client.get(f"/v1/jobs/{one}", headers=headers).status_code == 200


def test_a_template_goes(client, keys):
    """Broken where an imported template cannot be removed, a shipped one can, or anybody may."""
    pattern = client.get("/v1/templates/skirt", headers=keys[0]).content
    assert client.put("/v1/templates/mine", content=pattern, headers=keys[2]).status_code == 201
    assert client.delete("/v1/templates/mine", headers=keys[0]).status_code == 403
    assert client.delete("/v1/templates/mine", headers=keys[2]).json()["source"] == "imported"
    assert code_of(client.delete("/v1/templates/mine", headers=keys[2])) == "template.unknown"
    assert code_of(client.delete("/v1/templates/skirt", headers=keys[2])) == "template.shipped"


def test_questions_by_date_and_state(client, keys):
    """Broken where a date is no answer, or a misspelt state is an empty table."""
    job = ask(client, headers=keys[0]).json()["job"]
    asked = {"created > 2001-11-01": [job], "created < 2001-01-01T00:00+01:00": [], "created > 1e9": [job]}
    for where, found in asked.items():
        answer = client.get("/v1/query", params={"where": where}, headers=keys[0])
        assert [one["job"] for one in answer.json()["jobs"]] == found, answer.text
    for params in ({"where": "state = nonsense"}, {"where": "created > 2001-13-01"}, {"state": "nonsense"}):
        assert code_of(client.get("/v1/query", params=params, headers=keys[0])) == "query.bad"
    form = client.post("/v1/scans", params={"name": "a.ply"}, files={"file": b"ply"}, headers=keys[0])
    assert (form.status_code, code_of(form)) == (415, "upload.not_raw")


def test_webhooks_of_a_key(client, keys, settings):
    """Broken where a key sees, tests or deletes another's webhook, or is sent into the service's network."""
    made = client.post("/v1/webhooks", json={"url": "https://studio.example/"}, headers=keys[0]).json()
    assert made["secret"].startswith("whsec_") and len(made["states"]) == 4
    own = client.get("/v1/webhooks", headers=keys[0]).json()["webhooks"]
    assert [one["webhook"] for one in own] == [made["webhook"]] and "secret" not in own[0]
    assert client.get("/v1/webhooks", headers=keys[1]).json()["webhooks"] == []
    for ask_for, path in ((client.delete, ""), (client.post, "/test")):
        assert code_of(ask_for(f"/v1/webhooks/{made['webhook']}{path}", headers=keys[1])) == "webhook.unknown"
    for url in ("http://studio.example/", "https://127.0.0.1/", "https://[::1]/", "https://169.254.169.254/"):
        assert client.post("/v1/webhooks", json={"url": url}, headers=keys[0]).status_code == 422
    for number in (2130706433, "localhost"):
        here = client.post("/v1/webhooks", json={"url": f"https://{number}/"}, headers=keys[0]).json()["webhook"]
        with carrying(settings):
            assert "no public address" in client.post(f"/v1/webhooks/{here}/test", headers=keys[0]).json()["error"]
    assert client.delete(f"/v1/webhooks/{made['webhook']}", headers=keys[0]).json()["webhook"] == made["webhook"]


def test_events_name_no_host(client, keys, database):
    """Broken where a key learns the names of hosts and processes from its job's events."""
    job = ask(client, headers=keys[0]).json()["job"]
    release(database, claim(database, job, "host7:4711:task", 30.0))
    claim(database, job, "host8:4712:task", -1.0)
    from garmentq.service.reaper import reap

    time.sleep(0.01)
    assert reap(database, 9) == 1
    listed, all_of_it = (client.get(f"/v1/jobs/{job}/events", headers=key).text for key in (keys[0], keys[2]))
    assert "lease_expired" in listed and "host" not in listed and "host8" in all_of_it
    assert client.post(f"/v1/jobs/{job}/cancel", headers=keys[0]).status_code == 200
    accept = {"accept": "text/event-stream"}
    assert "host" not in client.get(f"/v1/jobs/{job}/events", headers=keys[0] | accept).text


def test_a_cached_file_is_asked_for_again(client, settings, database, store, tmp_path):
    """Broken where a browser or a proxy shows a file, a body for example, after its deletion, or fetches it twice."""
    job = ask(client).json()["job"]
    finish(settings, database, store, job, tmp_path / "out")
    path = f"/v1/jobs/{job}/artifacts/pattern.svg"
    first = client.get(path)
    assert first.headers["cache-control"] == "private, no-cache"
    again = client.get(path, headers={"if-none-match": first.headers["etag"]})
    assert (again.status_code, again.content, again.headers["cache-control"]) == (304, b"", "private, no-cache")
    assert client.delete(f"/v1/jobs/{job}").status_code == 200
    assert client.get(path, headers={"if-none-match": first.headers["etag"]}).status_code == 404
