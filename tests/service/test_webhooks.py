"""Webhooks: what is owed and to whom, what is sent and where to; real servers, and a resolver that lies."""

from __future__ import annotations

import asyncio
import ipaddress
import json
import os
import signal
import socket
import ssl
import subprocess
import sys
import threading
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest
from garmentq.service import webhook_delivery
from garmentq.service.deletion import delete_jobs
from garmentq.service.jobs import claim, fail
from garmentq.service.keys import create_key, revoke_key
from garmentq.service.models import DeliveryRow, OwnerRow, WebhookRow
from garmentq.service.states import State
from garmentq.service.webhook_address import AddressForbidden, WebhookBad, check_url, is_public
from garmentq.service.webhook_delivery import send, sign
from garmentq.service.webhook_records import Receipt
from garmentq.service.webhooks import (
    MAX_DELIVERY_PAUSE,
    MAX_DELIVERY_TRIES,
    MAX_KEY_WEBHOOKS,
    Message,
    WebhooksFull,
    claim_due_messages,
    create_webhook,
    delete_webhook,
    find_pause,
    forget_messages,
    has_due,
    list_webhooks,
    note_receipt,
    rotate_secret,
)
from garmentq.workers.courier import deliver
from garmentq_home import make_environment, wait_for
from self_signed import write_certificate

TAKEN, REFUSED = Receipt(204, None), Receipt(500, "the answer was 500, not 2xx")
NEAR, FAR = "127.0.0.2/32", "127.0.0.1"
"""The network that the tests allow, and an address beside it that stays forbidden."""

sqlite_only = pytest.mark.parametrize("database_kind", ["sqlite"], indirect=True)


class Receiver(ThreadingHTTPServer):
    """Keep what was sent, and answer as the path asks."""

    def __init__(self, host: str) -> None:
        super().__init__((host, 0), Handler)
        self.got: list[tuple[dict[str, str], bytes]] = []
        self.go_on = threading.Event()

    def url(self, path: str = "/", name: str = "", scheme: str = "http") -> str:
        return f"{scheme}://{name or self.server_address[0]}:{self.server_address[1]}{path}"


class Handler(BaseHTTPRequestHandler):
    """Answer 204, or what the path says: a status, a redirect, slowly, not before it may."""

    def do_POST(self) -> None:
        body = self.rfile.read(int(self.headers["content-length"]))
        self.server.got.append(({name.lower(): value for name, value in self.headers.items()}, body))
        words = self.path.strip("/").split("?")[0].split(",")
        if words[0] == "wait":
            self.server.go_on.wait(20)
        if words[0] == "drip":
            for letter in b"HTTP/1.1 200 OK" * 4:
                self.wfile.write(bytes([letter]))
                if self.server.go_on.wait(0.1):
                    return
        self.send_response(int(words[0]) if words[0].isdigit() else 204)
        if len(words) > 1:
            self.send_header("location", words[1].replace("!", "/"))
        self.end_headers()

    def log_message(self, *_: object) -> None:
        pass


@contextmanager
def receiving(host: str = "127.0.0.2", context: ssl.SSLContext | None = None):
    """Run a receiver for the block."""
    server = Receiver(host)
    if context is not None:
        server.socket = context.wrap_socket(server.socket, server_side=True)
    thread = threading.Thread(target=server.serve_forever, args=(0.02,), daemon=True)
    thread.start()
    try:
        yield server
    finally:
        server.go_on.set()
        server.shutdown()
        server.server_close()
        thread.join(10)


@pytest.fixture
def end_job(database, queue_job):
    """Return a function that queues a job of a name for a key, and ends it as failed."""

    def end(name: str = "shirt", key: str = "") -> str:
        job = queue_job(name)
        if key:
            with database.write() as session:
                session.add(OwnerRow(key=key, job=job))
        fail(database, claim(database, job, "a", 30.0), "scan.x", "bad", bad_input=True)
        return job

    return end


def make_hook(database, url="http://127.0.0.2:1/", states=(), key=""):
    """Make a webhook that may go to the test's network."""
    return create_webhook(database, url, states, NEAR, key)[0]


def let_go(database):
    """Let all pauses and leases of senders be over."""
    with database.write() as session:
        session.query(WebhookRow).update({"taken_until": 0.0})
        session.query(DeliveryRow).filter(DeliveryRow.due.is_not(None)).update({"due": 1.0})


