"""How a job is queued, for whom, and what it is called: the same for every kind of job."""

from __future__ import annotations

import uuid
from dataclasses import dataclass, replace

from .states import QUEUES


@dataclass(frozen=True)
class JobTerms:
    """Say how a job is queued.

    Attributes:
        name: What the family is called; empty: after its file, or the job whose result it reads.
        tags: Words that it can be found by.
        priority: Larger goes first.
        queue: One of `QUEUES`: which kind of worker takes it.
        force: Make a new job even where an equal one exists.
        nonce: What makes a forced job the same when it is asked for again; empty: a random one.
        key: Id of the API key that asks, or empty; the job is then that key's too.
        quota: Jobs that the key may have open at a time.
        realm: Whose equal orders are one job: a key's id; empty: everybody's.
    """

    name: str = ""
    tags: tuple[str, ...] = ()
    priority: int = 0
    queue: str = QUEUES[0]
    force: bool = False
    nonce: str = ""
    key: str = ""
    quota: int = 0
    realm: str = ""

    def complete(self, name: str) -> JobTerms:
        """Return the terms of one job: with a name where none was given, and a nonce where a new job is forced."""
        nonce = (self.nonce or uuid.uuid4().hex) if self.force else ""
        return replace(self, name=self.name or name, nonce=nonce)
