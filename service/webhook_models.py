"""The tables of webhooks and their messages."""

from __future__ import annotations

from typing import Any

from sqlalchemy import ForeignKey, Index
from sqlalchemy.orm import Mapped, mapped_column

from .columns import Words
from .model_base import Base


class WebhookRow(Base):
    """Store a webhook of a key (empty: for all jobs) with the secret that signs its messages.

    One message at a time is sent to it, by the courier that claimed it until `taken_until`; `served` is the time of the
    latest message, `status` and `error` its outcome. Until `earlier_until` messages are signed by `earlier_secret` too.
    """

    __tablename__ = "webhooks"
    id: Mapped[str] = mapped_column(Words(16), primary_key=True)
    key: Mapped[str] = mapped_column(Words(16), index=True)
    url: Mapped[str] = mapped_column(Words(2000))
    secret: Mapped[str] = mapped_column(Words(64))
    states: Mapped[list[Any]]
    created: Mapped[float]
    served: Mapped[float] = mapped_column(default=0.0)
    taken_until: Mapped[float] = mapped_column(default=0.0)
    status: Mapped[int | None]
    error: Mapped[str | None] = mapped_column(Words(255))
    earlier_secret: Mapped[str | None] = mapped_column(Words(64))
    earlier_until: Mapped[float | None]


class DeliveryRow(Base):
    """Store one message to a webhook; `due` is when it is sent next, None if it was accepted or given up.

    A message without a job is a test. `status` and `error` are the outcome of its last attempt.
    """

    __tablename__ = "deliveries"
    __table_args__ = (Index("ix_deliveries_webhook_due", "webhook", "due"),)
    id: Mapped[str] = mapped_column(Words(32), primary_key=True)
    webhook: Mapped[str] = mapped_column(ForeignKey("webhooks.id", ondelete="CASCADE"))
    job: Mapped[str | None] = mapped_column(ForeignKey("jobs.id", ondelete="CASCADE"), index=True)
    body: Mapped[dict[str, Any]]
    created: Mapped[float]
    due: Mapped[float | None]
    tries: Mapped[int] = mapped_column(default=0)
    status: Mapped[int | None]
    error: Mapped[str | None] = mapped_column(Words(255))
