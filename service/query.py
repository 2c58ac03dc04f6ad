"""Queries of results: names and operators come from a list, values are bound, a user's text is never SQL."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from difflib import get_close_matches
from typing import Any, cast

from sqlalchemy import ColumnElement, Select, exists, func, or_, select
from sqlalchemy.orm import Session, aliased

from ..core.run.errors import BadInput
from .cursors import Cursor
from .database import Database, skip_damaged_rows
from .models import JobInputRow, JobRow, JobTagRow, MetricRow, OwnerRow, SubjectJobRow, SubjectRow
from .sorting import Order, Page, read_page
from .states import State

TEXTS: dict[str, Any] = {
    "job": JobRow.id,
    "name": JobRow.name,
    "kind": JobRow.kind,
    "family": JobRow.family,
    "parent": JobRow.parent,
    "state": JobRow.state,
    "version": JobRow.version,
    "error": JobRow.error_code,
    "verdict": JobRow.verdict,
    "garment": JobRow.garment,
    "template": JobRow.template,
    "fabric": JobRow.fabric,
    "body": JobRow.body,
    "method": JobRow.method,
    "preset": JobRow.preset,
}
"""Text fields: compared by = and != only; so are `tag`, of which a job may have several, and `subject`."""

TAG, SUBJECT = "tag", "subject"

NUMBERS: dict[str, Any] = {
    "created": JobRow.created,
    "started": JobRow.started,
    "finished": JobRow.finished,
    "attempts": JobRow.attempts,
    "priority": JobRow.priority,
    "cpu_seconds": JobRow.cpu_seconds,
    "peak_mb": JobRow.peak_mb,
}
"""Numeric fields; every metric is one more."""

TIMES = ("created", "started", "finished")
"""Numbers that may be given as dates, 2026-11-22 or 2026-11-22T14:00+01:00."""

OPERATORS: dict[str, Callable[[Any, Any], Any]] = {
    "<=": operator.le,
    ">=": operator.ge,
    "!=": operator.ne,
    "==": operator.eq,
    "<": operator.lt,
    ">": operator.gt,
    "=": operator.eq,
}

CONDITION = re.compile(
    r"""\s*(?P<name>[A-Za-z][\w.]*)\s*(?P<operator><=|>=|!=|==|<|>|=)\s*"""
    r"""(?P<value>"[^"]*"|'[^']*'|[^\s"'<>=!]+)\s*""",
    re.ASCII,
)
"""One comparison: NAME OPERATOR VALUE."""

FORBIDDEN_CHARACTERS = re.compile("[\x00-\x1f\x7f\ud800-\udfff]")
"""Control characters and lone surrogates: no stored name has one, and PostgreSQL refuses NUL even in a query."""

AND_PATTERN = re.compile(r"and\s", re.ASCII | re.IGNORECASE)

MIN_EXISTS_MATCH_COUNT = 2_000
"""Number of jobs that meet a condition from which each job is asked for it, in the order of the list, instead of naming
all of them (IN): naming 2000 takes about 2 ms."""

MAX_QUERY_CONDITIONS = 50
"""Largest number of conditions of one query; SQLite refuses some hundreds, PostgreSQL takes seconds for them."""

MAX_QUERY_OFFSET = 1_000_000
"""Largest number of jobs before a page; the database steps over each of them."""

MAX_QUERY_ROWS = 10_000
"""Largest number of rows that one query may return; a program that needs more should read the database."""


class QueryBad(BadInput):
    """The query cannot be parsed; write it as NAME OPERATOR VALUE, such as 'surface_rms_mm.t2s < 4'."""

    code = "query.bad"


@dataclass(frozen=True)
class Condition:
    """Describe a comparison of a field or metric with a value.

    Attributes:
        name: A name from `TEXTS`, `NUMBERS`, or a metric's.
        operator: One of `OPERATORS`.
        value: Text or number, always bound.
    """

    name: str
    operator: str
    value: str | float


