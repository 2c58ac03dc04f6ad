"""Records of the queue: counts, workers, and outages; see `records.py`."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar, Self

from .records import CLOSED, Json, read_optional
from .states import State

if TYPE_CHECKING:
    from .models import WorkerRow


@dataclass(frozen=True)
class Worker:
    """Describe a live worker, with times in s since 1970; only the scope `admin` sees its name."""

    __pydantic_config__: ClassVar = CLOSED
    name: str
    queues: str
    concurrency: int
    started: float
    seen: float

    @classmethod
    def from_row(cls, row: WorkerRow) -> Self:
        """Read a row of the table of workers."""
        return cls(row.name, row.queues, row.concurrency, row.started, row.seen)

    @classmethod
    def from_json(cls, found: Json) -> Self:
        """Read a service's response."""
        return cls(
            name=str(found["name"]),
            queues=str(found["queues"]),
            concurrency=int(found["concurrency"]),
            started=float(found["started"]),
            seen=float(found["seen"]),
        )


@dataclass(frozen=True)
class Outage:
    """Describe what the workers of a host wait for: an error's code, and since when [s since 1970].

    Only the scope `admin` sees the host's name.
    """

    __pydantic_config__: ClassVar = CLOSED
    place: str
    code: str
    since: float


@dataclass(frozen=True)
class Queue:
    """Describe the queue: counts of jobs by state, live workers and outages.

    `silence` is the time since a dispatcher last acted [s]; None if there is none.
    """

    __pydantic_config__: ClassVar = CLOSED
    states: dict[State, int]
    workers: list[Worker]
    outages: list[Outage] = field(default_factory=list)
    silence: float | None = None

    @classmethod
    def from_json(cls, found: Json) -> Self:
        """Read a service's response; an older service sends no outages."""
        return cls(
            {State(state): int(count) for state, count in found["states"].items()},
            [Worker.from_json(worker) for worker in found["workers"]],
            [Outage(str(one["place"]), str(one["code"]), float(one["since"])) for one in found.get("outages", ())],
            read_optional(found.get("silence", 0.0)),
        )