def test_the_signature_is_that_of_the_standard():
    """Broken where a receiver's library for Standard Webhooks refuses a message: its published example."""
    found = sign(
        "whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw", "msg_p5jXN8AQM9LWM0D4loKWxJek", 1614265330, b'{"test": 2432232314}'
    )
    assert found == "v1,g0hM9SsE+OTPJTGt/tmIKtSyZlE3uFJELVlNIOLJ1OE="


@pytest.mark.parametrize(
    "address",
    "127.0.0.1 10.0.0.1 172.16.0.1 192.168.1.1 169.254.169.254 100.64.0.1 0.0.0.0 224.0.0.1 240.0.0.1 255.255.255.255 "
    "192.0.2.1 198.18.0.1 192.88.99.1 ::1 :: fe80::1 fc00::1 fd12::1 ff02::1 fec0::1 ::ffff:127.0.0.1 ::ffff:8.8.8.8 "
    "64:ff9b::7f00:1 2002:7f00:1:: 2001:0:7f00:1:: 2001:db8::1 ::127.0.0.1".split(),
)
def test_what_is_not_public(address):
    """Broken where a webhook reaches the service's own network, or the cloud's metadata."""
    one = ipaddress.ip_address(address)
    assert not is_public(one)
    with pytest.raises(AddressForbidden):
        check_url(f"https://[{one}]/" if one.version == 6 else f"https://{one}/", "")


def test_what_is_public():
    """Broken where the internet is refused."""
    assert all(is_public(ipaddress.ip_address(one)) for one in ("8.8.8.8", "93.184.216.34", "2606:4700::1111"))


@pytest.mark.parametrize(
    "url",
    ["ftp://a.example/", "http://a.example/", "https://u:p@a.example/", "https:///x", "https://a.example/#f", "x",
     "https://a.example:99999/", "https://a.example/\r\nx: y", "https://\u00e4.example/",
     "https://a.example/" + "x" * 2000],
)  # fmt: skip
def test_what_is_no_webhook(url):
    """Broken where an address is kept that cannot be sent to, or splits a head."""
    with pytest.raises(WebhookBad):
        check_url(url, "")


def test_who_is_told_of_what(database, store, end_job):
    """Broken where a key learns of another's job, a state comes unasked, or a deleted job or revoked key goes on."""
    (one, _), (two, _) = (create_key(database, name, ("read",)) for name in "ab")
    every, mine = make_hook(database), make_hook(database, key=one.id)
    make_hook(database, key=one.id, states=[State.SUCCEEDED])
    other = make_hook(database, key=two.id)
    job = end_job("shirt", one.id)
    taken = {message.body["id"]: message for message in claim_due_messages(database, 9)}
    assert [(hook.id, hook.owed) for hook in list_webhooks(database) if hook.owed] == [(every.id, 1), (mine.id, 1)]
    assert len(taken) == 2 and all(message.id == mark for mark, message in taken.items())
    body = next(iter(taken.values())).body
    assert body["type"] == "job.failed" and body["job"]["job"] == job and body["job"]["name"] == "shirt"
    assert body["job"]["error"] == {"code": "scan.x", "message": "bad"} and body["at"] > 1e9
    assert [hook.id for hook in list_webhooks(database, two.id)] == [other.id]
    revoke_key(database, one.id)
    let_go(database)
    assert len(claim_due_messages(database, 9)) == 1, "not the revoked key's"
    assert forget_messages(database) == 1
    delete_jobs(database, store, [job])
    let_go(database)
    assert not has_due(database)
    note_receipt(database, body["id"], TAKEN)
    delete_webhook(database, every.id)


