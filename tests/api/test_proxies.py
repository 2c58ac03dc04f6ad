"""Whose word is taken for where a request comes from, and by what name a service on this machine may be called."""

from __future__ import annotations

import threading
from contextlib import contextmanager
from functools import partial
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import httpx
import pytest
from api_client import local_user, serving
from api_work import code_of, make_key
from garmentq.service.api.proxies import read_address, read_proxies
from garmentq.service.api.server import AddressPublic, HostBad, serve
from garmentq.service.audit import list_accesses
from garmentq.service.settings import ServiceSettingBad
from garmentq_home import wait_for

NEAR, FAR = "127.0.0.1", "127.0.0.2"
"""Addresses of this machine: by default the first may be a proxy, the second is a client like any other."""

FORGED = ("8.8.8.8", "2001:db8::1", "<script>alert(1)</script>", "fe80::1%<script>", "8.8.8.8, 9.9.9.9", "", "\xff" * 9)


QUICK = {"timeout": 60.0, "verify": False}
"""No client here speaks TLS, and each that could would read all authorities first."""

ask = partial(httpx.request, **QUICK)


def calling(source: str) -> httpx.Client:
    """Return a client that asks from an address of this machine."""
    return httpx.Client(transport=httpx.HTTPTransport(local_address=source, verify=False), **QUICK)


@contextmanager
def proxying(url: str, appends: bool):
    """Pass requests on as the documented nginx does: with the client's own address, alone or behind what it sent."""

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            sent = self.headers.get("x-forwarded-for", "") if appends else ""
            headers = {name: self.headers[name] for name in ("host", "authorization") if name in self.headers}
            headers |= {"x-forwarded-for": f"{sent}, {self.client_address[0]}".removeprefix(", ")}
            headers |= {"x-forwarded-proto": "https"}
            answer = ask(self.command, url + self.path, headers={n: v.encode("latin-1") for n, v in headers.items()})
            self.send_response(answer.status_code)
            for name in ("content-type", "location", "set-cookie"):
                if name in answer.headers:
                    self.send_header(name, answer.headers[name])
            self.end_headers()
            self.wfile.write(answer.content)

        do_DELETE = do_GET

        def log_message(self, *_: object) -> None:
            pass

    server = ThreadingHTTPServer((NEAR, 0), Handler)
    thread = threading.Thread(target=server.serve_forever, args=(0.02,), daemon=True)
    thread.start()
    try:
        yield f"http://{NEAR}:{server.server_address[1]}"
    finally:
        server.shutdown()
        server.server_close()
        thread.join(10)


def ask_from(source: str, url: str, key: str, forwarded: str) -> httpx.Response:
    """Ask from an address of this machine."""
    headers = {"authorization": f"Bearer {key}", "x-forwarded-for": forwarded.encode("latin-1")}
    with calling(source) as client:
        return client.get(f"{url}/v1/jobs", headers=headers)


@pytest.mark.parametrize("way", ["straight", "appends", "replaces"])
def test_a_forged_address_is_not_believed(settings, database, way):
    """Broken where another X-Forwarded-For for each wrong key gets round the limit, or stands in the audit log."""
    key = make_key(database, "studio")
    with serving(settings, is_open=False) as url, proxying(url, way == "appends") as proxy:
        there = url if way == "straight" else proxy
        answers = [ask_from(FAR, there, "gq_wrong", FORGED[n % 7] + f"{n}" * (n % 7 == 0)) for n in range(60)]
        statuses = [answer.status_code for answer in answers]
        assert statuses.count(401) < 30 and statuses.count(429) > 30, statuses
        assert ask_from(NEAR, url, "gq_wrong", "").status_code == 401, "another address is not shut out"
        for forged in FORGED:
            hook = ask("post", f"{url}/v1/webhooks", json={"url": "https://studio.example/"}, headers=key).json()
            with calling(FAR) as client:
                headers = key | {"x-forwarded-for": forged.encode("latin-1")}
                assert client.delete(f"{there}/v1/webhooks/{hook['webhook']}", headers=headers).status_code == 200
        wait_for(lambda: sum("DELETE" in row.action for row in list_accesses(database)) == len(FORGED))
        assert {row.address for row in list_accesses(database) if "DELETE" in row.action} == {FAR}


