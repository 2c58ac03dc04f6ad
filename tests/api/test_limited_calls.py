"""What is done in limited processes for requests: few at a time, a share per key, and nobody else waits for them."""

from __future__ import annotations

import json
import os
import socket
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace

import httpx
import pytest
from api_client import LIMITS, serving
from api_work import ask, code_of, make_key, upload
from garmentq.core.garment.garmentcode_writer import write_pattern
from garmentq.core.garment.templates import load_template
from garmentq.service import patterns
from garmentq_home import wait_for

SHORT = replace(LIMITS, limited=2, limited_waiting=4, limited_wait_seconds=0.2, requests_per_second=1000.0)


def is_alive(pid: int) -> bool:
    """Return whether a process lives."""
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


class Held:
    """Hold the check of every pattern until `go`, and tell which processes hold one."""

    def __init__(self, folder) -> None:
        self.folder = folder
        self.document = write_pattern(load_template("tshirt"))
        self.document["properties"]["folder"] = str(folder)

    def begun(self) -> list[int]:
        return [int(mark.stem) for mark in self.folder.glob("*.pid")]

    def alive(self) -> list[int]:
        return [pid for pid in self.begun() if is_alive(pid)]

    def go(self) -> None:
        (self.folder / "go").touch()


@pytest.fixture
def held(tmp_path, monkeypatch):
    """Return what holds the checks; they end with the test."""
    folder = tmp_path / "held"
    folder.mkdir()
    monkeypatch.setattr(patterns, "EXAMINER", "limited_calls:hold")
    found = Held(folder)
    yield found
    found.go()


@contextmanager
def open_client(url: str, key: dict[str, str]):
    """Give a client that may have many requests open."""
    with httpx.Client(base_url=url, headers=key, timeout=60.0, limits=httpx.Limits(max_connections=100)) as client:
        yield client


def send_check(client: httpx.Client, document, key) -> socket.socket:
    """Send a check on a connection of its own, and read nothing."""
    body = json.dumps(document).encode()
    head = (
        f"POST /v1/patterns/check HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: application/json\r\n"
        f"Authorization: {key['authorization']}\r\nContent-Length: {len(body)}\r\n\r\n"
    )
    opened = socket.create_connection((client.base_url.host, client.base_url.port))
    opened.sendall(head.encode() + body)
    return opened


def test_many_checks_of_one_key_hold_up_nobody(settings, database, held):
    """Broken where one key gets more than its share of processes, or anybody else waits for them.

    All is asked while the key's check is held: an answer means that it did not wait for that.
    """
    with serving(settings, SHORT, is_open=False) as url, ThreadPoolExecutor(45) as threads:
        greedy, other, third = (make_key(database, name) for name in ("greedy", "other", "third"))
        with open_client(url, greedy) as asking, open_client(url, other) as client:
            job = ask(client).json()["job"]
            first = threads.submit(asking.post, "/v1/patterns/check", json=held.document)
            wait_for(held.alive)
            more = [threads.submit(asking.post, "/v1/patterns/check", json=held.document) for _ in range(44)]
            for path in ("/healthz", "/readyz", "/v1/keys", f"/v1/jobs/{job}", "/signin", "/v1/queue"):
                answer = client.get(path)
                assert answer.status_code == (403 if path == "/v1/keys" else 200), (path, answer.text)
            signed = client.post("/signin", data={"token": other["authorization"].split()[1]})
            assert signed.status_code == 303
            for one in more:
                refused = one.result()
                assert (refused.status_code, code_of(refused)) == (429, "key.limited_open")
                assert int(refused.headers["retry-after"]) >= 1
            assert len(held.begun()) == 1
            second = threads.submit(client.post, "/v1/patterns/check", json=held.document)
            wait_for(lambda: len(held.alive()) == 2)
            full = client.post("/v1/patterns/check", json=held.document, headers=third)
            assert (full.status_code, code_of(full)) == (503, "service.limited_full")
            assert int(full.headers["retry-after"]) >= 1 and not first.done() and not second.done()
            held.go()
            assert first.result().json()["is_sound"] and second.result().json()["is_sound"]
            assert client.post("/v1/patterns/check", json=held.document, headers=third).status_code == 200


def test_every_limited_process_is_counted(settings, database, held):
    """Broken where a route calls a limited process beside the count, so that a key has more than its share."""
    with serving(settings, SHORT, is_open=False) as url, ThreadPoolExecutor(1) as threads:
        key = make_key(database, "all", "read", "submit", "admin")
        with open_client(url, key) as client:
            scan = upload(client)
            first = threads.submit(client.post, "/v1/patterns/check", json=held.document)
            wait_for(held.alive)
            edit = {"pattern": held.document, "operations": []}
            derived = {"kind": "edit", "result": "3685ecfd4f81", "files": {"pattern": scan}}
            for answer in (
                client.post("/v1/patterns/check", json=held.document),
                client.post("/v1/patterns/edit", json=edit),
                client.get("/v1/match", params={"first": "tshirt", "second": "skirt"}),
                client.get(f"/v1/scans/{scan}/inspection", params={"quick": True}),
                client.put("/v1/templates/mine", content=json.dumps(held.document)),
                client.post("/v1/jobs", json=derived),
            ):
                assert (answer.status_code, code_of(answer)) == (429, "key.limited_open"), answer.request.url
            held.go()
            assert first.result().status_code == 200


def test_a_request_waits_for_its_turn(settings, database, held):
    """Broken where a second request of a key is refused though the first one ends soon."""
    limits = replace(SHORT, limited_wait_seconds=60.0)
    with serving(settings, limits, is_open=False) as url, ThreadPoolExecutor(6) as threads:
        with open_client(url, make_key(database, "patient")) as client:
            asked = [threads.submit(client.post, "/v1/patterns/check", json=held.document) for _ in range(6)]
            wait_for(lambda: any(one.done() for one in asked))
            refused = next(one for one in asked if one.done()).result()
            assert (refused.status_code, code_of(refused)) == (429, "key.limited_open")
            held.go()
            assert sorted(one.result().status_code for one in asked) == [200] * 5 + [429]


def test_a_process_ends_with_its_request(settings, database, held):
    """Broken where a client that leaves, or an answer that is given up, leaves a process or holds the key's place."""
    limits = replace(SHORT, answer_seconds=5.0, limited_wait_seconds=60.0)
    with serving(settings, limits, is_open=False) as url:
        key = make_key(database, "fickle")
        with open_client(url, key) as client:
            with send_check(client, held.document, key):
                wait_for(held.alive)
            wait_for(lambda: not held.alive())
            late = client.post("/v1/patterns/check", json=held.document)
            assert (late.status_code, code_of(late)) == (503, "request.timeout")
            wait_for(lambda: not held.alive())
            assert len(held.begun()) == 2
            held.go()
            assert client.post("/v1/patterns/check", json=held.document).status_code == 200
