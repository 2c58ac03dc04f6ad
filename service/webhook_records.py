"""Records of webhooks; see `records.py`."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar, Self

from .records import CLOSED, JobId, JsonRecord
from .states import State

if TYPE_CHECKING:
    from .models import WebhookRow


@dataclass(frozen=True)
class Webhook(JsonRecord):
    """Describe a webhook, without its secret.

    Attributes:
        id: Its id.
        key: Key whose jobs it receives messages about; empty: all jobs.
        url: Address of the messages.
        states: End states that it receives messages about.
        created: When it was created [s since 1970].
        served: When the latest message was sent [s since 1970]; None if there was none.
        status: HTTP status of the latest response; None if there was none.
        error: Why the latest message was not accepted; None if it was.
        owed: Number of messages that are still to be sent.
        earlier_until: Until when messages are also signed by the secret before the last rotation [s since 1970]; None
            if it was never rotated.
    """

    id: JobId = field(metadata={"alias": "webhook"})
    key: str
    url: str
    states: list[State]
    created: float
    served: float | None
    status: int | None
    error: str | None
    owed: int
    earlier_until: float | None = None

    @classmethod
    def from_row(cls, row: WebhookRow, unsent: int) -> Self:
        """Read a row of the table of webhooks."""
        delivery = (row.served or None, row.status, row.error, unsent, row.earlier_until)
        return cls(row.id, row.key, row.url, [State(state) for state in row.states], row.created, *delivery)


@dataclass(frozen=True)
class Receipt(JsonRecord):
    """Describe the outcome of a message: the response's status, or why there was none; no `error`: it was accepted."""

    __pydantic_config__: ClassVar = CLOSED
    status: int | None
    error: str | None