@pytest.mark.parametrize(
    ("sent", "seen"),
    [
        ("8.8.8.8", "8.8.8.8"),
        ("1.1.1.1, 8.8.8.8", "8.8.8.8"),
        ("2001:DB8:0::1", "2001:db8::1"),
        ("::ffff:8.8.8.8", "8.8.8.8"),
        ("8.8.8.8, <script>alert(1)</script>", NEAR),
        ("8.8.8.8,", NEAR),
        ("8.8.8.8:80", NEAR),
    ],
)
def test_a_proxy_of_this_machine_is_believed_by_its_last_entry(settings, database, sent, seen):
    """Broken where all clients of a proxy are one address, or the log takes what is no address."""
    key = make_key(database, "studio")
    with serving(settings, is_open=False) as url:
        headers = key | {"x-forwarded-for": sent}
        assert ask("post", f"{url}/v1/webhooks", json={"url": "https://a.example/"}, headers=headers).status_code == 201
        wait_for(lambda: list_accesses(database))
    assert [row.address for row in list_accesses(database)] == [seen]


def test_the_operator_says_who_is_a_proxy(settings, database, monkeypatch):
    """Broken where a proxy on another host cannot be named, one on this host cannot be left out, or a word is taken."""
    seen = []
    make = {"json": {"url": "https://a.example/"}, "headers": make_key(database, "a") | {"x-forwarded-for": "8.8.8.8"}}
    for chosen, source in (("127.0.0.0/24, ::1", FAR), (FAR, NEAR), ("none", NEAR)):
        monkeypatch.setenv("GARMENTQ_API_PROXIES", chosen)
        with serving(settings, is_open=False) as url:
            with calling(source) as client:
                client.post(f"{url}/v1/webhooks", **make).raise_for_status()
            wait_for(lambda: len(list_accesses(database)) > len(seen))
        seen.append(list_accesses(database)[0].address)
    assert seen == ["8.8.8.8", NEAR, NEAR]
    for wrong in ("localhost", "10.0.0.0/33", "10.0.0.1 10.0.0.2", "*", "none,10.0.0.1"):
        with pytest.raises(ServiceSettingBad):
            read_proxies({"GARMENTQ_API_PROXIES": wrong})
    assert read_proxies({"GARMENTQ_API_PROXIES": "none"}) == [] and len(read_proxies({})) == 2
    assert read_address("fe80::1%<script>") == "fe80::1"


def test_a_proxy_can_stand_before_a_service_on_this_machine(settings, database, cli):
    """Broken where the documented proxy is refused for its Host, a foreign page is let in with it, or keys are not
    asked for."""
    name = "garmentq.example"
    with serving(settings, hosts=(name,)) as url, proxying(url, False) as proxy:
        assert ask("get", f"{proxy}/v1/jobs", headers={"host": name, **local_user(settings)}).status_code == 401
        key = make_key(database, "studio") | {"host": name}
        assert ask("get", f"{proxy}/v1/jobs", headers=key).status_code == 200
        form = {"data": {"token": key["authorization"].removeprefix("Bearer ")}}
        ours = {"host": name, "origin": f"https://{name}", "x-forwarded-proto": "https"}
        signed = ask("post", f"{url}/signin", headers=ours, **form)
        assert signed.status_code == 303 and "__Host-garmentq=" in signed.headers["set-cookie"]
        assert "Secure" in signed.headers["set-cookie"]
        for headers in ({"host": "evil.example"}, {"host": name, "origin": "https://evil.example"}):
            answer = ask("get", f"{url}/v1/jobs", headers=key | headers)
            assert (answer.status_code, code_of(answer)) == (403, "request.foreign_origin"), headers
    with serving(settings) as url:
        assert ask("get", f"{url}/v1/jobs", headers=key).status_code == 403
    for wrong in ("https://garmentq.example", "garmentq.example:443", "a b", "", "*"):
        with pytest.raises(HostBad):
            serve(settings, "127.0.0.1", 1, hosts=[wrong])
    refused = cli("serve", "--allow-host", "a/b")
    assert refused.returncode == 2 and "serve.host_bad" in refused.stderr


def test_a_service_behind_a_proxy_needs_a_key(settings, database, cli):
    """Broken where whoever comes by the proxy meets a service without keys."""
    with pytest.raises(AddressPublic):
        serve(settings, "127.0.0.1", 1, hosts=["garmentq.example"])
    refused = cli("serve", GARMENTQ_API_ALLOW_HOST="garmentq.example")
    assert "serve.keys_missing" in refused.stderr and "?link=" not in refused.stderr
