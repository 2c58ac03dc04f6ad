"""The Celery application: early acknowledgement, no stored results, JSON only. A message is a wake-up with a job id."""

from __future__ import annotations

import uuid
from typing import TYPE_CHECKING

from ..service.settings import ServiceSettings
from ..service.states import QUEUES
from .broker import broker_url

if TYPE_CHECKING:
    from celery import Celery

CHANNELS = {queue: "garmentq" if queue == QUEUES[0] else f"garmentq.{queue}" for queue in QUEUES}
"""Name of the broker's list for each queue of jobs."""

TASK = "garmentq.recover"

HARD_EXTRA_SECONDS = 60.0
"""Time beyond `max_seconds` after which a child process is killed [s]; within it the child can end by itself."""

LOST_SECONDS = 0.5
"""Time that Celery waits for a result in the pipe of a dead child [s]; results are not stored, so a moment is
enough."""

BROKER_SECONDS = 5
"""Longest wait for the broker's response, and the period of the connection's health check [s]."""


def make_app(settings: ServiceSettings) -> Celery:
    """Return the Celery application for a broker; no connection is opened yet."""
    from celery import Celery

    app = Celery("garmentq", broker=broker_url(settings), set_as_current=False)
    app.conf.update(
        task_default_queue=CHANNELS[QUEUES[0]],
        task_serializer="json",
        accept_content=["json"],
        task_acks_late=False,
        task_ignore_result=True,
        task_store_errors_even_if_ignored=False,
        task_time_limit=settings.max_seconds + HARD_EXTRA_SECONDS,
        task_publish_retry=False,
        worker_prefetch_multiplier=1,
        worker_disable_prefetch=True,  # an idle worker cannot take a message that a busy one has prefetched
        worker_lost_wait=LOST_SECONDS,
        worker_send_task_events=False,
        worker_enable_remote_control=False,  # a message could stop a worker; only signals may
        worker_hijack_root_logger=False,
        worker_redirect_stdouts=False,
        broker_connection_retry_on_startup=True,
        broker_connection_max_retries=None,
        broker_transport_options={
            "visibility_timeout": 86400,  # early acknowledgement: nothing is ever redelivered by the transport
            "socket_timeout": BROKER_SECONDS,
            "socket_connect_timeout": BROKER_SECONDS,
            "health_check_interval": BROKER_SECONDS,
        },
    )
    return app


def publish(app: Celery, job: str, queue: str = QUEUES[0]) -> None:
    """Send one wake-up for a job; raise at once if the broker is unavailable."""
    app.send_task(TASK, args=(job,), queue=CHANNELS[queue], task_id=uuid.uuid4().hex, retry=False, ignore_result=True)


def count_messages(app: Celery) -> int:
    """Count the wake-ups that wait in the broker."""
    with app.pool.acquire(block=True, timeout=BROKER_SECONDS) as connection:
        client = connection.default_channel.client
        return sum(int(client.llen(channel)) for channel in CHANNELS.values())
