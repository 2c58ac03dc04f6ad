"""Read a person's measures from a file as the description of a built-in body."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from .measure_table import MeasuresBad, read_measure_table
from .spec import BUILTIN

MAX_MEASURES_FILE_BYTES = 65_536
"""Largest size of a file of measures [bytes]: some hundred times the size of a usual one."""

DESCRIBED = {
    "height": "height", "weight": "weight", "bust": "chest", "waist": "waist", "hip": "hip", "thigh": "thigh",
    "upper_arm": "upper_arm",
}  # fmt: skip
"""The measures of tables that a built-in body is described by, and their names there."""


@dataclass(frozen=True)
class PersonMeasures:
    """Describe a person by a file of measures.

    Attributes:
        spec: The description of a built-in body: `builtin:female,height=1.7,waist=0.72`.
        left: What of the file does not describe it, as it is written.
    """

    spec: str
    left: tuple[str, ...]


def read_measures(path: Path, unit: str = "") -> PersonMeasures:
    """Read a file of measures as the description of a built-in body.

    Args:
        path: A table of one person, as for `read_measure_table`, with the gender.
        unit: The unit of lengths without one, of `UNITS`, or an empty text: found by their sizes.

    Raises:
        MeasuresBad: where it cannot be read, lacks the gender, or has no measure that describes a body.
        MeasuresUnclear: where it can be read in two ways.
    """
    table = read_measure_table(read_table_text(path), unit)
    if len(table.rows) > 1:
        raise MeasuresBad(f"'{path.name}' has {len(table.rows)} persons or sizes; leave one.")
    row = table.rows[0]
    if not row.gender:
        raise MeasuresBad(f"'{path.name}' does not say gender: female or male. {MeasuresBad().message}")
    used = {DESCRIBED[name]: value for name, value in row.measures.items() if name in DESCRIBED}
    if not used:
        raise MeasuresBad(f"no measure in '{path.name}' describes a body: {', '.join(sorted(DESCRIBED))}.")
    spec = ",".join([f"{BUILTIN}{row.gender}", *(f"{name}={value:.6g}" for name, value in used.items())])
    return PersonMeasures(spec, (*table.left, *(name for name in row.measures if name not in DESCRIBED)))


def read_table_text(path: Path) -> str:
    """Read the text of a table: UTF-8, UTF-16 with its mark, or as spreadsheets on Windows write it (cp1252).

    Raises:
        MeasuresBad: where it is none of them, or too large.
    """
    try:
        with path.open("rb") as file:
            content = file.read(MAX_MEASURES_FILE_BYTES + 1)
    except OSError as error:
        raise MeasuresBad(f"'{path.name}' cannot be read. {MeasuresBad().message}") from error
    if len(content) > MAX_MEASURES_FILE_BYTES:
        raise MeasuresBad(f"'{path.name}' is no table of measures: it is too large. {MeasuresBad().message}")
    encodings = ("utf-16",) if content[:2] in (b"\xff\xfe", b"\xfe\xff") else ("utf-8-sig", "cp1252")
    for encoding in encodings:
        try:
            return content.decode(encoding)
        except UnicodeDecodeError:
            continue
    raise MeasuresBad(f"'{path.name}' cannot be read as text. {MeasuresBad().message}")
