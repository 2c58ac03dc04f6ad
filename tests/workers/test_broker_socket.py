"""A broker of one's own on a unix socket, spelt as Celery does and as redis-py does, with a real Valkey."""

from __future__ import annotations

import subprocess
from dataclasses import replace

import pytest
import redis
from garmentq.workers.app import make_app
from garmentq.workers.broker import BrokerRefused, BrokerUnreachable, check_broker, find_server
from garmentq_home import wait_for
from patience import WAIT_SECONDS

SECRET = "gehe1m"


@pytest.fixture
def place(tmp_path):
    """Start a Valkey on a socket that asks for a password; gives the socket's path."""
    path = tmp_path / "v.sock"
    words = ["--port", "0", "--unixsocket", str(path), "--requirepass", SECRET, "--save", "", "--dir", str(tmp_path)]
    server = subprocess.Popen([str(find_server()), *words], stdout=subprocess.DEVNULL)
    wait_for(path.exists)
    yield path
    server.terminate()
    server.wait(timeout=WAIT_SECONDS)


@pytest.mark.parametrize(("beginning", "number"), [("redis+socket://", "virtual_host"), ("unix://", "db")])
def test_both_spellings_reach_it(settings, place, beginning, number):
    """Broken where one of the addresses is refused, or the check and the queue are in different databases."""
    chosen = replace(settings, broker_url=f"{beginning}:{SECRET}@{place}?{number}=3")
    check_broker(chosen)
    with make_app(chosen).connection_for_write() as connection:
        queue = connection.SimpleQueue("somewhere")
        queue.put({"job": "3685ecfd4f81"})
        with redis.Redis(unix_socket_path=str(place), password=SECRET, db=3) as seen:
            assert seen.llen("somewhere") == 1
        message = queue.get(timeout=WAIT_SECONDS)
        assert message.payload == {"job": "3685ecfd4f81"}
        message.ack()
        queue.close()
    with pytest.raises(BrokerRefused):
        check_broker(replace(settings, broker_url=f"{beginning}{place}"))
    with pytest.raises(BrokerUnreachable):
        check_broker(replace(settings, broker_url=f"{beginning}:{SECRET}@{place}x"))
