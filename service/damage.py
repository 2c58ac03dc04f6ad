"""Damaged rows: find them, name them, and exclude them from queries."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import LargeBinary, String, Table, Text, case, cast, event, func, not_, select
from sqlalchemy import type_coerce as coerce
from sqlalchemy.ext.compiler import compiles
from sqlalchemy.orm import ORMExecuteState, Session, with_loader_criteria
from sqlalchemy.sql.functions import FunctionElement
from sqlalchemy.sql.visitors import iterate

from .columns import SQLITE, is_sound, is_utf8
from .model_base import Base

MAX_NAMED_ROWS = 5
"""Number of damaged rows that one message names; `garmentq verify` lists them all."""

FILE_REFERENCE_COLUMNS = ("sha256", "scan", "request")
"""Columns that name stored files; see `garbage.find_references`."""


@dataclass(frozen=True)
class DamagedRow:
    """Describe a row that cannot be read: its table, its key, and the columns with invalid values."""

    table: str
    key: str
    columns: tuple[str, ...]

    def __str__(self) -> str:
        """Return it as text for a message."""
        return f"{self.table} '{self.key}' ({', '.join(self.columns)})"


class SoundSession(Session):
    """Read without the damaged rows; writes are as in any other session."""


@event.listens_for(SoundSession, "do_orm_execute")
def _exclude_damaged_rows(state: ORMExecuteState) -> None:
    if state.is_select:
        named = {one for one in iterate(state.statement) if isinstance(one, Table)}  # type: ignore[arg-type]
        rows = [mapper.class_ for mapper in Base.registry.mappers if mapper.local_table in named]
        sound = [with_loader_criteria(one, is_sound(*_list_columns(one)), include_aliases=True) for one in rows]
        state.statement = state.statement.options(*sound)


def _list_columns(row: type[Base]) -> list[Any]:
    return [getattr(row, attribute.key) for attribute in row.__mapper__.column_attrs]


def find_damaged(session: Session, tables: Sequence[str] = ()) -> list[DamagedRow]:
    """Return every row that cannot be read, of some tables or of all."""
    found: list[DamagedRow] = []
    for table in Base.metadata.sorted_tables:
        if not tables or table.name in tables:
            keys = [readable(column) for column in table.primary_key]
            flags = [case((is_sound(column), 1), else_=0) for column in table.columns]
            rows = session.connection().execute(select(*keys, *flags).where(not_(is_sound(*table.columns))))
            for row in rows:
                names = (column.name for column, flag in zip(table.columns, row[len(keys) :], strict=True) if not flag)
                found.append(DamagedRow(table.name, " ".join(map(str, row[: len(keys)])), tuple(names)))
    return found


def read_damaged_references(session: Session) -> Iterator[bytes]:
    """Yield the bytes of the columns that may name stored files, of the damaged rows."""
    dialect = session.get_bind().dialect.name
    for table in Base.metadata.sorted_tables:
        texts = [
            cast(coerce(table.columns[name], String()), Text)
            for name in FILE_REFERENCE_COLUMNS
            if name in table.columns
        ]
        if texts:
            plain = [cast(one, LargeBinary) if dialect == SQLITE else func.convert_to(one, "UTF8") for one in texts]
            for row in session.connection().execute(select(*plain).where(not_(is_sound(*table.columns)))):
                yield from (bytes(value) for value in row if value is not None)


def describe_damaged_rows(rows: Sequence[DamagedRow]) -> str:
    """Return what is damaged and what to do, as text for a message."""
    named = ", ".join(str(row) for row in rows[:MAX_NAMED_ROWS])
    more = f" and {len(rows) - MAX_NAMED_ROWS} more" if len(rows) > MAX_NAMED_ROWS else ""
    counted = f"{len(rows)} damaged row{'' if len(rows) == 1 else 's'} in the database"
    return (
        f"{counted}: {named}{more}; `garmentq verify` lists all. Repair or delete them by SQL, or restore an earlier "
        "backup (`garmentq restore BACKUP.tar` into another --home)."
    )


class readable(FunctionElement[str]):
    """Return a value as a text that can be read, whatever it contains."""

    inherit_cache = True
    name = "readable"
    type = Text()


@compiles(readable)
def _compile(element: readable, compiler: Any, **options: Any) -> str:
    value = compiler.process(element.clauses, **options)
    plain = f"CAST({value} AS TEXT)"
    return (
        f"CASE WHEN {is_utf8(value)} THEN {plain} ELSE hex({value}) END" if compiler.dialect.name == SQLITE else plain
    )