@dataclass(frozen=True)
class JobQuery:
    """Describe a query for jobs by their fields and their results.

    Attributes:
        fields: Fields with the text that each must have.
        wheres: Conditions as they were typed, joined by `and`.
        sort: Field or metric to sort by; `-` before it: largest first.
        limit: Largest number of jobs.
        offset: Number of jobs that are skipped before them.
        cursor: Where the page before ended, its `next`; None: the first page.
    """

    fields: Mapping[str, str] = field(default_factory=dict)
    wheres: Sequence[str] = ()
    sort: str = "-created"
    limit: int = 50
    offset: int = 0
    cursor: str | None = None

    @property
    def conditions(self) -> list[Condition]:
        """Return every condition.

        Raises:
            QueryBad: if one cannot be parsed, or there are too many.
        """
        conditions = [Condition(name, "=", value) for name, value in self.fields.items()]
        found = conditions + [condition for text in self.wheres for condition in parse_conditions(text)]
        if len(found) > MAX_QUERY_CONDITIONS:
            raise QueryBad(f"{len(found)} conditions are more than {MAX_QUERY_CONDITIONS}; use fewer.")
        return found


def parse_conditions(text: str) -> list[Condition]:
    """Parse conditions joined by `and`.

    Raises:
        QueryBad: if a part is not a condition.
    """
    conditions: list[Condition] = []
    at = 0
    while True:
        match = CONDITION.match(text, at)
        if match is None:
            raise QueryBad(
                f"'{text[at:][:60]}' is not a condition; write NAME OPERATOR VALUE, as in surface_rms_mm.t2s < 4."
            )
        conditions.append(_condition(match["name"], match["operator"], match["value"].strip("\"'")))
        if match.end() == len(text):
            return conditions
        joint = AND_PATTERN.match(text, match.end())
        if joint is None:
            raise QueryBad(f"'{text[match.end() :][:60]}' does not follow a condition; join conditions with 'and'.")
        at = joint.end()


@skip_damaged_rows
def find_jobs(
    database: Database,
    conditions: Sequence[Condition] = (),
    sort: str = "-created",
    limit: int | tuple[int, int] = 50,
    owner: str | None = None,
) -> list[JobRow]:
    """Return the jobs that meet every condition, sorted by a name (`-` before it: largest first).

    With `owner` only the jobs of one API key; `limit` may be a pair, limit and offset. A job without a metric or field
    meets no condition on it, and is last in a sort by it.

    Raises:
        QueryBad: if a name is unknown or the limit is out of range.
    """
    count, offset = limit if isinstance(limit, tuple) else (limit, 0)
    if not 1 <= count <= MAX_QUERY_ROWS or not 0 <= offset <= MAX_QUERY_OFFSET:
        raise QueryBad(
            f"limit {count} is outside 1 to {MAX_QUERY_ROWS}, or offset {offset} outside 0 to {MAX_QUERY_OFFSET}."
        )
    with database.read() as session:
        return read_sorted(session, select_jobs(session, conditions, owner), sort, Page(count, offset))


def read_sorted(session: Session, statement: Select[Any], sort: str, page: Page) -> list[JobRow]:
    """Return a page of the jobs of a query in the order of a field or metric; those without it are last.

    Raises:
        QueryBad: if its name is unknown.
        CursorBad: if the page's cursor is none of this list.
    """
    name, is_falling = sort.removeprefix("-"), sort.startswith("-")
    field = TEXTS.get(name, NUMBERS.get(name))
    if field is not None:
        has = field.is_not(None)
        return read_page(session, (statement.where(has), statement.where(~has)), Order(field, is_falling), page)
    _check_metric(session, name)
    metric = aliased(MetricRow)
    on = (metric.job == JobRow.id) & (metric.name == name) & metric.value.is_not(None)
    parts = (statement.join(metric, on), statement.where(~exists().where(on)))
    return read_page(session, parts, Order(metric.value, is_falling), page)


def make_cursor(session: Session, job: JobRow, sort: str) -> Cursor:
    """Return the cursor of the page that follows a job in the order of a field or metric."""
    name = sort.removeprefix("-")
    field = TEXTS.get(name, NUMBERS.get(name))
    metric = select(MetricRow.value).where(MetricRow.job == job.id, MetricRow.name == name)
    value = session.scalar(metric) if field is None else getattr(job, field.key)
    return Cursor(sort, value, job.created, job.id)


