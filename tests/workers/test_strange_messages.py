"""What else than wake-ups lies in the broker's list, and a broker that goes away meanwhile, with a real Valkey."""

from __future__ import annotations

import base64
import json
import logging
from types import SimpleNamespace

import redis
from garmentq.workers.app import CHANNELS, TASK, make_app, publish
from garmentq.workers.broker import run_folder, start_broker, stop_broker
from garmentq.workers.embedded import ensure_services, is_worker_up, stop_services
from garmentq.workers.messages import MessageGuard
from garmentq_home import make_environment, wait_ended, wait_for
from patience import WAIT_SECONDS

CHANNEL = CHANNELS["cpu"]


def spoil(message, **changes):
    """Return a wake-up's bytes with some of its parts replaced."""
    return json.dumps(message | changes).encode()


def make_strange(message):
    """Return messages that are none, given one that is."""
    bad = [b"", b"[]", b"{}", b"}{", b"7", b"null", b"\xff\xfe\x00", b"[" * 5000]
    bad += [spoil(message, headers=kind) for kind in (5, [], None, {}, {"task": {}}, {"task": "no.such.task"})]
    bad += [spoil(message, properties=kind) for kind in (5, {}, {"delivery_info": 5})]
    bad += [spoil(message, body=kind) for kind in (5, "", "no base64", None)]
    words = (b"[[5], {}, {}]", b"[[], {}, {}]", b"{}", b'[["../x"], {}, {}]', b"[" * 5000, b'[["\xff"], {}, {}]')
    return bad + [spoil(message, body=base64.b64encode(word).decode()) for word in words]


def make_odd(message):
    """Return messages that name a job, with other things in them that Celery would obey or stumble over."""
    headers, properties = message["headers"], message["properties"]
    odd = [spoil(message, headers=headers | {name: 5}) for name in ("eta", "expires", "timelimit", "stamps", "id")]
    odd += [spoil(message, headers=headers | {"eta": "2999-01-01T00:00:00"})]
    odd += [spoil(message, properties=properties | {"delivery_tag": {}, "reply_to": 5})]
    return [*odd, spoil(message, **{"content-type": "application/x-python-serialize"})]


def test_what_is_no_wake_up_is_dropped(settings, database, queue_job, monkeypatch):
    """Broken where a message ends the worker, is read again and again, or takes the place of those behind it."""
    for name, value in make_environment(settings).items():
        monkeypatch.setenv(name, value)
    start_broker(settings)
    try:
        client = redis.Redis(unix_socket_path=str(run_folder(settings) / "broker.sock"))
        app = make_app(settings)
        publish(app, "nothing")
        message = json.loads(client.rpop(CHANNEL))
        app.close()
        assert message["headers"]["task"] == TASK
        strange, odd = make_strange(message), make_odd(message)
        ensure_services(settings, workers=1)
        process = (run_folder(settings) / "worker.pid").read_text()
        client.lpush(CHANNEL, *strange, *odd)
        assert wait_ended(settings, queue_job()).state == "succeeded"
        wait_for(lambda: not client.llen(CHANNEL) and not client.hlen("unacked"))
        client.close()
        assert is_worker_up(settings) and (run_folder(settings) / "worker.pid").read_text() == process
    finally:
        stop_services(settings)
    told = (settings.home / "worker.log").read_text()
    assert told.count("is not a wake-up and was dropped") == len(strange)
    assert not any(word in told for word in ("Unrecoverable", "Connection to broker lost", "Traceback"))


def test_a_message_that_cannot_be_acknowledged_leaves_its_place(settings):
    """Broken where a worker reads nothing more once the broker went away before an acknowledgement."""
    start_broker(settings)
    app, taken = make_app(settings), []
    with app.connection_for_read() as connection:
        consumer = app.amqp.TaskConsumer(connection, on_message=taken.append)
        MessageGuard(None).start(SimpleNamespace(task_consumer=consumer, app=app))
        consumer.qos(prefetch_count=1)
        with consumer:
            publish(app, "job")
            connection.drain_events(timeout=WAIT_SECONDS)
            stop_broker(settings)
            assert not consumer.channel.qos.can_consume()
            taken[0].ack_log_error(logging.getLogger(__name__), connection.connection_errors)
            assert consumer.channel.qos.can_consume()
    app.close()
