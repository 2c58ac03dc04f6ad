"""Pages of jobs in the order of a column, by its index, from an offset or from where the page before ended."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sqlalchemy import Select, func, select, tuple_
from sqlalchemy.orm import Session

from .columns import Name, Real, Whole
from .cursors import Cursor, CursorBad, Value
from .models import JobRow

MAX_WHOLE_VALUE = 2**31 - 1
"""Largest number in a column of whole numbers that lists are sorted by: an INTEGER of four bytes."""

Parts = tuple[Select[Any], Select[Any]]
"""The queries for the jobs that have a column, and for those that have not."""


@dataclass(frozen=True)
class Order:
    """Describe an order of jobs.

    Among equals the newest job is first where the column falls, the oldest where it rises: so an index has them.

    Attributes:
        column: What they are sorted by.
        is_falling: Whether the largest is first.
    """

    column: Any
    is_falling: bool

    @property
    def columns(self) -> list[Any]:
        """Return the column, and those that sort equals."""
        return list(dict.fromkeys((self.column, JobRow.created, JobRow.id)))


@dataclass(frozen=True)
class Page:
    """Describe a part of a list.

    Attributes:
        count: Largest number of jobs.
        offset: Number of jobs that are skipped before them.
        after: The last job of the page before; None: the list's beginning.
    """

    count: int
    offset: int = 0
    after: Cursor | None = None


def read_page(session: Session, parts: Parts, order: Order, page: Page) -> list[JobRow]:
    """Return a page of jobs in an order, then of those without its column, the newest first.

    Raises:
        CursorBad: if the page's cursor is none of this list.
    """
    after = page.after
    rest = parts[1].order_by(JobRow.created.desc(), JobRow.id.desc())
    if after is not None and after.value is None:
        older = tuple_(JobRow.created, JobRow.id) < (after.created, after.job)
        return list(session.scalars(rest.where(older).limit(page.count).offset(page.offset)))
    with_column = parts[0] if after is None else _follow(parts[0], order, after)
    sorted_by = (one.desc() if order.is_falling else one.asc() for one in order.columns)
    known = list(session.scalars(with_column.order_by(*sorted_by).limit(page.count).offset(page.offset)))
    if len(known) == page.count:
        return known
    passed = page.offset + len(known)
    if page.offset and not known:
        passed = min(page.offset, session.scalar(select(func.count()).select_from(with_column.subquery())) or 0)
    left = rest.limit(page.count - len(known)).offset(max(0, page.offset - passed))
    return known + list(session.scalars(left))


def _follow(statement: Select[Any], order: Order, after: Cursor) -> Select[Any]:
    """Return the query for the jobs after one; the bound of the column alone lets a metric's index be used.

    Raises:
        CursorBad: if the cursor's value is not of the column's type.
    """
    if not _is_allowed(order.column.type, after.value):
        raise CursorBad()
    own = {JobRow.created.key: after.created, JobRow.id.key: after.job}
    values = [after.value, *(own[one.key] for one in order.columns[1:])]
    key = tuple_(*order.columns)
    if order.is_falling:
        return statement.where(order.column <= after.value, key < tuple(values))
    return statement.where(order.column >= after.value, key > tuple(values))


def _is_allowed(kind: object, value: Value) -> bool:
    """Check whether a column of a type may have a value."""
    if isinstance(kind, Whole):
        return isinstance(value, int) and abs(value) <= MAX_WHOLE_VALUE
    if isinstance(kind, Name):
        return value in list(kind.names)
    return isinstance(value, int | float if isinstance(kind, Real) else str)
