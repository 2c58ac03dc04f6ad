"""What leaves the service of its queue: counts, workers, and what they wait for; see `records.py`."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar, Self

from .records import CLOSED, Json, read_optional
from .states import State

if TYPE_CHECKING:
    from .models import WorkerRow


@dataclass(frozen=True)
class Worker:
    """Describe a living worker, with times in s since 1970; its name is shown to the scope `admin` only."""

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
        """Read a service's answer."""
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

    The host's name is shown to the scope `admin` only.
    """

    __pydantic_config__: ClassVar = CLOSED
    place: str
    code: str
    since: float


@dataclass(frozen=True)
class Queue:
    """Count the jobs by state, list the living workers and what they wait for.

    `silence` is how long no dispatcher has acted [s]; None where there is none.
    """

    __pydantic_config__: ClassVar = CLOSED
    states: dict[State, int]
    workers: list[Worker]
    outages: list[Outage] = field(default_factory=list)
    silence: float | None = None

    @classmethod
    def from_json(cls, found: Json) -> Self:
        """Read a service's answer; an older one tells of no outages."""
        return cls(
            {State(state): int(count) for state, count in found["states"].items()},
            [Worker.from_json(worker) for worker in found["workers"]],
            [Outage(str(one["place"]), str(one["code"]), float(one["since"])) for one in found.get("outages", ())],
            read_optional(found.get("silence", 0.0)),
        )
