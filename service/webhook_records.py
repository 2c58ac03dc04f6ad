"""Records of webhooks; see `records.py`."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

from .records import CLOSED, Json, check_id, read_optional
from .states import State

if TYPE_CHECKING:
    from .models import WebhookRow


@dataclass(frozen=True)
class Webhook:
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
    """

    id: str
    key: str
    url: str
    states: list[State]
    created: float
    served: float | None
    status: int | None
    error: str | None
    owed: int

    @classmethod
    def from_row(cls, row: WebhookRow, owed: int) -> Self:
        """Read a row of the table of webhooks."""
        told = (row.served or None, row.status, row.error, owed)
        return cls(row.id, row.key, row.url, [State(state) for state in row.states], row.created, *told)

    @classmethod
    def from_json(cls, found: Json) -> Self:
        """Read a service's response."""
        return cls(
            id=check_id(found["webhook"]),
            key=str(found["key"]),
            url=str(found["url"]),
            states=[State(state) for state in found["states"]],
            created=float(found["created"]),
            served=read_optional(found["served"]),
            status=None if found["status"] is None else int(found["status"]),
            error=None if found["error"] is None else str(found["error"]),
            owed=int(found["owed"]),
        )

    def as_json(self) -> dict[str, Any]:
        """Return the webhook as JSON values."""
        return {"webhook": self.id, **{name: value for name, value in asdict(self).items() if name != "id"}}


@dataclass(frozen=True)
class Receipt:
    """Describe the outcome of a message: the response's status, or why there was none; no `error`: it was accepted."""

    __pydantic_config__: ClassVar = CLOSED
    status: int | None
    error: str | None

    @classmethod
    def from_json(cls, found: Json) -> Self:
        """Read a service's response."""
        status, error = found["status"], found["error"]
        return cls(None if status is None else int(status), None if error is None else str(error))
