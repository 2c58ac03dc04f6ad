"""What leaves the service of its webhooks; see `records.py`."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

from .records import CLOSED, Json, check_id, read_optional
from .states import State

if TYPE_CHECKING:
    from .models import WebhookRow


@dataclass(frozen=True)
class Webhook:
    """Show an address that is told when jobs end, without its secret.

    Attributes:
        id: Its name.
        key: Whose jobs it is told of; empty: all jobs.
        url: Where messages go.
        states: The endings that it is told of.
        created: When it was made [s since 1970].
        served: When the latest message was sent [s since 1970]; None where there was none.
        status: HTTP status of the latest answer; None where there was none.
        error: Why the latest message was not taken; None where it was.
        owed: Messages that are still to be sent.
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
        """Read a service's answer."""
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
    """Describe what came of one message: the answer's status, or why there was none; without `error` it was taken."""

    __pydantic_config__: ClassVar = CLOSED
    status: int | None
    error: str | None

    @classmethod
    def from_json(cls, found: Json) -> Self:
        """Read a service's answer."""
        status, error = found["status"], found["error"]
        return cls(None if status is None else int(status), None if error is None else str(error))
