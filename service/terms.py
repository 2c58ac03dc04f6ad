"""Terms of a job: queue, name, tags, key; the same for every kind of job."""

from __future__ import annotations

import uuid
from dataclasses import dataclass, replace

from .states import QUEUES


@dataclass(frozen=True)
class JobTerms:
    """Describe how a job is queued.

    Attributes:
        name: Name of the family; empty: that of its file, or of the job whose result it reads.
        tags: Words by which it can be found.
        priority: A larger one goes first.
        queue: One of `QUEUES`, by which workers choose jobs.
        force: Create a new job even if an equal one exists.
        nonce: Identifies a forced job, so that a repeated request is the same job; empty: a random one.
        key: Id of the caller's API key, or empty; the key then owns the job too.
        quota: Jobs that the key may have open at a time.
        realm: Whose equal orders are one job: a key's id; empty: everybody's.
        subject: The person who was scanned: id or name of the key's subject, which is created if it is new; empty: that
            of the job whose result is read, or none.
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
    subject: str = ""

    def complete(self, name: str) -> JobTerms:
        """Return the terms with a name if none was given, and a nonce if a new job is forced."""
        nonce = (self.nonce or uuid.uuid4().hex) if self.force else ""
        return replace(self, name=self.name or name, nonce=nonce)