def test_sent_again_until_taken_and_not_for_ever(database, end_job):
    """Broken where a message is lost with its sender, two go at once, the pauses do not grow, or nobody gives up."""
    hook = make_hook(database)
    end_job("one"), end_job("two")
    (first,) = claim_due_messages(database, 9)
    assert claim_due_messages(database, 9) == [] and not has_due(database), "one at a time to one address"
    let_go(database)
    assert claim_due_messages(database, 9) == [first], "its sender died: again, under the same id"
    with database.write() as session:
        session.query(WebhookRow).update({"taken_until": 1e12})
    assert claim_due_messages(database, 9) == [first], "the clock was set back"
    note_receipt(database, first.id, TAKEN)
    (second,) = claim_due_messages(database, 9)
    assert second.id != first.id
    for tries in range(1, MAX_DELIVERY_TRIES + 1):
        note_receipt(database, second.id, REFUSED)
        assert not has_due(database), "it rests"
        assert list_webhooks(database)[0].owed == int(tries < MAX_DELIVERY_TRIES)
        let_go(database)
    assert not has_due(database), "given up"
    (shown,) = list_webhooks(database)
    assert (shown.id, shown.status, shown.error) == (hook.id, 500, REFUSED.error) and shown.served > 1e9
    pauses = [find_pause(tries) for tries in range(1, MAX_DELIVERY_TRIES)]
    assert pauses == sorted(pauses) and pauses[0] == 10.0 and pauses[-1] == MAX_DELIVERY_PAUSE
    assert forget_messages(database) == 0


@sqlite_only
def test_whoever_was_served_longest_ago_is_next(database, end_job):
    """Broken where one address that answers slowly, or many messages to it, keep the others waiting."""
    hooks = [make_hook(database) for _ in range(MAX_KEY_WEBHOOKS)]
    with pytest.raises(WebhooksFull):
        make_hook(database)
    end_job("one"), end_job("two")
    urls = {}
    for _ in range(len(hooks)):
        (message,) = claim_due_messages(database, 1)
        with database.read() as session:
            urls[session.get(DeliveryRow, message.id).webhook] = message
        note_receipt(database, message.id, REFUSED)
    assert len(urls) == len(hooks)


@sqlite_only
def test_a_message_arrives_signed(database, end_job):
    """Broken where a receiver cannot tell that it is ours, or sees a message that it took once more."""
    with receiving() as server:
        hook, secret = create_webhook(database, server.url("/in?a=b"), (), NEAR)
        job = end_job()
        assert asyncio.run(deliver(database, NEAR)) == 1 and asyncio.run(deliver(database, NEAR)) == 0
        ((head, body),) = server.got
    assert json.loads(body)["job"]["job"] == job
    assert head["webhook-signature"] == sign(secret, head["webhook-id"], int(head["webhook-timestamp"]), body)
    assert head["webhook-id"] == json.loads(body)["id"] and head["content-type"] == "application/json"
    (shown,) = list_webhooks(database)
    assert (shown.id, shown.status, shown.error, shown.owed) == (hook.id, 204, None, 0)


def test_a_message_has_both_signatures_after_a_rotation(database, end_job):
    """Broken where a receiver that has one of the two secrets refuses the message, or a third one is taken."""
    with receiving() as server:
        hook, first = create_webhook(database, server.url("/in"), (), NEAR)
        _, second = rotate_secret(database, hook.id)
        end_job()
        assert asyncio.run(deliver(database, NEAR)) == 1
        ((head, body),) = server.got
    at = int(head["webhook-timestamp"])
    assert head["webhook-signature"].split() == [sign(one, head["webhook-id"], at, body) for one in (second, first)]


@sqlite_only
def test_the_networks_are_asked_when_a_message_goes(database, end_job):
    """Broken where an address that was allowed once is reached for ever."""
    with receiving() as server:
        create_webhook(database, server.url(), (), NEAR)
        end_job()
        asyncio.run(deliver(database, ""))
        assert server.got == []
    assert list_webhooks(database)[0].owed == 1


def message_to(url: str) -> Message:
    """Make a message to an address."""
    return Message("1", url, "whsec_AAAA", {"id": "1"})


def ask_of(server: Receiver, path: str = "/", name: str = "", scheme: str = "http", context=None) -> Receipt:
    """Send a message to a receiver."""
    return asyncio.run(send(message_to(server.url(path, name, scheme)), NEAR, context))


@pytest.fixture
def resolver(monkeypatch):
    """Answer each question for `hook.test` by the next of some lists of addresses, then always the last."""
    real, plan, asked = socket.getaddrinfo, [], []

    def find(host, port, *given, **more):
        if host != "hook.test":
            return real(host, port, *given, **more)
        asked.append(host)
        answer = plan.pop(0) if len(plan) > 1 else plan[0]
        return [(socket.AF_INET, socket.SOCK_STREAM, 6, "", (one, port)) for one in answer]

    monkeypatch.setattr(socket, "getaddrinfo", find)
    return plan, asked


