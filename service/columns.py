"""Column types that check the values they read: a value that no program of ours wrote is never returned.

SQLite keeps any value in any column; bit errors, a wrong UPDATE or a torn copy of the file leave invalid ones.
PostgreSQL itself checks all but the names of states and the form of JSON values.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from copy import copy
from decimal import Decimal
from enum import StrEnum
from typing import Any

from sqlalchemy import JSON, BigInteger, Boolean, Dialect, Double, Enum, Integer, String, Text
from sqlalchemy.ext.compiler import compiles
from sqlalchemy.sql.functions import FunctionElement
from sqlalchemy.types import TypeDecorator, TypeEngine

from ..core.run.errors import GarmentqError

SQLITE = "sqlite"

SERIAL = BigInteger().with_variant(Integer(), SQLITE)
"""An auto-incremented key; SQLite increments only its own INTEGER."""

FORMS: dict[type, str] = {dict: "object", list: "array"}
"""SQL's names of the forms of JSON values."""

MAX_GLOB_LENGTH = 100
"""Largest length of a text that SQLite's GLOB searches [letters]: it takes 30 ns a letter, a Python function 1 us."""

PLAIN = "*[^ -~]*"
"""Pattern (GLOB) of a text with a character outside printable ASCII: only such a text may be invalid UTF-8."""


class RowDamaged(GarmentqError):
    """A row of the database cannot be read; `garmentq verify` names it: repair it, or restore a backup."""

    code = "service.row_damaged"

    def __init__(self, message: str = "", table: str = "") -> None:
        """Name the table, if it is known."""
        super().__init__(message)
        self.table = table


class json_or_null(FunctionElement[Any]):
    """Return a column of JSON values, NULL for an invalid one: SQLite would abort the whole query at such a row."""

    inherit_cache = True
    name = "json_or_null"
    type = JSON()


@compiles(json_or_null, SQLITE)
def _compile_sqlite(element: json_or_null, compiler: Any, **options: Any) -> str:
    column = compiler.process(element.clauses, **options)
    return f"CASE WHEN json_valid({column}) THEN {column} END"


@compiles(json_or_null)
def _compile(element: json_or_null, compiler: Any, **options: Any) -> str:
    return str(compiler.process(element.clauses, **options))


class Checked(TypeDecorator[Any]):
    """Read a column's values, and refuse one that the column cannot hold."""

    impl = String
    cache_ok = True
    storage = "text"
    """Name that SQLite's `typeof` returns for a valid value."""
    raw: tuple[type, ...] = (object,)
    """Types of the driver's values, where its conversion accepts any type."""
    coerce_to_is_types = (type(None), bool)

    def __init__(self, kept: TypeEngine[Any], read: tuple[type, ...]) -> None:
        """Store values as a type of the database; Python reads them as one of some types."""
        super().__init__()
        self.read = read
        self.impl = kept  # type: ignore[assignment]
        self.place, self.is_optional = ("", ""), True

    def at(self, column: Any) -> Checked:
        """Return the type for one column, which errors then name."""
        copied = copy(self)
        copied.place, copied.is_optional = (column.table.name, column.name), bool(column.nullable)
        return copied

    def coerce_compared_value(self, op: Any, value: Any) -> Any:
        """Return the type of what a column is compared with, as without the check."""
        return self.impl_instance.coerce_compared_value(op, value)

    def result_processor(self, dialect: Dialect, coltype: object) -> Callable[[Any], Any]:
        """Return the function that reads a value.

        Raises (when a value is read):
            RowDamaged: if it is not valid in this column.
        """
        convert = self.impl_instance.result_processor(dialect, coltype)
        (table, column), known, raw, is_optional = self.place, self.read, self.raw, self.is_optional

        def read(value: Any) -> Any:
            if value is None:  # for example of an outer join
                return None
            try:
                found = value if convert is None else convert(value)
            except (LookupError, ValueError, TypeError, RecursionError) as error:
                raise RowDamaged(f"{table}.{column}: {type(error).__name__}", table) from error
            if found is None and is_optional:  # JSON's null, as an earlier version stored it
                return None
            if isinstance(found, known) and isinstance(value, raw):
                return found
            raise RowDamaged(f"{table}.{column}: {type(value).__name__}", table)

        return read

    def is_kept(self, value: str) -> str:
        """Return the SQL condition that SQLite holds a value, itself an SQL expression, in its column's type."""
        return f"typeof({value}) = '{self.storage}'"

    def is_allowed(self, value: str) -> str:
        """Return the SQL condition of what PostgreSQL does not check of a value by its type."""
        return "true"


class Words(Checked):
    """Read a text of at most some length [letters]; 0: of any length."""

    cache_ok = True

    def __init__(self, length: int = 0) -> None:
        """Store as VARCHAR, or as TEXT."""
        super().__init__(String(length) if length else Text(), (str,))
        self.length = length

    def is_kept(self, value: str) -> str:
        """Return the SQL condition that SQLite holds a value, itself an SQL expression, in its column's type."""
        return f"{super().is_kept(value)} AND {is_utf8(value)}"