@skip_damaged_rows
def find_roots(
    database: Database, conditions: Sequence[Condition], limit: int, owner: str | None = None, before: str | None = None
) -> list[JobRow]:
    """Return the newest root jobs that meet every condition; with `before` only those older than a job.

    The next page starts by the index of `created`, whatever its offset.

    Raises:
        QueryBad: if a name is unknown.
    """
    with database.read() as session:
        statement = select_jobs(session, conditions, owner).where(JobRow.parent.is_(None))
        last = session.scalar(select_jobs(session, (), owner).where(JobRow.id == before)) if before else None
        if last is not None:
            older = (JobRow.created == last.created) & (JobRow.id > last.id)
            statement = statement.where((JobRow.created < last.created) | older)
        return list(session.scalars(statement.order_by(JobRow.created.desc(), JobRow.id).limit(limit)))


@skip_damaged_rows
def find_families(
    database: Database, conditions: Sequence[Condition], limit: int, owner: str | None = None, before: str | None = None
) -> list[tuple[str, str]]:
    """Return ids and names of the newest root jobs of families in which one job meets every condition.

    Roots that work on another job's result are left out: they belong to that one. With `before` only those older than
    a job.

    Raises:
        QueryBad: if a name is unknown.
    """
    root = aliased(JobRow)
    statement = select(root.id, root.name).where(root.parent.is_(None), ~exists().where(JobInputRow.job == root.id))
    with database.read() as session:
        if owner is not None:
            statement = statement.where(_is_named(session, OwnerRow.job, OwnerRow.key == owner, root.id))
        if conditions:
            members = select_jobs(session, conditions, None).with_only_columns(JobRow.family)
            first = members.limit(MIN_EXISTS_MATCH_COUNT).subquery()
            count = session.scalar(select(func.count()).select_from(first)) or 0
            in_order = members.where(JobRow.family == root.id).correlate(root).exists()
            statement = statement.where(root.id.in_(members) if count < MIN_EXISTS_MATCH_COUNT else in_order)
        last = session.scalar(select_jobs(session, (), owner).where(JobRow.id == before)) if before else None
        if last is not None:
            older = (root.created == last.created) & (root.id > last.id)
            statement = statement.where((root.created < last.created) | older)
        rows = session.execute(statement.order_by(root.created.desc(), root.id).limit(limit))
        return [(row[0], row[1]) for row in rows]


def select_jobs(
    session: Session, conditions: Sequence[Condition], owner: str | None, rare: int = MIN_EXISTS_MATCH_COUNT
) -> Select[Any]:
    """Return the query for the jobs of an owner that meet every condition; `rare` as for `_is_rare`."""
    statement: Select[Any] = select(JobRow)
    if owner is not None:
        statement = statement.where(_is_named(session, OwnerRow.job, OwnerRow.key == owner, rare=rare))
    for condition in conditions:
        statement = statement.where(_meets(session, condition, rare))
    return statement


def _read_time(text: str) -> float:
    """Return a date and time as seconds since 1970; without a zone in this machine's, as tables show it."""
    return datetime.fromisoformat(text).timestamp()


def _condition(name: str, sign: str, value: str) -> Condition:
    if name in TEXTS or name in (TAG, SUBJECT):
        if sign not in ("=", "==", "!="):
            raise QueryBad(f"'{name}' is text; compare it by = or !=.")
        return Condition(name, sign, value)
    try:
        number = _read_time(value) if name in TIMES and "-" in value[1:] else float(value)
    except ValueError:
        raise QueryBad(f"'{name}' is compared with a number; '{value[:40]}' is not one.") from None
    return Condition(name, sign, number)


