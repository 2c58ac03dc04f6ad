"""Reading of the broker's messages: of each message only the job id is used; an invalid message is logged and dropped.

Celery stops a worker that fails to read a message, and obeys the times and reply addresses in a message. Both are
prevented here. A message that cannot be acknowledged because the broker is unavailable does not block the others.
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
"""Pattern of a job id."""


class MessageGuard(bootsteps.StartStopStep):
    """Replace how a worker's connection reads messages; each new connection is treated again."""

    requires = ("celery.worker.consumer.tasks:Tasks",)

    def start(self, consumer: Any) -> None:
        """Install the guarded reader."""
        channel, app = consumer.task_consumer.channel, consumer.app
        original = channel.Message

        class WakeUp(original):  # type: ignore[misc, valid-type]
            """Represent a message of which only the job id is kept."""

            def __init__(self, payload: Any, channel: Any = None, **rest: Any) -> None:
                super().__init__(make_wake_up(app, payload), channel=channel, **rest)

            def ack(self, multiple: bool = False) -> None:
                """Acknowledge the message, and forget it even if the broker is unavailable.

                Celery only logs that error: the message would keep its place in the queue and block all others.
                """
                try:
                    super().ack(multiple)
                except (OSError, RedisError):
                    virtual.QoS.ack(self.channel.qos, self.delivery_tag)  # type: ignore[no-untyped-call]
                    raise

        channel.Message = WakeUp
        channel.handlers["BRPOP"] = _guard(channel.handlers["BRPOP"])


def make_wake_up(app: Celery, payload: Any) -> dict[str, Any]:
    """Return a new message for the job that a broker's message names; nothing else of that message is kept.

    Args:
        app: The application that builds the new message.
        payload: The broker's message, as JSON values.

    Raises:
        ValueError, TypeError, LookupError, RecursionError: if it names no job.
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
    """Return a reader that drops unreadable messages; errors of an unavailable broker are raised."""

    def read_one() -> Any:
        try:
            return read()
        except (Empty, OSError, RedisError):
            raise
        except Exception as error:
            log.warning("a message in the broker is not a wake-up and was dropped: %s", type(error).__name__)
            return True

    return read_one
