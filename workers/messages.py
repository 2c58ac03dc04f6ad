"""Only a job's id is believed of a message: what holds none is told in the log and dropped, and the worker lives on.

A message that cannot be acknowledged, because the broker is away, does not keep others from being read. Celery ends a
worker whose reading of a message fails, and obeys what a message says of times and replies.
"""

from __future__ import annotations

import base64
import json
import logging
import re
import uuid
from collections.abc import Callable
from queue import Empty
from typing import Any

from celery import Celery, bootsteps
from kombu.transport import virtual
from redis import RedisError

from .app import TASK

log = logging.getLogger(__name__)

JOB = re.compile(r"[0-9A-Za-z_-]{1,64}")
"""What may be a job's id."""


class MessageGuard(bootsteps.StartStopStep):
    """Guard how a worker's connection reads messages; a new connection is guarded anew."""

    requires = ("celery.worker.consumer.tasks:Tasks",)

    def start(self, consumer: Any) -> None:
        """Put the guard around the reader."""
        channel, app = consumer.task_consumer.channel, consumer.app
        original = channel.Message

        class WakeUp(original):  # type: ignore[misc, valid-type]
            """A message of which only the job's id is kept."""

            def __init__(self, payload: Any, channel: Any = None, **rest: Any) -> None:
                super().__init__(make_wake_up(app, payload), channel=channel, **rest)

            def ack(self, multiple: bool = False) -> None:
                """Acknowledge; where the broker is away the message is forgotten all the same.

                Celery only logs that. The message would take its place for ever, and no other would be read.
                """
                try:
                    super().ack(multiple)
                except (OSError, RedisError):
                    virtual.QoS.ack(self.channel.qos, self.delivery_tag)  # type: ignore[no-untyped-call]
                    raise

        channel.Message = WakeUp
        channel.handlers["BRPOP"] = _guard(channel.handlers["BRPOP"])


def make_wake_up(app: Celery, payload: Any) -> dict[str, Any]:
    """Return a message for the job that one from the broker names; nothing else of it is kept.

    Args:
        app: The application that made the message, if it is a wake-up.
        payload: What the broker gave, as JSON values.

    Raises:
        ValueError, TypeError, LookupError, RecursionError: where it names no job.
    """
    job = json.loads(base64.b64decode(payload["body"]))[0][0]
    if payload["headers"]["task"] != TASK or not JOB.fullmatch(job):
        raise ValueError("no wake-up")
    made = app.amqp.as_task_v2(uuid.uuid4().hex, TASK, (job,), ignore_result=True)
    place = {"exchange": "", "routing_key": str(payload["properties"]["delivery_info"]["routing_key"])}
    tag = {"delivery_tag": uuid.uuid4().hex, "delivery_info": place, "body_encoding": "base64"}
    return {
        "body": base64.b64encode(json.dumps(made.body).encode()).decode(),
        "content-type": "application/json",
        "content-encoding": "utf-8",
        "headers": made.headers,
        "properties": made.properties | tag,
    }


def _guard(read: Callable[[], Any]) -> Callable[[], Any]:
    """Return a reader that drops what cannot be read; that the broker is away passes through."""

    def read_one() -> Any:
        try:
            return read()
        except (Empty, OSError, RedisError):
            raise
        except Exception as error:
            log.warning("a message in the broker is no wake-up and was dropped: %s", type(error).__name__)
            return True

    return read_one
