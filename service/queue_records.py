"""Records of the queue: counts, workers, and outages; see `records.py`."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar, Self

from .records import CLOSED, Json, JsonRecord
from .states import State

if TYPE_CHECKING:
    from .models import WorkerRow


@dataclass(frozen=True)
class Worker(JsonRecord):
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


@dataclass(frozen=True)
class Outage(JsonRecord):
    """Describe what the workers of a host wait for: an error's code, and since when [s since 1970].

    Only the scope `admin` sees the host's name.
    """

    __pydantic_config__: ClassVar = CLOSED
    place: str
    code: str
    since: float


@dataclass(frozen=True)
class Queue(JsonRecord):
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
        """Read a service's response; an older service sends no `silence`."""
        return super().from_json({"silence": 0.0, **found})
