"""The record from which `jobs.create` creates a job."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from .lanes import Lane
from .states import QUEUES


@dataclass(frozen=True)
class NewJob:
    """Describe a job that is to be created.

    Attributes:
        dedup: Hash that equal jobs share.
        kind: Name of its kind.
        request: Its request, as JSON values.
        scan: Key of the file from which the family's work derives.
        name: Its name.
        priority: A larger one goes first.
        queue: One of `QUEUES`.
        lane: What goes first.
        payer: Id of the API key whose quota it counts for; empty: none.
        tags: Words by which it can be found.
        inputs: Ids of the ended jobs whose results it reads, by the name of the folder in which it finds them.
        parent: Ids of the job that creates it and of that one's family; None for a root.
        waits: Ids of the siblings that must have succeeded before it begins.
    """

    dedup: str
    kind: str
    request: dict[str, Any]
    scan: str
    name: str
    priority: int = 0
    queue: str = QUEUES[0]
    lane: Lane = Lane.BATCH
    payer: str = ""
    tags: tuple[str, ...] = ()
    inputs: Mapping[str, str] = field(default_factory=dict)
    parent: tuple[str, str] | None = None
    waits: tuple[str, ...] = ()
