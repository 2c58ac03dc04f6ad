"""Take a table of measures apart into rows of headings and values, whatever its form."""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from typing import Any

from ..run.errors import BadInput
from ..run.text import UNSTORABLE_CHARACTERS, read_json
from .measure_names import GENDER_HEADINGS, ROW_HEADINGS, UNIT_WORDS, find_measures, simplify, split_unit
from .measure_values import read_value

MAX_MEASURE_CELLS = 20_000
"""Largest number of values of a table: some hundred sizes with all measures."""

MAX_MEASURES_DEPTH = 4
"""Largest number of objects within each other in a file of measures."""

UNIT_HEADINGS = ("unit", "units", "einheit", "einheiten", "unite", "unites", "unita", "unidad", "unidades")

VALUE_HEADINGS = ("value", "values", "wert", "mass", "valeur", "valore", "valor", *UNIT_WORDS)


@dataclass(frozen=True)
class Cell:
    """Describe one value of a table with its heading, and its unit where a column has units."""

    heading: str
    value: Any
    unit: str = ""


@dataclass(frozen=True)
class Row:
    """Describe one person or size: its name, and the unit of the whole file, or empty texts."""

    cells: tuple[Cell, ...]
    name: str = ""
    unit: str = ""


def read_rows(text: str, error: type[BadInput]) -> list[Row]:
    """Take a table apart: JSON, YAML of two levels, or lines with separators.

    Raises:
        BadInput: of the class `error`, where it is none of them or too large.
    """
    if UNSTORABLE_CHARACTERS.search(text):
        raise error(f"it holds letters that no text has. {error().message}")
    start = text.lstrip("\ufeff \t\r\n")
    if start.startswith(("{", "[")):
        try:
            found = read_json(start, object_pairs_hook=list)
        except (ValueError, RecursionError) as wrong:
            raise error(f"it is no JSON. {error().message}") from wrong
        rows = _rows_of_json(found, error)
    elif _is_yaml(start):
        rows = [_row_of_pairs(_read_yaml(start, error))]
    else:
        rows = _rows_of_lines(start, error)
    if sum(len(row.cells) for row in rows) > MAX_MEASURE_CELLS:
        raise error(f"a table has at most {MAX_MEASURE_CELLS} values. {error().message}")
    return rows


def _is_pairs(value: Any) -> bool:
    """Check whether a JSON value is an object, read as pairs."""
    return isinstance(value, list) and all(isinstance(one, tuple) for one in value)


def _rows_of_json(found: Any, error: type[BadInput]) -> list[Row]:
    """Return the row of an object, or those of a list of objects; objects within an object belong to it."""
    if isinstance(found, list) and found and not _is_pairs(found):
        if not all(_is_pairs(one) for one in found):
            raise error(f"a list of sizes holds objects. {error().message}")
        return [_row_of_pairs(_flat_pairs(one, error)) for one in found]
    return [_row_of_pairs(_flat_pairs(found, error))]


def _flat_pairs(found: list[Any], error: type[BadInput], depth: int = 0) -> list[tuple[str, Any]]:
    if depth > MAX_MEASURES_DEPTH:
        raise error(f"its objects lie too deep within each other. {error().message}")
    pairs: list[tuple[str, Any]] = []
    for name, value in found:
        if value and _is_pairs(value):
            pairs += _flat_pairs(value, error, depth + 1)
        else:
            pairs.append((str(name), value))
    return pairs


def _row_of_pairs(pairs: list[tuple[str, Any]]) -> Row:
    """Return a row of names and values; a name of the row and the unit of all are told by their headings."""
    cells, name, unit = [], "", ""
    for heading, value in pairs:
        word = simplify(heading)
        if word in UNIT_HEADINGS and isinstance(value, str) and value.strip().lower() in UNIT_WORDS:
            unit = value.strip().lower()
        elif word in ROW_HEADINGS and isinstance(value, str | int):
            name = str(value).strip()
        elif value is not None and str(value).strip():
            cells.append(Cell(heading, value))
    return Row(tuple(cells), name, unit)


def _is_yaml(text: str) -> bool:
    """Check whether the first line with content is `name:` or `name: value`, without separators of a table."""
    lines = (line.split("#")[0].strip() for line in text.splitlines())
    first = next((line for line in lines if line and line != "---"), "")
    return re.fullmatch(r"[^,;\t|:]+:(\s+[^,;\t|]*)?", first) is not None


def _read_yaml(text: str, error: type[BadInput]) -> list[tuple[str, Any]]:
    """Read YAML whose values are plain scalars: without anchors, tags, lists and objects in one line."""
    pairs = []
    for line in text.splitlines():
        plain = re.sub(r"(^|\s)#.*$", "", line).rstrip()
        if not plain.strip() or plain.strip() in ("---", "..."):
            continue
        found = re.fullmatch(r"\s*([^:]+?)\s*:(?:\s+(.*))?", plain)
        value = (found[2] or "").strip() if found else ""
        if not found or value.startswith(("&", "*", "!", "{", "[", "|", ">")):
            raise error(f"it is no table that is known: '{plain.strip()[:40]}'. {error().message}")
        if len(value) > 1 and value[0] == value[-1] and value[0] in "\"'":
            value = value[1:-1]
        pairs.append((found[1].strip("\"'"), value))
    return [(name, value) for name, value in pairs if value]