class Real(Checked):
    """Read a number."""

    cache_ok = True
    storage = "real"

    def __init__(self) -> None:
        """Store as DOUBLE."""
        super().__init__(Double(), (float, int, Decimal))


class Whole(Checked):
    """Read a whole number."""

    cache_ok = True
    storage = "integer"

    def __init__(self, is_big: bool = False) -> None:
        """Store as INTEGER, or as BIGINT."""
        super().__init__(BigInteger() if is_big else Integer(), (int, Decimal))  # a sum comes as a Decimal
        self.is_big = is_big


class Flag(Checked):
    """Read true or false."""

    cache_ok = True
    storage = "integer"
    raw = (int, bool)

    def __init__(self) -> None:
        """Store as BOOLEAN."""
        super().__init__(Boolean(), (bool,))


class Name(Checked):
    """Read one of a closed set of names."""

    cache_ok = True

    def __init__(self, names: type[StrEnum], length: int) -> None:
        """Store as VARCHAR of a length."""
        values = [one.value for one in names]
        kept = Enum(names, native_enum=False, length=length, values_callable=lambda _: values)
        super().__init__(kept, (names,))
        self.names, self.length = names, length

    def is_kept(self, value: str) -> str:
        """Return the SQL condition that SQLite holds a value, itself an SQL expression, in its column's type."""
        return f"{super().is_kept(value)} AND {self.is_allowed(value)}"

    def is_allowed(self, value: str) -> str:
        """Return the SQL condition that a value, itself an SQL expression, is one of the names."""
        return f"{value} IN ({', '.join(repr(one.value) for one in self.names)})"


class Values(Checked):
    """Read JSON values: an object, or an array."""

    cache_ok = True

    def __init__(self, form: type) -> None:
        """Store as JSON; `form` is dict or list."""
        super().__init__(JSON(none_as_null=True), (form,))
        self.form = form

    def is_kept(self, value: str) -> str:
        """Return the SQL condition that SQLite holds a value, itself an SQL expression, in its column's type."""
        form = f"CASE WHEN json_valid({value}) THEN json_type({value}) ELSE garmentq_form(CAST({value} AS BLOB)) END"
        return f"{super().is_kept(value)} AND {is_utf8(value)} AND coalesce({form}, '') IN {self._list_forms()}"

    def is_allowed(self, value: str) -> str:
        """Return the SQL condition that a value, itself an SQL expression, has the form."""
        return f"json_typeof({value}) IN {self._list_forms()}"

    def _list_forms(self) -> str:
        """Return SQL's names of the form; an earlier version stored an optional value as JSON's null."""
        form = FORMS[self.form]
        return f"('{form}', 'null')" if self.is_optional else f"('{form}')"


class is_sound(FunctionElement[bool]):
    """Return whether the values of some columns can all be read."""

    inherit_cache = True
    name = "is_sound"
    type = Boolean()


@compiles(is_sound)
def _compile_sound(element: is_sound, compiler: Any, **options: Any) -> str:
    is_sqlite, parts = compiler.dialect.name == SQLITE, ["1 = 1"]
    for column in element.clauses:
        if isinstance(column.type, Checked):
            value = compiler.process(column, **options)
            sound = column.type.is_kept(value) if is_sqlite else column.type.is_allowed(value)
            parts.append(
                f"({value} IS NULL OR {sound})" if column.type.is_optional else f"({value} IS NOT NULL AND {sound})"
            )
    return f"({' AND '.join(parts)})"


def is_utf8(value: str) -> str:
    """Return the SQLite condition that a text, itself an SQL expression, is valid UTF-8."""
    is_suspect = f"length({value}) > {MAX_GLOB_LENGTH} OR {value} GLOB '{PLAIN}'"
    return f"CASE WHEN {is_suspect} THEN garmentq_is_utf8(CAST({value} AS BLOB)) ELSE 1 END"


def bind_column_types(table: Any) -> None:
    """Bind the type of each column to its table and column, for error messages."""
    for column in table.columns:
        if isinstance(column.type, Checked):
            column.type = column.type.at(column)


def add_functions(connection: Any) -> None:
    """Register on a SQLite connection the functions that the conditions call."""
    connection.create_function("garmentq_is_utf8", 1, _is_utf8, deterministic=True)
    connection.create_function("garmentq_form", 1, _find_form, deterministic=True)


def _is_utf8(value: bytes) -> bool:
    try:
        value.decode()
    except UnicodeDecodeError:
        return False
    return True


def _find_form(value: bytes | None) -> str | None:
    """Return the form of a JSON text as Python parses it, which accepts the NaN that SQLite refuses; None: not JSON."""
    try:
        found = None if value is None else json.loads(value)
    except (ValueError, RecursionError):
        return None
    return next((name for form, name in FORMS.items() if isinstance(found, form)), None)
