"""Read and write files of fabrics: JSON or CSV, each number with its unit and its source."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from ..run.errors import BadInput
from ..run.text import read_json
from .fabric import Fabric
from .fabric_check import check_fabric
from .fabrics import PARAMETERS

MAX_FABRIC_FILE_BYTES = 1_048_576
"""Largest size of a file of fabrics [bytes]: a thousand fabrics with short sources."""

UNITS = {
    "density": {"kg/m2": 1.0, "g/m2": 1e-3},
    "k": {"N m": 1.0, "uN m": 1e-6},
    "thickness": {"m": 1.0, "mm": 1e-3},
    "friction": {"1": 1.0},
    **{name: {"N/m": 1.0} for name in ("H00", "H01", "H11", "H22")},
}
"""Permitted units of each parameter, the SI unit first."""

COLUMNS = ("name", "title", "parameter", "value", "unit", "source")

Row = tuple[str, str, str, Any, str, str]
"""One number: the fabric's name and title, parameter, value, unit, source."""


class FabricFileBad(BadInput):
    """A file of fabrics is JSON or CSV as `garmentq materials export` writes it; export one to begin with."""

    code = "fabric.file_bad"


class FabricUnitBad(BadInput):
    """A number of a fabric has no unit, or one that is not known; `garmentq materials export` shows the units."""

    code = "fabric.unit_bad"


def read_fabrics(path: Path) -> list[Fabric]:
    """Read the fabrics of a file in its order and check each.

    Args:
        path: JSON `{"fabrics": [{"name", "title", "parameters": {NAME: {"value", "unit", "source"}}}]}`, or CSV with
            the columns `COLUMNS`, a number a line. Units as in `UNITS`.

    Raises:
        FabricFileBad: where it cannot be read, or lacks a number.
        FabricUnitBad: where a unit is missing or not the parameter's.
        FabricNameBad, FabricSourceBad, FabricOutOfRange: as `check_fabric` says.
    """
    try:
        with path.open("rb") as stream:
            content = stream.read(MAX_FABRIC_FILE_BYTES + 1)
        text = content.decode("utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise FabricFileBad(f"'{path.name}' cannot be read as text. {FabricFileBad().message}") from error
    if len(content) > MAX_FABRIC_FILE_BYTES:
        raise FabricFileBad(f"'{path.name}' is too large. {FabricFileBad().message}")
    rows = _read_json(text) if text.lstrip().startswith("{") else _read_csv(text)
    found: dict[str, dict[str, Row]] = {}
    for row in rows:
        numbers = found.setdefault(row[0], {})
        if row[2] not in UNITS or row[2] in numbers:
            raise FabricFileBad(f"'{row[2][:40]}' of '{row[0][:64]}' is no number of a fabric, or is given twice.")
        numbers[row[2]] = row
    if not found:
        raise FabricFileBad(f"'{path.name}' holds no fabric. {FabricFileBad().message}")
    return [check_fabric(_build(name, numbers)) for name, numbers in found.items()]


def write_fabrics(fabrics: Sequence[Fabric], path: Path) -> None:
    """Write fabrics in SI units for `read_fabrics`: CSV where the path ends in `.csv`, else JSON."""
    listed = [
        {
            "name": fabric.name,
            "title": fabric.title,
            "parameters": {
                name: {"value": getattr(fabric, name), "unit": next(iter(UNITS[name])), "source": source}
                for name, source in fabric.sources
            },
        }
        for fabric in fabrics
    ]
    if path.suffix.lower() != ".csv":
        path.write_text(json.dumps({"fabrics": listed}, indent=1) + "\n", encoding="utf-8")
        return
    with path.open("w", encoding="utf-8", newline="") as stream:
        sheet = csv.writer(stream)
        sheet.writerow(COLUMNS)
        sheet.writerows(_list_rows({"fabrics": listed}))


def _read_json(text: str) -> Iterator[Row]:
    try:
        found = read_json(text)
    except (ValueError, RecursionError) as error:
        raise FabricFileBad(f"this is no JSON. {FabricFileBad().message}") from error
    try:
        rows = list(_list_rows(found))
    except (KeyError, TypeError, AttributeError) as error:
        raise FabricFileBad() from error
    names = [one["name"] for one in found["fabrics"]]
    if len(set(names)) != len(names):
        raise FabricFileBad("two fabrics of the file have the same name; leave one out.")
    yield from rows


def _list_rows(found: Any) -> Iterator[Row]:
    for one in found["fabrics"]:
        for name, number in one["parameters"].items():
            row = (one["name"], one.get("title", ""), name, number["value"], number.get("unit", ""), number["source"])
            if not all(isinstance(cell, str) for cell in (*row[:3], *row[4:])):
                raise FabricFileBad(f"'{name[:40]}' has a field that is not a text. {FabricFileBad().message}")
            yield row


def _read_csv(text: str) -> Iterator[Row]:
    try:
        head, *lines = [row for row in csv.reader(io.StringIO(text)) if any(cell.strip() for cell in row)]
    except (csv.Error, ValueError) as error:
        raise FabricFileBad(f"this is no CSV. {FabricFileBad().message}") from error
    if tuple(cell.strip().lower() for cell in head) != COLUMNS or any(len(row) != len(COLUMNS) for row in lines):
        raise FabricFileBad(f"CSV of fabrics has the columns {', '.join(COLUMNS)}. {FabricFileBad().message}")
    for row in lines:
        name, title, parameter, value, unit, source = (cell.strip() for cell in row)
        yield name, title, parameter, value, unit, source


def _build(name: str, numbers: dict[str, Row]) -> Fabric:
    missing = [one for one in PARAMETERS if one not in numbers]
    if missing:
        raise FabricFileBad(f"'{name[:64]}' lacks {', '.join(missing)}. {FabricFileBad().message}")
    values = {one: _read_number(numbers[one]) for one in PARAMETERS}
    titles = [row[1] for row in numbers.values() if row[1]]
    sources = tuple((one, numbers[one][5]) for one in PARAMETERS)
    return Fabric(name=name, title=titles[0] if titles else "", sources=sources, **values)


def _read_number(row: Row) -> float:
    """Return a number in its SI unit."""
    name, _, parameter, value, unit, _ = row
    if unit not in UNITS[parameter]:
        known = " or ".join(f"'{one}'" for one in UNITS[parameter])
        raise FabricUnitBad(f"{parameter} of '{name[:64]}' is in '{unit[:20]}'; give it in {known}.")
    try:
        number = math.nan if isinstance(value, bool) else float(value)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not math.isfinite(number):
        raise FabricFileBad(f"{parameter} of '{name[:64]}' is '{str(value)[:40]}', which is no number.")
    return number * UNITS[parameter][unit]
