"""Get typed values from untrusted JSON; each error names the place."""

from __future__ import annotations

import math
from typing import Any

from .errors import PatternValueBad


def get_object(value: Any, where: str) -> dict[str, Any]:
    """Return a JSON object, or raise `PatternValueBad`."""
    if not isinstance(value, dict):
        raise PatternValueBad(f"{where} must be an object.")
    return value


def get_list(value: Any, where: str) -> list[Any]:
    """Return a JSON list, or raise `PatternValueBad`."""
    if not isinstance(value, list):
        raise PatternValueBad(f"{where} must be a list.")
    return value


def get_text(value: Any, where: str, most: int = 200) -> str:
    """Return a printable text of at most `most` characters, or raise `PatternValueBad`. Other characters are refused by
    databases (NUL, half of a surrogate pair), control terminals or reverse a line."""
    if not isinstance(value, str) or len(value) > most or not value.isprintable():
        raise PatternValueBad(f"{where} must be a text of at most {most} characters, none a control character.")
    return value


def get_number(value: Any, where: str, low: float, high: float) -> float:
    """Return a finite number within [low, high], or raise `PatternValueBad`; booleans count as 0 and 1."""
    if not isinstance(value, int | float):
        raise PatternValueBad(f"{where} must be a number.")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not low <= number <= high:
        raise PatternValueBad(f"{where} is out of range ({low:g} to {high:g}).")
    return number


def get_vector(value: Any, size: int, where: str, bound: float) -> list[float]:
    """Return `size` numbers of at most the bound each, or raise `PatternValueBad`."""
    items = get_list(value, where)
    if len(items) != size:
        raise PatternValueBad(f"{where} must have {size} numbers.")
    return [get_number(item, where, -bound, bound) for item in items]


def get_index(value: Any, count: int, where: str) -> int:
    """Return an index below count, or raise `PatternValueBad`."""
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < count:
        raise PatternValueBad(f"{where} must be a whole number from 0 to {count - 1}.")
    return value
