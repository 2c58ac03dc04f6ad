"""Read tables of sizes as people have them: units in the head, other words for measures, commas or semicolons."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Mapping
from typing import Any

import click

from ..core.run.text import read_json

UNITS = {
    "cm": 1.0, "centimetre": 1.0, "centimetres": 1.0, "centimeters": 1.0,
    "mm": 0.1, "millimetre": 0.1, "millimetres": 0.1, "millimeters": 0.1,
    "in": 2.54, "inch": 2.54, "inches": 2.54, '"': 2.54,
}  # fmt: skip
"""Words for units in the heads of tables, in centimetres."""

MEASURE_WORDS: Mapping[str, str] = {
    "name": "name", "size": "name",
    "bust": "bust", "chest": "bust", "bust girth": "bust", "chest girth": "bust",
    "waist": "waist", "waist girth": "waist",
    "hip": "hip", "hips": "hip", "hip girth": "hip", "seat": "hip",
    "height": "height", "stature": "height", "body height": "height",
    "neck": "neck", "neck girth": "neck", "neck size": "neck",
    "shoulder": "shoulder", "shoulder length": "shoulder",
    "upper arm": "upper_arm", "top arm": "upper_arm", "bicep": "upper_arm", "biceps": "upper_arm",
    "wrist": "wrist", "wrist girth": "wrist",
    "armhole depth": "armhole_depth", "armscye depth": "armhole_depth", "scye depth": "armhole_depth",
    "arm length": "arm_length", "sleeve length": "arm_length",
    "back length": "back_length", "nape to waist": "back_length", "back waist length": "back_length",
    "rise": "rise", "body rise": "rise",
}  # fmt: skip
"""Words for the columns of a table of sizes, each with the field of a size."""

UNIT_AT_END = re.compile(r"[\s_(\[/,]+(" + "|".join(sorted(UNITS, key=len, reverse=True)) + r")\s*[)\]]?\s*$")
"""A unit at the end of a head, after a blank, a bracket, a stroke or a comma."""


def read_sizes(text: str, unit: str = "cm") -> list[dict[str, Any]]:
    """Return the rows of a table of sizes in centimetres; their values are checked with the request.

    Args:
        text: CSV with commas, semicolons or tabs, or a JSON list of objects.
        unit: Unit of the columns whose head names none: one of `TABLE_UNITS`.

    Raises:
        UsageError: if it is neither a JSON list of objects nor CSV with a header, or a head is unknown.
    """
    try:
        if text.lstrip().startswith("["):
            found = read_json(text)
            if not all(isinstance(line, dict) for line in found):
                raise ValueError
            return [_read_line(line, unit) for line in found]
        heads = text.lstrip("\ufeff").splitlines()[0]
        separator = max(";\t,", key=heads.count)
        rows = list(csv.DictReader(io.StringIO(text.lstrip("\ufeff")), delimiter=separator))
        if not rows:
            raise ValueError
        return [
            _read_line({k: v.strip() for k, v in row.items() if k and v and v.strip()}, unit, separator) for row in rows
        ]
    except (ValueError, TypeError, AttributeError, IndexError, RecursionError, csv.Error) as error:
        raise click.UsageError(
            "a table of sizes needs the header name,bust,waist,hip,height and one line a size."
        ) from error


def _read_line(line: Mapping[str, Any], unit: str, separator: str = "") -> dict[str, Any]:
    """Return one line by the fields of a size, lengths in centimetres."""
    found: dict[str, Any] = {}
    for head, value in line.items():
        field, own = _read_head(head)
        if field in found:
            raise click.UsageError(f"two columns of the table say {field.replace('_', ' ')}; leave one out.")
        if field == "name":
            found[field] = str(value)
        elif value is not None:
            number = str(value).replace(",", ".") if separator != "," else value
            found[field] = round(float(number) * UNITS[own or unit], 4)
    return found


def _read_head(head: str) -> tuple[str, str]:
    """Return the field that a head names, and its unit or an empty text.

    Raises:
        UsageError: where it names none.
    """
    text = head.strip().lower()
    unit = UNIT_AT_END.search(text)
    words = " ".join(re.split(r"[_\-\s]+", text[: unit.start()] if unit else text)).strip()
    if words not in MEASURE_WORDS:
        known = ", ".join(dict.fromkeys(MEASURE_WORDS.values()))
        raise click.UsageError(f"no column of a table of sizes is called '{head[:40]}'; there are {known}.")
    return MEASURE_WORDS[words], unit[1] if unit else ""
