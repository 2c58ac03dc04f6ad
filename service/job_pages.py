"""Pages of a list of jobs, with their number and where the next page begins."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from .cursors import decode_cursor
from .database import Database, skip_damaged_rows
from .models import JobRow, OwnerRow
from .query import (
    MAX_QUERY_OFFSET,
    MAX_QUERY_ROWS,
    Condition,
    JobQuery,
    QueryBad,
    make_cursor,
    read_sorted,
    select_jobs,
)
from .sorting import Page

MAX_TOTAL_COUNT = 1_000
"""Largest number of jobs with conditions that are counted: more take tens of milliseconds in a long table."""

MIN_WALKED_MATCH_COUNT = 10_000
"""Number of jobs that meet a condition from which a count walks over all jobs: among 100 000 it has counted
`MAX_TOTAL_COUNT` after at most 10 000, about 15 ms. Naming so many takes about 5 ms."""


@dataclass(frozen=True)
class RowPage:
    """Describe a page of rows.

    Attributes:
        rows: The jobs.
        total: Number of jobs of the whole list; None if there are conditions and more than `MAX_TOTAL_COUNT` meet them.
        next: Cursor of the page that follows; None if this is the last.
    """

    rows: list[JobRow]
    total: int | None
    next: str | None


@skip_damaged_rows
def find_page(database: Database, query: JobQuery, owner: str | None = None) -> RowPage:
    """Return a page of the jobs that meet a query; with `owner` only those of one API key.

    Raises:
        QueryBad: if a name is unknown, the limit is out of range, or cursor and offset are both named.
        CursorBad: if the cursor is none of this list.
    """
    if not 1 <= query.limit <= MAX_QUERY_ROWS or not 0 <= query.offset <= MAX_QUERY_OFFSET:
        raise QueryBad(f"limit is 1 to {MAX_QUERY_ROWS}, offset 0 to {MAX_QUERY_OFFSET}; choose others.")
    if query.cursor is not None and query.offset:
        raise QueryBad("a page begins at a cursor or at an offset; leave one of them out.")
    after = None if query.cursor is None else decode_cursor(query.cursor, query.sort)
    conditions = query.conditions
    with database.read() as session:
        statement = select_jobs(session, conditions, owner)
        rows = read_sorted(session, statement, query.sort, Page(query.limit + 1, query.offset, after))
        is_last = len(rows) <= query.limit
        rows = rows[: query.limit]
        following = None if is_last else make_cursor(session, rows[-1], query.sort).encode()
        total = _count(session, conditions, owner) if conditions else _count_all(session, owner)
    return RowPage(rows, total, following)


def _count(session: Session, conditions: Sequence[Condition], owner: str | None) -> int | None:
    """Return the number of jobs that meet conditions, or None if there are more than are counted."""
    statement = select_jobs(session, conditions, owner, MIN_WALKED_MATCH_COUNT).with_only_columns(JobRow.id)
    first = statement.limit(MAX_TOTAL_COUNT + 1).subquery()
    count = session.scalar(select(func.count()).select_from(first)) or 0
    return count if count <= MAX_TOTAL_COUNT else None


def _count_all(session: Session, owner: str | None) -> int:
    """Return the number of jobs of a key, or of all."""
    owned = select(func.count()).select_from(OwnerRow).where(OwnerRow.key == owner)
    return session.scalar(select(func.count()).select_from(JobRow) if owner is None else owned) or 0