def test_the_address_that_was_checked_is_the_one_reached(resolver):
    """Broken by DNS rebinding: a name that is public when it is checked and private when it is connected to."""
    plan, asked = resolver
    with receiving() as good, receiving(FAR) as bad:
        for answers in ([["127.0.0.2"], [FAR]], [["127.0.0.2", FAR]], [[FAR]], [["10.0.0.1"]]):
            plan[:], asked[:] = answers, []
            port = bad.server_address[1] if answers[0][0] == FAR else good.server_address[1]
            receipt = asyncio.run(send(message_to(f"http://hook.test:{port}/"), NEAR))
            assert asked == ["hook.test"], "once, and no more"
            if answers[0] == ["127.0.0.2"]:
                assert receipt == TAKEN and good.got[0][0]["host"] == f"hook.test:{port}"
            else:
                assert receipt.status is None and "no public address" in receipt.error
        assert len(good.got) == 1 and bad.got == []


@pytest.mark.parametrize("host", ["localhost", "2130706433", "0x7f.1", "0177.0.0.1", "127.1"])
def test_other_names_of_this_machine(host):
    """Broken where a way to write 127.0.0.1 that only the resolver understands passes."""
    with receiving(FAR) as bad:
        for scheme in ("http", "https"):
            receipt = ask_of(bad, name=host, scheme=scheme)
            assert receipt.status is None and receipt.error
        assert bad.got == []


def test_no_redirect_is_followed():
    """Broken where a receiver sends the service on to an address that it may not reach."""
    with receiving() as good, receiving(FAR) as bad:
        for status in (301, 302, 307, 308):
            target = bad.url("/").replace("/", "!")
            assert ask_of(good, f"/{status},{target}") == Receipt(status, f"the response was {status}, not 2xx")
        assert len(good.got) == 4 and bad.got == []


def test_no_answer_takes_longer_than_its_time(monkeypatch):
    """Broken where a receiver that says a byte at a time, or nothing, holds a sender."""
    monkeypatch.setattr(webhook_delivery, "WEBHOOK_DELIVERY_TIMEOUT", 0.4)
    with receiving() as server:
        for path in ("/drip", "/wait"):
            assert ask_of(server, path) == Receipt(None, "no response within 0.4 s")
    closed = socket.socket()
    closed.bind(("127.0.0.2", 0))
    with closed:
        receipt = asyncio.run(send(message_to(f"http://127.0.0.2:{closed.getsockname()[1]}/"), NEAR))
    assert receipt.status is None and "does not respond" in receipt.error


def test_tls_is_that_of_the_name(resolver, tmp_path):
    """Broken where the certificate of another name, or of nobody, is believed; the connection goes to the address."""
    server_side, trusting = make_contexts(tmp_path, "hook.test")
    resolver[0].append(["127.0.0.2"])
    with receiving(context=server_side) as server:
        assert ask_of(server, name="hook.test", scheme="https", context=trusting) == TAKEN
        assert ask_of(server, name="hook.test", scheme="https").status is None, "of nobody that the system trusts"
        assert ask_of(server, scheme="https", context=trusting).status is None, "of another name"
        assert len(server.got) == 1


def make_contexts(folder, name: str) -> tuple[ssl.SSLContext, ssl.SSLContext]:
    """Make a certificate of a name that signs itself; give the contexts of a server and of who trusts it."""
    certificate, key = write_certificate(folder, name)
    server = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    server.load_cert_chain(certificate, key)
    return server, ssl.create_default_context(cafile=certificate)


@sqlite_only
def test_a_killed_sender_loses_nothing(settings, database, end_job):
    """Broken where a message that was on its way when its sender was killed is lost, or comes under another id."""
    with receiving() as server:
        create_webhook(database, server.url("/wait"), (), NEAR)
        end_job()
        environment = make_environment(settings) | {"GARMENTQ_WEBHOOK_NETWORKS": NEAR}
        courier = subprocess.Popen([sys.executable, "-m", "garmentq.workers.courier"], env=environment)
        wait_for(lambda: server.got)
        os.kill(courier.pid, signal.SIGKILL)
        courier.wait()
        server.go_on.set()
        assert not has_due(database), "its lease has not ended"
        let_go(database)
        assert asyncio.run(deliver(database, NEAR)) == 1
        assert len({head["webhook-id"] for head, _ in server.got}) == 1 and len(server.got) == 2
    assert list_webhooks(database)[0].owed == 0