def _rows_of_lines(text: str, error: type[BadInput]) -> list[Row]:
    """Return the rows of lines with separators: a measure a line, a size a line, or a measure a line of all sizes."""
    first = next((line for line in text.splitlines() if line.strip()), "")
    separator = max("\t;|,", key=lambda one: (one in first, "\t;|,".index(one) == 0, one != ","))
    # A quote is a mark of inches within a value; it quotes a cell at its beginning alone.
    try:
        lines = [[cell.strip() for cell in row] for row in csv.reader(text.splitlines(), delimiter=separator)]
    except csv.Error as wrong:
        raise error(f"it is no table. {error().message}") from wrong
    lines = [row for row in lines if any(row)]
    if not lines:
        raise error(f"it is empty. {error().message}")
    head = lines[0]
    if sum(_is_known(one) for one in head) > max(1, sum(_is_known(row[0]) for row in lines[1:])) or (
        len(head) > 1 and all(_is_known(one) or simplify(one) in ROW_HEADINGS for one in head)
    ):
        return _rows_of_wide(lines, error)
    return _rows_of_long(lines, error)


def _is_known(heading: str) -> bool:
    plain = split_unit(heading)[0]
    return bool(find_measures(plain)) or simplify(plain) in GENDER_HEADINGS


def _rows_of_wide(lines: list[list[str]], error: type[BadInput]) -> list[Row]:
    """Return a row for each line below the headings. A first column without a measure's heading has names."""
    head = lines[0]
    rows = []
    for line in lines[1:]:
        if len(line) > len(head) and any(line[len(head) :]):
            raise error(f"a line has {len(line)} values below {len(head)} headings. {error().message}")
        pairs = [(heading, value) for heading, value in zip(head, line, strict=False) if value]
        if pairs and not head[0]:
            pairs[0] = ("name", pairs[0][1]) if pairs[0][0] == head[0] else pairs[0]
        elif pairs and pairs[0][0] == head[0] and read_value(pairs[0][1]) is None and simplify(head[0]) == "taille":
            pairs[0] = ("name", pairs[0][1])
        row = _row_of_pairs(pairs)
        if not row.name and head and simplify(head[0]) in ("grosse", "taille") and line[0]:
            row = Row(row.cells, line[0], row.unit)
        rows.append(row)
    if not rows:
        raise error(f"it has headings and no values. {error().message}")
    return rows


def _rows_of_long(lines: list[list[str]], error: type[BadInput]) -> list[Row]:
    """Return the row of a person whose measures are one a line, or the rows of sizes that are columns."""
    width = max(len(row) for row in lines)
    if width < 2:
        raise error(f"it has lines that are not name,value. {error().message}")
    names: list[str] = [""] * (width - 1)
    head = lines[0]
    is_head = not _is_known(head[0]) and (simplify(head[0]) in ROW_HEADINGS or not head[0])
    if is_head and (width > 2 or simplify(head[1]) in VALUE_HEADINGS or head[1].lower() in UNIT_WORDS):
        names, lines = [*head[1:], *[""] * (width - len(head))], lines[1:]
    units, columns = _split_columns(lines, names, width)
    if any(len(row) < 2 for row in lines):
        raise error(f"it has lines that are not name,value. {error().message}")
    of_column = names[columns[0] - 1].lower() if len(columns) == 1 else ""  # beside others, M is a size
    file_unit = of_column if of_column in UNIT_WORDS else ""
    rows = []
    for at in columns:
        cells, name, unit = [], names[at - 1] if len(columns) > 1 else "", file_unit
        for line in lines:
            own = _row_of_pairs([(line[0], line[at])]) if len(line) > at else Row(())
            name, unit = own.name or name, own.unit or unit
            of_line = line[units] if units and len(line) > units else ""
            cells += [Cell(cell.heading, cell.value, of_line) for cell in own.cells]
        rows.append(Row(tuple(cells), name, unit))
    return rows


def _split_columns(lines: list[list[str]], names: list[str], width: int) -> tuple[int, list[int]]:
    """Return the column that has units, or 0, and the columns that have values."""
    for at in range(2, width):
        texts = [row[at].lower() for row in lines if len(row) > at and row[at]]
        is_unit = simplify(names[at - 1]) in UNIT_HEADINGS
        if is_unit or (texts and all(one in UNIT_WORDS or one in ("kg", "lb", "°", "deg") for one in texts)):
            return at, [one for one in range(1, width) if one != at]
    return 0, list(range(1, width))