def _meets(session: Session, condition: Condition, rare: int) -> ColumnElement[bool]:
    """Return the SQL condition of a condition."""
    compare, name = OPERATORS[condition.operator], condition.name
    field = TEXTS.get(name, NUMBERS.get(name))
    if field is not None:
        value, other = _check_value(condition), aliased(JobRow)
        if _is_rare(session, other.id, compare(getattr(other, field.key), value), rare):
            return JobRow.id.in_(select(other.id).where(compare(getattr(other, field.key), value)))
        return cast(ColumnElement[bool], compare(field, value))
    if name == TAG:
        has = _is_named(session, JobTagRow.job, JobTagRow.tag == _check_value(condition), rare=rare)
        return has if compare is operator.eq else ~has
    if name == SUBJECT:
        value = _check_value(condition)
        people = select(SubjectRow.id).where(or_(SubjectRow.name == value, SubjectRow.id == value))
        has = _is_named(session, SubjectJobRow.job, SubjectJobRow.subject.in_(people), rare=rare)
        return has if compare is operator.eq else ~has
    _check_metric(session, name)
    metric = aliased(MetricRow)
    return _is_named(session, metric.job, (metric.name == name) & compare(metric.value, condition.value), rare=rare)


def _is_named(
    session: Session, job: Any, matches: ColumnElement[bool], of: Any = JobRow.id, rare: int = MIN_EXISTS_MATCH_COUNT
) -> ColumnElement[bool]:
    """Return the condition that matching rows of another table name a job, its id `of`, in their column `job`.

    If many rows match, each job is looked up in the order of the jobs until enough are found; if few match, the index
    of the other table lists them at once. The reverse is slow in a long table.
    """
    if _is_rare(session, job, matches, rare):
        return cast(ColumnElement[bool], of.in_(select(job).where(matches)))
    return exists().where(job == of, matches)


def _is_rare(session: Session, job: Any, matches: ColumnElement[bool], rare: int) -> bool:
    """Check whether fewer rows than `rare` match, so that all of them are named; no more than these are counted."""
    first = select(job).where(matches).limit(rare).subquery()
    return (session.scalar(select(func.count()).select_from(first)) or 0) < rare


def _check_value(condition: Condition) -> str | float:
    """Return the value of a condition on a field.

    Raises:
        QueryBad: if it contains a forbidden character, or is not a state where one is required.
    """
    if condition.name == "state" and condition.value not in list(State):
        raise QueryBad(f"there is no state '{str(condition.value)[:40]}'; there are {', '.join(State)}.")
    if isinstance(condition.value, str) and FORBIDDEN_CHARACTERS.search(condition.value):
        raise QueryBad(f"the value of '{condition.name}' contains a control character; leave it out.")
    return condition.value


def _check_metric(session: Session, name: str) -> None:
    """Refuse a name that no result has, unless there are no results yet.

    Raises:
        QueryBad: if it is unknown.
    """
    is_text = not FORBIDDEN_CHARACTERS.search(name)
    if not (is_text and session.execute(select(exists().where(MetricRow.name == name))).scalar()):
        known = session.scalars(select(MetricRow.name).distinct()).all()  # slow, so only for the message
        if known or not CONDITION.match(f"{name} = 0"):
            names = sorted([*TEXTS, TAG, SUBJECT, *NUMBERS, *known])
            near = get_close_matches(name[:60], names, n=1)
            meant = f"did you mean {near[0]}? There" if near else "there"
            raise QueryBad(f"there is no '{name[:60]}'; {meant} are {', '.join(names)}.")


@skip_damaged_rows
def list_jobs(database: Database, limit: int = 50) -> list[JobRow]:
    """Return the running jobs, then the newest others, each newest first."""
    newest, runs = select(JobRow).order_by(JobRow.created.desc(), JobRow.id), JobRow.state == State.RUNNING
    with database.read() as session:
        first = session.scalars(newest.where(runs).limit(limit)).all()
        return [*first, *session.scalars(newest.where(~runs).limit(limit - len(first)))]


@skip_damaged_rows
def count_states(database: Database) -> dict[State, int]:
    """Count the jobs by state."""
    with database.read() as session:
        rows = session.execute(select(JobRow.state, func.count()).group_by(JobRow.state)).all()
    return {row[0]: row[1] for row in rows}
