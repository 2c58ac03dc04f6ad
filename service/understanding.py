"""What the first stage of a running job found of its files, and what kind of job that makes it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from .checking import DOUBTS
from .database import Database, clock
from .jobs import Claim, record, write_fenced

DOUBTS_EVENT = "doubted"
"""Kind of the event that tells what is doubtful of a job's files."""


def note_checked(database: Database, claim: Claim, found: dict[str, Any]) -> None:
    """Keep what the first stage found out of a job's files; what is doubtful of them is an event too.

    Raises:
        FenceLost: where the job belongs to someone else.
    """
    with database.write() as session:
        write_fenced(session, claim, checked=found, touched=clock())
        if found.get(DOUBTS):
            record(session, claim.job, DOUBTS_EVENT, doubts=found[DOUBTS])


def change_kind(database: Database, claim: Claim, kind: str, request: dict[str, Any]) -> Claim:
    """Make a running job one of another kind, since that is what its files are, and return the claim on it.

    Raises:
        FenceLost: where the job belongs to someone else.
    """
    with database.write() as session:
        write_fenced(session, claim, kind=kind, request=request, touched=clock())
        record(session, claim.job, "understood", understood=kind)
    return replace(claim, kind=kind, request=request)
