"""Read one value of a table of measures: a number, with the unit that is written beside it."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any

from ..run.units import UNITS
from .measure_names import UNIT_WORDS, WEIGHT_UNITS

VULGAR_FRACTIONS = {"¼": " 1/4", "½": " 1/2", "¾": " 3/4", "⅛": " 1/8", "⅜": " 3/8", "⅝": " 5/8", "⅞": " 7/8"}

NUMBER = r"(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][-+]?\d+)?(?:\s+\d+/\d+)?|\d+/\d+"

VALUE = re.compile(rf"({NUMBER})\s*(['\"’′″”]{{1,2}}|[a-zäöüéè°]*)\.?\s*")

MAX_VALUE_LENGTH = 40
"""Largest number of letters of a value; a longer one is no number with its unit."""


@dataclass(frozen=True)
class Value:
    """Describe a value of a table: a number without unit, or one in metres or kilograms.

    Attributes:
        number: In its unit.
        scale: What one unit is in SI, or None where no unit is written.
    """

    number: float
    scale: float | None = None


def read_value(written: Any, unit: str = "") -> Value | None:
    """Read a value as people write it: `92`, `92,5`, `92 cm`, `5'6"`, `36 1/2 in`, `62 kg`.

    Args:
        written: A number or a text.
        unit: The unit of its column or file, as it is written there, or an empty text.

    Returns:
        The value, or None where it is no finite number.
    """
    if isinstance(written, bool) or not isinstance(written, int | float | str):
        return None
    text = str(written).strip()
    for letter, fraction in VULGAR_FRACTIONS.items():
        text = text.replace(letter, fraction)
    if len(text) > MAX_VALUE_LENGTH:
        return None
    sign = -1.0 if text.startswith("-") else 1.0
    text = text.removeprefix("-")
    parts, at = [], 0
    while at < len(text):
        found = VALUE.match(text.lower(), at)
        if not found:
            return None
        parts.append((_number(found[1]), found[2]))
        at = found.end()
    if not parts or len(parts) > 2 or not all(math.isfinite(number) for number, _ in parts):
        return None
    if len(parts) == 2:  # feet and inches: 5'6", 5 ft 6
        (feet, one), (inches, other) = parts
        if sign < 0.0 or UNIT_WORDS.get(one) != "foot" or UNIT_WORDS.get(other or "in") != "inch" or inches >= 12.0:
            return None
        return Value(12.0 * feet + inches, UNITS["inch"])
    number, own = sign * parts[0][0], parts[0][1]
    return Value(number) if not (own or unit) else _scaled(number, own or unit)


def _scaled(number: float, unit: str) -> Value | None:
    if unit in UNIT_WORDS:
        return Value(number, UNITS[UNIT_WORDS[unit]])
    if unit in ("°", "deg", "degrees", "grad"):
        return Value(number, math.radians(1.0))
    return Value(number, WEIGHT_UNITS[unit]) if unit in WEIGHT_UNITS else None


def _number(text: str) -> float:
    """Return a number of digits, a decimal point or comma, and a fraction."""
    whole, _, fraction = text.rpartition(" ") if "/" in text else (text, "", "")
    found = float(whole.strip().replace(",", ".")) if whole else 0.0
    if fraction:
        over, under = (float(one) for one in fraction.split("/"))
        found += over / under if under else math.nan
    return found
