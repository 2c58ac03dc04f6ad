"""The Celery application: early acknowledgement, no results, JSON only. A message is a wake-up with a job id."""

from __future__ import annotations

import uuid
from typing import TYPE_CHECKING

from ..service.settings import ServiceSettings
from ..service.states import QUEUES
from .broker import broker_url

if TYPE_CHECKING:
    from celery import Celery

CHANNELS = {queue: "garmentq" if queue == QUEUES[0] else f"garmentq.{queue}" for queue in QUEUES}
"""The broker's list for each queue of jobs."""

TASK = "garmentq.recover"

HARD_EXTRA_SECONDS = 60.0
"""How much longer than `max_seconds` a child lives before it is killed [s]: time for its own, orderly end."""

LOST_SECONDS = 0.5
"""How long a dead child may still have a result in its pipe [s]; no result is kept there, so a moment is enough."""

BROKER_SECONDS = 5
"""Longest wait for the broker's answer, and the period of the connection's health check [s]."""


def make_app(settings: ServiceSettings) -> Celery:
    """Make the application for a broker; nothing is connected yet."""
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
        worker_disable_prefetch=True,  # a message in a busy worker's hands is one that an idle worker cannot take
        worker_lost_wait=LOST_SECONDS,
        worker_send_task_events=False,
        worker_enable_remote_control=False,  # a message could end a worker; signals do
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
    """Send one wake-up for a job; raises at once where the broker is away."""
    app.send_task(TASK, args=(job,), queue=CHANNELS[queue], task_id=uuid.uuid4().hex, retry=False, ignore_result=True)


def count_messages(app: Celery) -> int:
    """Count the wake-ups that wait in the broker."""
    with app.pool.acquire(block=True, timeout=BROKER_SECONDS) as connection:
        client = connection.default_channel.client
        return sum(int(client.llen(channel)) for channel in CHANNELS.values())
