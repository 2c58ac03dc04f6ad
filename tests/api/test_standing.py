"""Whoever may ask no more gets nothing more: streams, uploads and downloads end with the key or the session."""

from __future__ import annotations

import time
from dataclasses import replace

import httpx
import pytest
from api_client import LIMITS, serving
from api_work import ask, finish, make_key, upload
from garmentq.service.api import events, guard
from garmentq.service.families import cancel
from garmentq.service.keys import revoke_key
from garmentq.service.models import ApiKeyRow, ArtifactRow, SessionRow, UploadRow
from garmentq.service.results import RESULT
from sqlalchemy import select, update

LARGE = 48 * 1024**2
"""More than the buffers of a connection hold [bytes]."""


@pytest.fixture
def short(monkeypatch):
    """Ask again, and give a sign of life, so often that a test need not wait."""
    assert guard.ADMITTED_SECONDS + events.STREAM_KEEPALIVE_INTERVAL <= 30.0
    monkeypatch.setattr(guard, "ADMITTED_SECONDS", 0.2)
    monkeypatch.setattr(events, "STREAM_KEEPALIVE_INTERVAL", 0.2)


def find_key(database) -> str:
    """Return the id of the only key."""
    with database.read() as session:
        return session.scalars(select(ApiKeyRow.id)).one()


def expire(database) -> None:
    """Let the key be over."""
    with database.write() as session:
        session.execute(update(ApiKeyRow).values(expires=1.0))


def end_sessions(database) -> None:
    """Let all sessions be over."""
    with database.write() as session:
        session.execute(update(SessionRow).values(expires=1.0))


def revoke(database) -> None:
    """Take the key back."""
    revoke_key(database, find_key(database))


@pytest.mark.parametrize(
    ("by", "end"), [("key", revoke), ("key", expire), ("session", revoke), ("session", end_sessions)]
)
def test_an_event_stream_ends_with_its_key_or_session(settings, database, short, by, end):
    """Broken where who was shut out goes on reading what happens to a job, or who was not is cut off."""
    key = make_key(database, "studio")
    with serving(settings, is_open=False) as url, httpx.Client(base_url=url, timeout=60.0) as client:
        job = ask(client, headers=key).json()["job"]
        if by == "session":
            client.post("/signin", data={"token": key["authorization"].removeprefix("Bearer ")})
        headers = {"accept": "text/event-stream", **(key if by == "key" else {})}
        seen = []
        with client.stream("GET", f"/v1/jobs/{job}/events", headers=headers) as answer:
            try:
                for line in answer.iter_lines():
                    seen.append(line)
                    if seen.count(": alive") == 4:
                        end(database)
                        time.sleep(0.5)
                        cancel(database, job)
            except httpx.RemoteProtocolError:
                pass
        assert answer.status_code == 200 and not any("cancelled" in line for line in seen), seen
        assert client.get(f"/v1/jobs/{job}/events", headers=headers).status_code == 401


def test_an_upload_ends_with_its_key(settings, database, short):
    """Broken where a key that was taken back fills the store by a request that it began before."""
    key = make_key(database, "studio")

    incoming = settings.home / "incoming"

    def send():
        yield b"ply\n"
        for _ in range(6000):  # until the server took the key, and began to keep what comes
            if incoming.exists() and list(incoming.iterdir()):
                break
            time.sleep(0.01)
        revoke(database)
        for _ in range(20):
            time.sleep(0.1)
            yield b"x" * 100

    with serving(settings, is_open=False) as url, httpx.Client(base_url=url, timeout=60.0) as client:
        try:
            answer = client.post("/v1/scans", params={"name": "a.ply"}, content=send(), headers=key)
            assert (answer.status_code, answer.json()["code"]) == (401, "key.bad")
        except httpx.WriteError:
            pass  # the refusal came before the last byte
    assert list(incoming.iterdir()) == []
    with database.read() as session:
        assert session.scalars(select(UploadRow)).all() == []


def test_a_download_ends_with_its_key(settings, database, store, short, tmp_path):
    """Broken where a key that was taken back goes on reading, or what was cut off looks whole."""
    key = make_key(database, "studio")
    with serving(settings, replace(LIMITS), is_open=False) as url, httpx.Client(base_url=url, timeout=60.0) as client:
        job = ask(client, headers=key).json()["job"]
        finish(settings, database, store, job, tmp_path / "made")
        kept = store.put_bytes(b"x" * LARGE)
        with database.write() as session:
            row = {"job": job, "kind": RESULT, "name": "large.bin", "sha256": kept.sha256, "size": kept.size}
            session.add(ArtifactRow(**row, created=1.0))
        for path in ("artifacts/large.bin", "result.zip"):
            with client.stream("GET", f"/v1/jobs/{job}/{path}", headers=key) as answer:
                assert sum(map(len, answer.iter_bytes())) >= LARGE, "who may ask gets all of it"
        for path in ("artifacts/large.bin", "result.zip"):
            with database.write() as session:
                session.execute(update(ApiKeyRow).values(revoked=None))
            with client.stream("GET", f"/v1/jobs/{job}/{path}", headers=key) as answer:
                blocks, got = answer.iter_bytes(65536), 0
                got += len(next(blocks))
                revoke(database)
                time.sleep(0.5)
                with pytest.raises(httpx.RemoteProtocolError):
                    for block in blocks:
                        got += len(block)
                assert got < LARGE
        upload(client, headers=make_key(database, "other"))
