"""Results of the first stage of a running job: the description of its files, and its kind."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from .checking import DOUBTS
from .database import Database, clock
from .jobs import Claim, record, write_fenced
from .listed import list_request, read_listed_settings

DOUBTS_EVENT = "doubted"
"""Kind of the event that reports doubts about a job's files."""


def note_checked(database: Database, claim: Claim, found: dict[str, Any]) -> None:
    """Store the first stage's description of a job's files; doubts about them are an event too.

    Raises:
        FenceLost: if another worker has claimed the job.
    """
    with database.write() as session:
        write_fenced(session, claim, checked=found, touched=clock())
        if found.get(DOUBTS):
            record(session, claim.job, DOUBTS_EVENT, doubts=found[DOUBTS])


def change_kind(database: Database, claim: Claim, kind: str, request: dict[str, Any]) -> Claim:
    """Change a running job to the kind of its files, and return the claim on it.

    Raises:
        FenceLost: if another worker has claimed the job.
    """
    with database.write() as session:
        write_fenced(session, claim, kind=kind, request=request, touched=clock(), **read_listed_settings(request))
        list_request(session, claim.job, request)
        record(session, claim.job, "understood", understood=kind)
    return replace(claim, kind=kind, request=request)
