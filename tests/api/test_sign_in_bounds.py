"""What signing in costs the service, with a right key and without one."""

from __future__ import annotations

import logging
import socket
import time
from dataclasses import replace

import httpx
from api_client import LIMITS, serving
from api_work import make_key
from garmentq.service.models import SessionRow
from garmentq.service.sessions import MAX_KEY_SESSIONS, authenticate_session
from garmentq_home import wait_for
from sqlalchemy import func, select

HEAD = "POST {} HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: {}\r\nContent-Type: application/json\r\n"


def sign_in(url: str, token: str) -> httpx.Response:
    """Sign in as a new browser."""
    return httpx.post(f"{url}/signin", data={"token": token}, timeout=60.0)


def test_sessions_of_a_key_are_bounded(settings, database):
    """Broken where a right key begins any number of sessions, or one more ends another key's or the newest."""
    limits = replace(LIMITS, requests_per_second=0.001, burst=MAX_KEY_SESSIONS + 3)
    with serving(settings, limits, is_open=False) as url:
        tokens = [make_key(database, name)["authorization"].split()[1] for name in ("one", "two")]
        other = sign_in(url, tokens[1]).cookies["garmentq"]
        begun = [sign_in(url, tokens[0]).cookies["garmentq"] for _ in range(MAX_KEY_SESSIONS + 3)]
        with database.read() as session:
            assert session.scalar(select(func.count()).select_from(SessionRow)) == MAX_KEY_SESSIONS + 1
        assert authenticate_session(database, begun[3], False) and authenticate_session(database, other, False)
        browser = {"cookie": f"garmentq={begun[2]}"}
        assert httpx.get(f"{url}/", headers=browser).status_code == 303, "the oldest have ended"
        refused = sign_in(url, tokens[0])
        assert refused.status_code == 429 and int(refused.headers["retry-after"]) >= 1
        assert sign_in(url, tokens[1]).status_code == 303


def test_a_body_that_drips_is_ended(settings, database):
    """Broken where a body of a byte now and then is taken as long as a client likes."""
    limits = replace(LIMITS, chunk_seconds=30.0, body_seconds=1.0)
    with serving(settings, limits, is_open=False) as url:
        key = make_key(database, "slow")["authorization"]
        for path, more in (("/signin", ""), ("/v1/patterns/check", f"Authorization: {key}\r\n")):
            with socket.create_connection((httpx.URL(url).host, httpx.URL(url).port)) as slow:
                slow.settimeout(0.1)
                slow.sendall((HEAD.format(path, 1000) + more + "\r\n").encode())
                answer = b""
                for _ in range(300):
                    slow.sendall(b"t")
                    try:
                        answer = slow.recv(1000)
                        break
                    except TimeoutError:
                        time.sleep(0.1)
            assert answer.startswith(b"HTTP/1.1 408"), path


def test_a_client_that_leaves_is_no_fault(settings, database, caplog):
    """Broken where breaking off a body fills the log with tracebacks."""
    with serving(settings, is_open=False) as url, caplog.at_level(logging.INFO):
        key = make_key(database, "gone", "read", "submit", "admin")["authorization"]
        more = f"Authorization: {key}\r\n"
        for line in ("/signin", "/signout", "/v1/patterns/check"):
            with socket.create_connection((httpx.URL(url).host, httpx.URL(url).port)) as opened:
                opened.sendall((HEAD.format(line, 1000) + more + "\r\ntoken=").encode())
                time.sleep(0.3)
        with socket.create_connection((httpx.URL(url).host, httpx.URL(url).port)) as opened:
            opened.sendall((HEAD.format("/v1/templates/mine", 1000).replace("POST", "PUT") + more + "\r\n{").encode())
            time.sleep(0.3)
        wait_for(lambda: httpx.get(f"{url}/healthz").status_code == 200)
    assert not [record for record in caplog.records if record.exc_info]
