"""HTML from templates: every value is escaped unless it is `Html`."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape
from string import Formatter
from typing import Any


class Html(str):
    """Mark text as HTML; only `html` and `join` create it."""

    __slots__ = ()


class _Escaping(Formatter):
    def format_field(self, value: Any, format_spec: str) -> str:
        return str(value) if isinstance(value, Html) else escape(format(value, format_spec), quote=True)

    def convert_field(self, value: Any, conversion: Any) -> Any:
        if conversion is not None:
            raise ValueError("a template of HTML converts nothing")
        return value


def html(template: str, *values: object, **named: object) -> Html:
    """Return a template, a constant of the program, with its fields filled in: `html("<p>{}</p>", text)`.

    A value that is `Html` is inserted unchanged; any other is escaped, including quotes. An attribute's field must be
    in quotes.
    """
    return Html(_Escaping().vformat(template, values, named))


def join(parts: Iterable[Html], between: str = "\n") -> Html:
    """Return HTML parts joined by `between`, a constant of the program."""
    found = list(parts)
    if not all(isinstance(one, Html) for one in found):
        raise TypeError("only HTML can be joined; make it by `html`")
    return Html(between.join(found))
