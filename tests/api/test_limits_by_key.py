"""What one key may take: requests, uploads at a time, bytes of a day, open jobs; a refusal tells when to come back."""

from __future__ import annotations

import socket
import time
from dataclasses import replace

import httpx
import pytest
from api_client import LIMITS, serving
from api_work import ask, code_of, finish, make_key, make_ply, upload
from garmentq.core.run.errors import GarmentqError
from garmentq.service.api.limits import ApiLimits, read_limits
from garmentq.service.api.meter import Meter, TooManyRequests
from garmentq.service.jobs import claim, end_cancelled
from garmentq.service.models import UploadRow
from garmentq.service.remote import RemoteBackend
from garmentq.service.settings import ServiceSettingBad


def test_the_bucket_fills_as_it_says():
    """Broken where a key gets more or less than burst + rate x time, or pays for another key."""
    now = [100.0]
    meter = Meter(replace(ApiLimits(), requests_per_second=2.0, burst=3), lambda: now[0])

    def count(key, most=100):
        for done in range(most):
            try:
                meter.take(key)
            except TooManyRequests as error:
                return done, error.retry_seconds
        return most, 0.0

    assert count("a") == (3, 0.5) and count("b") == (3, 0.5)
    now[0] += 0.25
    assert count("a") == (0, 0.25)
    now[0] += 10.0
    assert count("a") == (3, 0.5)
    assert count("", 1000) == (1000, 0.0)


def test_too_many_requests(settings, database):
    """Broken where a key's requests are not bounded, another key suffers, or the client does not wait its turn."""
    limits = replace(LIMITS, requests_per_second=1.0, burst=3)
    with serving(settings, limits, is_open=False) as url, httpx.Client(base_url=url) as client:
        first, second = make_key(database, "first"), make_key(database, "second")
        answers = [client.get("/v1/jobs", headers=first) for _ in range(6)]
        refused = [answer for answer in answers if answer.status_code == 429]
        assert len(refused) >= 1 and answers[0].status_code == 200
        assert code_of(refused[0]) == "key.too_many_requests" and int(refused[0].headers["retry-after"]) >= 1
        assert client.get("/v1/jobs", headers=second).status_code == 200
        assert client.get("/healthz").status_code == 200
        with RemoteBackend(url, second["authorization"].split()[1]) as patient:
            for _ in range(3):
                assert patient.list_jobs() == []


def test_uploads_at_a_time(settings, database):
    """Broken where one key holds any number of uploads open, or one that broke off is counted for ever."""
    limits = replace(LIMITS, uploads=1, chunk_seconds=30.0)
    with serving(settings, limits, is_open=False) as url, httpx.Client(base_url=url) as client:
        first, second = make_key(database, "first"), make_key(database, "second")
        head = (
            "POST /v1/scans?name=a.ply HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 1000\r\nAuthorization: {}\r\n\r\n"
        )
        with socket.create_connection((client.base_url.host, client.base_url.port), timeout=10) as slow:
            slow.sendall(head.format(first["authorization"]).encode() + b"ply\n")
            deadline = time.monotonic() + 10
            while not list((settings.home / "incoming").glob("*")) and time.monotonic() < deadline:
                time.sleep(0.02)
            refused = client.post("/v1/scans", params={"name": "b.ply"}, content=make_ply(), headers=first)
            assert (refused.status_code, code_of(refused)) == (429, "key.uploads_open")
            assert int(refused.headers["retry-after"]) >= 1
            assert upload(client, headers=second)
        deadline = time.monotonic() + 10
        while list((settings.home / "incoming").iterdir()) and time.monotonic() < deadline:
            time.sleep(0.02)
        assert upload(client, headers=first)


