"""Read dataclasses from JSON by pydantic, which is imported with the first adapter, because that takes 0.25 s."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from pydantic import TypeAdapter
    from pydantic_core import CoreSchema

T = TypeVar("T")


def get_adapter(kind: type[T]) -> TypeAdapter[T]:
    """Return the adapter that reads a dataclass."""
    return _make_adapter(kind)  # type: ignore[arg-type]


@cache
def _make_adapter(kind: Any) -> TypeAdapter[Any]:
    from pydantic import TypeAdapter

    return TypeAdapter(kind)


@dataclass(frozen=True)
class ReadText:
    """Annotate a type whose JSON is a text: `make` returns the value, and raises ValueError for any other text."""

    make: Callable[[str], Any]

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> CoreSchema:
        """Return the schema, as pydantic asks for it."""
        from pydantic_core.core_schema import no_info_after_validator_function, str_schema

        return no_info_after_validator_function(self.make, str_schema())
