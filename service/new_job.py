"""What a job is made from; `jobs.create` makes it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from .states import QUEUES


@dataclass(frozen=True)
class NewJob:
    """Describe a job that is to be made.

    Attributes:
        dedup: Hash of what makes it the same job as another.
        kind: Name of its kind.
        request: What to do, as JSON values.
        scan: Key of the file that the family's work goes back to.
        name: What it is called.
        priority: Larger goes first.
        queue: One of `QUEUES`.
        payer: Id of the API key whose quota it counts for; empty: none.
        tags: Words that it can be found by.
        inputs: Ids of the ended jobs whose results it reads, by the name of the folder in which it finds them.
        parent: Id of the job that makes it, and of that one's family; None for a root.
        waits: Ids of the siblings that must have succeeded before it begins.
    """

    dedup: str
    kind: str
    request: dict[str, Any]
    scan: str
    name: str
    priority: int = 0
    queue: str = QUEUES[0]
    payer: str = ""
    tags: tuple[str, ...] = ()
    inputs: Mapping[str, str] = field(default_factory=dict)
    parent: tuple[str, str] | None = None
    waits: tuple[str, ...] = ()
