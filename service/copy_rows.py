"""Copy every row of a server's database into an SQLite file, and back, in one transaction each.

Values are copied as the databases hold them, without being read, so that a damaged row is kept unchanged.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from sqlalchemy import JSON, Boolean, Column, Connection, Table, Text, cast, column, insert, select, table, text, update
from sqlalchemy import bindparam as bind
from sqlalchemy import type_coerce as coerce
from sqlalchemy.types import NullType, TypeDecorator, TypeEngine

from .columns import SQLITE
from .database import Database, translate_driver_errors, upgrade
from .model_base import Base

ROWS_AT_ONCE = 1000
"""Number of rows that are read and written together: of jobs, some megabytes."""


def dump_rows(database: Database, path: Path) -> None:
    """Write every row of a server's database into a new SQLite file: the state of one moment.

    Raises:
        DatabaseUnreachable: if the database does not respond.
    """
    copied = Database(f"sqlite:///{path}", pooled=False)
    upgrade(copied)
    moment = database.engine.execution_options(isolation_level="REPEATABLE READ", postgresql_readonly=True)
    try:
        with translate_driver_errors(database.url), moment.connect() as source, copied.engine.connect() as target:
            for one in Base.metadata.sorted_tables:
                _copy_table(source, target, one)
            target.commit()
    finally:
        copied.dispose()


def load_rows(path: Path, database: Database) -> None:
    """Replace every row of a server's database, which has the tables of this version, by those of an SQLite file.

    The file is upgraded first if an older version wrote it. Nothing is changed unless every row can be inserted.

    Raises:
        DatabaseTooNew: if a newer version wrote the file.
        DatabaseUnreachable: if the database does not respond.
    """
    saved = Database(f"sqlite:///{path}", pooled=False)
    upgrade(saved)
    try:
        with translate_driver_errors(database.url), saved.engine.connect() as source, database.write() as session:
            target = session.connection()
            tables = Base.metadata.sorted_tables
            target.execute(text(f"truncate {', '.join(one.name for one in tables)}"))
            for one in tables:
                _copy_table(source, target, one)
                _restart_sequence(target, one)
    finally:
        saved.dispose()


def _copy_table(source: Connection, target: Connection, rows: Table) -> None:
    """Copy the rows of one table; references within the table follow when all of its rows are there."""
    left = {one.name for one in rows.columns if any(key.column.table is rows for key in one.foreign_keys)}
    plain = table(rows.name, *(column(one.name, _find_plain_type(one)) for one in rows.columns))
    values = {one.name: _write(plain.c[one.name], one, target) for one in rows.columns if one.name not in left}
    for block in _read_blocks(source, rows):
        target.execute(insert(plain).values(values), [{f"to_{name}": row[name] for name in values} for row in block])
    keys = [one.name for one in rows.primary_key]
    for name in left:
        place = update(plain).values({name: bind(f"to_{name}")})
        for key in keys:
            place = place.where(plain.c[key] == bind(f"to_{key}"))
        for block in _read_blocks(source, rows):
            found = [{f"to_{part}": row[part] for part in (name, *keys)} for row in block if row[name] is not None]
            if found:
                target.execute(place, found)


def _read_blocks(source: Connection, rows: Table) -> Iterator[list[dict[str, object]]]:
    """Yield the rows of a table in blocks, JSON values as text."""
    is_sqlite = source.dialect.name == SQLITE
    columns = []
    for one in rows.columns:
        plain = coerce(one, _find_plain_type(one))
        columns.append((cast(one, Text) if _is_json(one) and not is_sqlite else plain).label(one.name))
    result = source.execution_options(yield_per=ROWS_AT_ONCE).execute(select(*columns).order_by(*rows.primary_key))
    for block in result.mappings().partitions():
        yield [dict(row) for row in block]


def _write(place: object, one: Column[Any], target: Connection) -> object:
    """Return the value of an INSERT: a JSON text becomes JSON where the database tells them apart."""
    value = bind(f"to_{one.name}", type_=Text() if _is_json(one) else _find_plain_type(one))
    return cast(value, JSON) if _is_json(one) and target.dialect.name != SQLITE else value


def _restart_sequence(target: Connection, rows: Table) -> None:
    """Let the next row get a number that none has."""
    for one in rows.primary_key:
        if one.autoincrement is True:
            last = f"select setval(pg_get_serial_sequence('{rows.name}', '{one.name}'), max({one.name}))"
            target.execute(text(f"{last} from {rows.name} having max({one.name}) is not null"))


def _find_plain_type(one: Column[Any]) -> TypeEngine[Any]:
    """Return the type under which a value is passed on as it is; only truth values differ between the databases."""
    kind = one.type.impl_instance if isinstance(one.type, TypeDecorator) else one.type
    return Boolean() if isinstance(kind, Boolean) else NullType()


def _is_json(one: Column[Any]) -> bool:
    kind = one.type.impl_instance if isinstance(one.type, TypeDecorator) else one.type
    return isinstance(kind, JSON)
