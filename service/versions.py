"""Versions of a result: the recovered or derived one, and every edit of it, of an edit, and so on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from sqlalchemy import select

from .database import Database, skip_damaged_rows
from .kinds.dress_request import RESULT
from .models import JobInputRow, JobRow, OwnerRow
from .records import CLOSED, JobId, JsonRecord
from .states import State

if TYPE_CHECKING:
    from sqlalchemy.orm import Session

EDIT = "edit"
"""Kind of the jobs that are versions."""


@dataclass(frozen=True)
class Version(JsonRecord):
    """Describe one version of a result: `predecessor` is null for the first; `created` in s since 1970."""

    __pydantic_config__: ClassVar = CLOSED
    job: JobId
    predecessor: JobId | None
    name: str
    kind: str
    state: State
    verdict: str | None
    created: float


@skip_damaged_rows
def list_versions(database: Database, job: str, owner: str = "") -> list[Version]:
    """Return all versions of the result that a job belongs to, oldest first: each follows its predecessor.

    Args:
        database: The jobs' database.
        job: Id of any of them.
        owner: An API key's id: only its jobs; empty: all.
    """
    with database.read() as session:
        first = job
        while (before := _find_predecessor(session, first)) is not None:
            first = before
        found: dict[str, str | None] = {first: None}
        level = [first]
        while level:
            statement = (
                select(JobInputRow.job, JobInputRow.input)
                .join(JobRow, JobRow.id == JobInputRow.job)
                .where(JobRow.kind == EDIT, JobInputRow.name == RESULT, JobInputRow.input.in_(level))
            )
            pairs = session.execute(statement).all()
            level = [row.job for row in pairs]
            found |= {row.job: row.input for row in pairs}
        jobs = select(JobRow).where(JobRow.id.in_(found)).order_by(JobRow.created, JobRow.id)
        if owner:
            jobs = jobs.join(OwnerRow, OwnerRow.job == JobRow.id).where(OwnerRow.key == owner)
        rows = session.scalars(jobs).all()
        return [Version(row.id, found[row.id], row.name, row.kind, row.state, row.verdict, row.created) for row in rows]


def _find_predecessor(session: Session, job: str) -> str | None:
    """Return the job that a version was made from; None for the first."""
    row = session.get(JobRow, job)
    if row is None or row.kind != EDIT:
        return None
    read = session.get(JobInputRow, (job, RESULT))
    return None if read is None else read.input
