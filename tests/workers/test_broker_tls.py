"""A broker behind TLS and a password: reached where its certificate can be trusted, and only there."""

from __future__ import annotations

import socket
import ssl
import subprocess
import threading
from contextlib import suppress

import pytest
from garmentq.workers.app import count_messages, make_app, publish
from garmentq.workers.broker import find_server, is_broker_up
from garmentq_home import make_settings, wait_for
from patience import WAIT_SECONDS
from self_signed import write_certificate


def pump(source, sink):
    """Hand bytes on until one side closes."""
    with suppress(OSError):
        while block := source.recv(65536):
            sink.sendall(block)
    for end in (source, sink):
        with suppress(OSError):
            end.shutdown(socket.SHUT_RDWR)
        end.close()


def serve_tls(listener, context, target):
    """Take TLS connections and hand what they say on to the broker."""
    while True:
        try:
            plain, _ = listener.accept()
        except OSError:
            return
        try:
            front = context.wrap_socket(plain, server_side=True)
        except OSError:
            plain.close()
            continue
        back = socket.create_connection(target)
        for pair in ((front, back), (back, front)):
            threading.Thread(target=pump, args=pair, daemon=True).start()


@pytest.fixture
def broker(tmp_path):
    """Start a Valkey with a password behind a TLS port; gives the port."""
    certificate, key = write_certificate(tmp_path)
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        target = probe.getsockname()
    command = [
        str(find_server()),
        "--port",
        str(target[1]),
        "--bind",
        target[0],
        "--requirepass",
        "pssst",
        "--save",
        "",
    ]
    server = subprocess.Popen([*command, "--dir", str(tmp_path)], stdout=subprocess.DEVNULL)
    plain = make_settings(tmp_path, broker_url=f"redis://:pssst@127.0.0.1:{target[1]}/0")
    wait_for(lambda: is_broker_up(plain))
    context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
    context.load_cert_chain(certificate, key)
    listener = socket.create_server(("127.0.0.1", 0))
    threading.Thread(target=serve_tls, args=(listener, context, target), daemon=True).start()
    yield listener.getsockname()[1]
    with suppress(OSError):
        listener.shutdown(socket.SHUT_RDWR)
    listener.close()
    server.terminate()
    server.wait(timeout=WAIT_SECONDS)


def test_a_broker_behind_tls(broker, tmp_path):
    """Broken where a `rediss://` address is not understood, or a certificate that nobody trusts is accepted."""
    address = f"rediss://:pssst@127.0.0.1:{broker}/0"
    assert not is_broker_up(make_settings(tmp_path, broker_url=f"{address}?ssl_cert_reqs=required"))
    stranger = make_settings(tmp_path, broker_url=address)
    assert not is_broker_up(stranger)
    app = make_app(stranger)
    with pytest.raises(Exception, match="CERTIFICATE_VERIFY_FAILED"):  # Celery alone takes any where none is asked for
        publish(app, "0" * 12, "cpu")
    app.close()
    address = (
        address.removesuffix("0") + "1"
    )  # Celery pools connections by host and number, whatever their certificates
    trusted = make_settings(tmp_path, broker_url=f"{address}?ssl_cert_reqs=required&ssl_ca_certs={tmp_path}/own.pem")
    assert is_broker_up(trusted)
    app = make_app(trusted)
    publish(app, "0" * 12, "cpu")
    assert count_messages(app) == 1
    app.close()
