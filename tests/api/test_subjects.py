"""Subjects and batches over HTTP: a key's own, paged, and erased without a trace of the name."""

from __future__ import annotations

import pytest
from api_work import ask, code_of, finish, make_key
from garmentq.service.audit import list_accesses
from garmentq.service.deletion import YOUNG_SECONDS


@pytest.fixture
def keys(database):
    """Return the headers of two keys and of an administrator."""
    return [make_key(database, name, *scopes) for name, scopes in (("a", ()), ("b", ()), ("root", ("admin",)))]


def test_a_subject_over_http(client, keys, settings, database, store, tmp_path, monkeypatch):
    """Broken where a record, a job's person or the erasure is another key's, or the audit log keeps the name."""
    monkeypatch.setattr("garmentq.service.deletion.YOUNG_SECONDS", -YOUNG_SECONDS)
    mine, other, root = keys
    made = client.post("/v1/subjects", json={"name": "Anna", "keep_days": 90}, headers=mine)
    assert made.status_code == 201, made.text
    subject = made.json()["subject"]
    assert made.headers["location"] == f"/v1/subjects/{subject}"
    again = client.post("/v1/subjects", json={"name": "Anna"}, headers=mine)
    assert (again.status_code, code_of(again)) == (409, "subject.name_taken")
    for wrong in ({"name": ""}, {"name": "x", "keep_days": 0}, {"name": "x", "nosuch": 1}, {"name": "0" * 12}):
        assert client.post("/v1/subjects", json=wrong, headers=mine).status_code == 422
    job = ask(client, headers=mine, subject="Anna", tags=["m/1"]).json()["job"]
    later = ask(client, 0.5, headers=mine).json()["job"]
    assert client.post(f"/v1/subjects/{subject}/jobs", json={"jobs": [later]}, headers=mine).json()["jobs"] == 2
    finish(settings, database, store, job, tmp_path / "made")
    assert client.get(f"/v1/jobs/{job}", headers=mine).json()["subject"] == "Anna"
    listed = client.get("/v1/jobs", params={"subject": "Anna"}, headers=mine).json()["jobs"]
    assert {one["job"] for one in listed} == {job, later}
    found = client.get(f"/v1/subjects/{subject}", headers=mine).json()
    assert {one["job"] for one in found["families"]} == {job, later} and len(found["scans"]) == 2
    theirs = ask(client, headers=other, subject="Anna").json()["job"]
    assert theirs != job
    assert client.get("/v1/jobs", params={"subject": subject}, headers=other).json()["jobs"] == []
    assert code_of(client.get(f"/v1/subjects/{subject}", headers=other)) == "subject.unknown"
    taken = client.post("/v1/jobs", json={"scan": found["scans"][0]["sha256"], "subject": subject}, headers=other)
    assert taken.status_code in (404, 422)
    assert len(client.get("/v1/subjects", params={"name": "Anna"}, headers=root).json()["subjects"]) == 2
    batch = client.get("/v1/batches/m/1", headers=mine).json()
    assert (batch["jobs"], batch["states"]) == (1, {"succeeded": 1})
    assert code_of(client.get("/v1/batches/m/1", headers=other)) == "batch.unknown"
    assert [one["tag"] for one in client.get("/v1/batches", headers=mine).json()["batches"]] == ["m/1"]
    changed = client.put(f"/v1/subjects/{subject}", json={"name": "Anne"}, headers=mine).json()
    assert (changed["name"], changed["keep_days"]) == ("Anne", None)
    refused = client.delete(f"/v1/subjects/{subject}", headers=mine)
    assert (refused.status_code, code_of(refused)) == (409, "job.not_ended")
    assert client.post(f"/v1/jobs/{later}/cancel", headers=mine).status_code == 200
    dry = client.delete(f"/v1/subjects/{subject}", params={"dry_run": True}, headers=mine).json()
    assert dry["dry_run"] and {one["job"] for one in dry["found"]["jobs"]} == {job, later}
    done = client.delete(f"/v1/subjects/{subject}", headers=mine).json()
    assert set(done["jobs"]) == {job, later} and done["found"] == dry["found"]
    assert client.get("/v1/subjects", headers=mine).json() == {"subjects": []}
    assert client.get(f"/v1/jobs/{theirs}", headers=other).status_code == 200
    kept = " ".join(f"{row.action} {row.subject}" for row in list_accesses(database))
    assert subject in kept and "Ann" not in kept


def test_an_idempotent_order_names_its_subject(client, keys):
    """Broken where a repeated request for another person is taken for the first, or one of before is refused."""
    headers = {**keys[0], "idempotency-key": "t"}
    first = ask(client, headers=headers)
    assert first.status_code == 202 and ask(client, headers=headers).json()["job"] == first.json()["job"]
    assert code_of(ask(client, headers=headers, subject="Anna")) == "request.idempotency_mismatch"
