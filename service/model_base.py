"""Base class of all tables: names of constraints, and the column types of annotations."""

from __future__ import annotations

from typing import Any

from sqlalchemy import MetaData
from sqlalchemy.orm import DeclarativeBase

from .columns import Flag, Name, Real, Values, Whole, bind_column_types
from .states import State

NAMING = {
    "ix": "ix_%(table_name)s_%(column_0_N_name)s",
    "uq": "uq_%(table_name)s_%(column_0_N_name)s",
    "fk": "fk_%(table_name)s_%(column_0_N_name)s",
    "pk": "pk_%(table_name)s",
}
"""Fixed names of constraints, so that a later migration can drop them on every database."""


class Base(DeclarativeBase):
    """Collect the tables."""

    metadata = MetaData(naming_convention=NAMING)
    type_annotation_map = {  # noqa: RUF012
        float: Real(),
        int: Whole(),
        bool: Flag(),
        dict[str, Any]: Values(dict),
        list[Any]: Values(list),
        State: Name(State, 16),
    }

    def __init_subclass__(cls, **options: Any) -> None:
        """Create the table, and bind the column types to it."""
        super().__init_subclass__(**options)
        bind_column_types(cls.__table__)
