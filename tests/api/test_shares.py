"""Share links: who makes them, what they show, and when they end."""

from __future__ import annotations

import pytest
from api_work import ask, code_of, finish, make_key
from garmentq.service.audit import list_accesses
from garmentq.service.database import clock
from garmentq.service.deletion import delete_jobs
from garmentq.service.keys import revoke_key
from garmentq.service.models import ApiKeyRow, ShareRow
from sqlalchemy import select, update


@pytest.fixture
def job(client, settings, database, store, tmp_path):
    """Return a finished job, and the header of the key that owns it."""
    header = make_key(database, "ours")
    made = ask(client, headers=header).json()["job"]
    finish(settings, database, store, made, tmp_path / "made")
    return made, header


def share(client, job, days: int = 7) -> dict:
    """Make a link."""
    made, header = job
    answer = client.post(f"/v1/jobs/{made}/shares", json={"days": days}, headers=header)
    assert answer.status_code == 201, answer.text
    return answer.json()


def look(client, path: str):
    """Open an address as somebody without a session or key."""
    client.cookies.clear()
    return client.get(path, headers={"authorization": ""})


def test_a_link_shows_one_result(client, job, database):
    """Broken where a link needs a key, shows more than the garment, or stays in caches and search engines."""
    made = share(client, job)
    shown = look(client, made["path"])
    assert shown.status_code == 200 and "skirt" in shown.text and job[0] not in shown.text
    for name, value in (("cache-control", "no-store"), ("referrer-policy", "no-referrer")):
        assert shown.headers[name] == value
    assert "noindex" in shown.headers["x-robots-tag"] and "<nav" not in shown.text
    drawing = look(client, f"{made['path']}/pattern.svg")
    assert drawing.headers["content-type"] == "image/svg+xml" and drawing.text.startswith("<svg")
    for path in ("/metrics.txt", "/body.ply", "/artifacts/pattern.svg", "/pattern.pdf", "/view.bin"):
        assert look(client, made["path"] + path).status_code == 404, path
    for path in (f"/v1/jobs/{job[0]}", f"/v1/jobs/{job[0]}/artifacts/pattern.svg"):
        token = made["path"].rpartition("/")[2]
        assert client.get(path, headers={"authorization": f"Bearer {token}"}).status_code == 401
    listed = client.get(f"/v1/jobs/{job[0]}/shares", headers=job[1]).json()["shares"]
    assert [one["opened"] for one in listed] == [1] and "path" not in listed[0]
    told = [one for one in list_accesses(database) if one.subject == f"/shared/{made['share']}"]
    assert len(told) == 1 and made["path"] not in str(list_accesses(database))


def end_by_time(client, job, database, store, made):
    with database.write() as session:
        session.execute(update(ShareRow).values(expires=clock() - 1.0))


def end_by_hand(client, job, database, store, made):
    answer = client.delete(f"/v1/jobs/{job[0]}/shares/{made['share']}", headers=job[1])
    assert answer.status_code == 200 and answer.json()["share"] == made["share"]


def end_by_key(client, job, database, store, made):
    with database.read() as session:
        key = session.scalars(select(ApiKeyRow.id).where(ApiKeyRow.name == "ours")).one()
    revoke_key(database, key)


def end_by_job(client, job, database, store, made):
    delete_jobs(database, store, [job[0]])


@pytest.mark.parametrize("end", [end_by_time, end_by_hand, end_by_key, end_by_job])
def test_an_ended_link_is_as_unknown_as_a_wrong_one(client, job, database, store, end):
    """Broken where a link outlives its days, its job, its key or its revocation, or tells that it was one."""
    made = share(client, job)
    end(client, job, database, store, made)
    wrong = look(client, "/shared/" + "x" * 43)
    for path in ("", "/pattern.svg", "/figure", "/view.bin"):
        ended = look(client, made["path"] + path)
        assert (ended.status_code, ended.text) == (404, wrong.text), path


def test_who_may_share(client, job, database):
    """Broken where a reader, or another key, shares a result or sees its links."""
    made = share(client, job)
    path = f"/v1/jobs/{job[0]}/shares"
    reader, other = make_key(database, "reader", "read"), make_key(database, "other")
    assert code_of(client.post(path, json={}, headers=reader)) == "key.scope_missing"
    assert code_of(client.post(path, json={}, headers=other)) == "job.unknown"
    assert code_of(client.get(path, headers=other)) == "job.unknown"
    assert code_of(client.delete(f"{path}/{made['share']}", headers=other)) == "job.unknown"
    assert code_of(client.delete(f"{path}/0123456789ab", headers=job[1])) == "share.unknown"
    assert client.post(path, json={"days": 31}, headers=job[1]).status_code == 422
    queued = ask(client, 0.3, headers=job[1]).json()["job"]
    assert code_of(client.post(f"/v1/jobs/{queued}/shares", json={}, headers=job[1])) == "share.not_ended"


def test_tokens_cannot_be_tried(client, job):
    """Broken where an address may try any number of tokens, or a right one is refused behind it."""
    made = share(client, job)
    assert look(client, made["path"]).status_code == 200
    answers = {look(client, f"/shared/{number:043d}").status_code for number in range(60)}
    assert answers == {404, 429}
    assert look(client, made["path"]).status_code == 200