def test_bytes_of_a_day(settings, database):
    """Broken where a key fills the store, the same file counts twice, or yesterday counts."""
    size = len(make_ply())
    limits = replace(LIMITS, day_bytes=2 * size + 10)
    with serving(settings, limits, is_open=False) as url, httpx.Client(base_url=url) as client:
        first, second = make_key(database, "first"), make_key(database, "second")
        for mark in (0.1, 0.2):
            upload(client, mark, headers=first)
        told = client.post("/v1/scans", params={"name": "c.ply"}, content=make_ply(0.3), headers=first)
        parts = (make_ply(0.3)[at : at + 50] for at in range(0, size, 50))
        untold = client.post("/v1/scans", params={"name": "c.ply"}, content=parts, headers=first)
        for refused in (told, untold):
            assert (refused.status_code, code_of(refused)) == (429, "key.day_bytes"), refused.text
            assert 80_000 < int(refused.headers["retry-after"]) <= 86_400
        assert upload(client, 0.3, headers=second)
        with database.write() as session:
            for row in session.query(UploadRow):
                row.created -= 90_000.0
        assert upload(client, 0.3, headers=first)
        assert list((settings.home / "incoming").iterdir()) == []


def test_number_of_uploads(settings, database):
    """Broken where small files fill tables and store for ever, or the same file counts twice."""
    for limits, status, code in (({"day_files": 2}, 429, "key.day_files"), ({"files": 2}, 422, "key.uploads_full")):
        with (
            serving(settings, replace(LIMITS, **limits), is_open=False) as url,
            httpx.Client(base_url=url) as client,
        ):
            first, second = make_key(database, "first"), make_key(database, "second")
            for mark in (0.1, 0.1, 0.2):
                scan = upload(client, mark, headers=first)
            refused = client.post("/v1/scans", params={"name": "c.ply"}, content=make_ply(0.3), headers=first)
            assert (refused.status_code, code_of(refused)) == (status, code), refused.text
            assert upload(client, 0.3, headers=second)
            assert client.delete(f"/v1/scans/{scan}", headers=first).status_code == 200
            assert upload(client, 0.3, headers=first)


def test_open_jobs(settings, database, store, tmp_path):
    """Broken where a running job frees its place before it ended, so that a key can hold every worker."""
    with serving(settings, is_open=False) as url, httpx.Client(base_url=url) as client:
        key = make_key(database, "small", quota=1)
        first = ask(client, 0.1, headers=key).json()["job"]
        held = claim(database, first, "test", 60.0)
        refused = ask(client, 0.2, headers=key)
        assert held and (refused.status_code, code_of(refused)) == (429, "key.queue_full")
        assert int(refused.headers["retry-after"]) >= 1
        client.post(f"/v1/jobs/{first}/cancel", headers=key)
        end_cancelled(database, held)
        second = ask(client, 0.2, headers=key).json()["job"]
        refused = client.post(f"/v1/jobs/{first}/retry", headers=key)
        assert (refused.status_code, code_of(refused)) == (429, "key.queue_full")
        finish(settings, database, store, second, tmp_path / "made")
        assert client.post(f"/v1/jobs/{first}/retry", headers=key).status_code == 202


def test_limits_come_from_the_environment(cli, monkeypatch):
    """Broken where an operator cannot change a limit, or a misspelt number is taken for the default."""
    read = read_limits({"GARMENTQ_API_BURST": "7", "GARMENTQ_API_REQUESTS_PER_SECOND": "0.5", "GARMENTQ_API_KEY": "x"})
    assert read == replace(ApiLimits(), burst=7, requests_per_second=0.5)
    chosen = []
    monkeypatch.setattr("garmentq.service.api.server.serve", lambda *given, **more: chosen.append(given[3]))
    assert cli("serve", GARMENTQ_API_BURST="7", GARMENTQ_API_UPLOAD_BYTES="9").returncode == 0
    assert cli("serve", "--max-upload-mb", "3", GARMENTQ_API_UPLOAD_BYTES="9").returncode == 0
    assert chosen == [replace(ApiLimits(), burst=7, upload_bytes=9), replace(ApiLimits(), upload_bytes=3 << 20)]
    assert cli("serve", GARMENTQ_API_BURST="x").returncode == 2
    for text in ("seven", "0", "-1", "inf", "nan"):
        with pytest.raises(ServiceSettingBad) as error:
            read_limits({"GARMENTQ_API_REQUESTS_PER_SECOND": text})
        assert isinstance(error.value, GarmentqError)
