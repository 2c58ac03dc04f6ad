"""Read a person's measures from a file as the description of a built-in body."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import Any

from ..run.errors import BadInput
from ..run.text import read_json
from .spec import BUILTIN

MAX_MEASURES_FILE_BYTES = 65_536
"""Largest size of a file of measures [bytes]: some hundred times the size of a usual one."""

NAMES = {
    "height": "height", "weight": "weight", "chest": "chest", "bust": "chest", "waist": "waist", "hip": "hip",
    "hips": "hip", "thigh": "thigh", "upper_arm": "upper_arm", "bicep": "upper_arm",
}  # fmt: skip
"""Accepted names of measures, and their names in a description."""

GENDERS = {"female": "female", "f": "female", "woman": "female", "male": "male", "m": "male", "man": "male"}

M_PER_CM = 0.01
"""Metres in a centimetre [m/cm]: files have lengths and girths in centimetres."""


class MeasuresBad(BadInput):
    """A file of measures is JSON {"gender": "female", "height": 170, "waist": 72} or CSV of name,value; cm, kg."""

    code = "body.measures_bad"


def read_measures(path: Path) -> str:
    """Read a file of measures as the description of a built-in body: `builtin:female,height=1.7,waist=0.72`.

    Args:
        path: A JSON object, or CSV with a name and a value per line; `gender`, lengths and girths in cm, `weight` in
            kg. Names in any case, with blanks or dashes for underscores.

    Raises:
        MeasuresBad: where it cannot be read, lacks the gender, or has an unknown name.
    """
    try:
        content = path.read_bytes()[: MAX_MEASURES_FILE_BYTES + 1]
        text = content.decode("utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise MeasuresBad(f"'{path.name}' cannot be read as text. {MeasuresBad().message}") from error
    if len(content) > MAX_MEASURES_FILE_BYTES:
        raise MeasuresBad(f"'{path.name}' is no file of measures: it is too large. {MeasuresBad().message}")
    gender, numbers = "", dict[str, float]()
    for name, value in _pairs(path, text):
        word = name.strip().lower().replace(" ", "_").replace("-", "_")
        if word in ("gender", "sex", "body"):
            gender = GENDERS.get(str(value).strip().lower(), "")
        elif word not in NAMES:
            known = ", ".join(sorted(set(NAMES.values())))
            raise MeasuresBad(f"'{name[:40]}' is no measure that is known: {known}, gender. {MeasuresBad().message}")
        elif NAMES[word] in numbers:
            raise MeasuresBad(f"'{NAMES[word]}' is given twice; leave one out.")
        else:
            numbers[NAMES[word]] = _number(name, value) * (1.0 if word == "weight" else M_PER_CM)
    if not gender:
        raise MeasuresBad(f"'{path.name}' does not say gender: female or male. {MeasuresBad().message}")
    return ",".join([f"{BUILTIN}{gender}", *(f"{name}={value:.6g}" for name, value in numbers.items())])


def _pairs(path: Path, text: str) -> list[tuple[str, Any]]:
    """Return names and values in the file's order."""
    if text.lstrip().startswith("{"):
        try:
            found = read_json(text, object_pairs_hook=list)
        except (ValueError, RecursionError) as error:
            raise MeasuresBad(f"'{path.name}' is no JSON. {MeasuresBad().message}") from error
        return [(str(name), value) for name, value in found]
    try:
        cells = [[cell.strip() for cell in row] for row in csv.reader(text.splitlines())]
    except csv.Error as error:
        raise MeasuresBad(f"'{path.name}' is no CSV. {MeasuresBad().message}") from error
    rows = [row for row in cells if any(row)]
    if any(len(row) != 2 for row in rows):
        raise MeasuresBad(f"'{path.name}' has lines that are not name,value. {MeasuresBad().message}")
    is_head = bool(rows) and rows[0][0].lower() in ("name", "measure")
    return [(name, value) for name, value in rows[is_head:]]


def _number(name: str, value: Any) -> float:
    try:
        number = math.nan if isinstance(value, bool | list) else float(value)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not (math.isfinite(number) and number > 0.0):
        raise MeasuresBad(f"{name[:40]} is '{str(value)[:40]}', which is no number above 0. {MeasuresBad().message}")
    return number
