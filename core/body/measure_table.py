"""Read tables of measures as people have them: one person or many sizes, CSV, JSON or YAML, in five languages."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from ..run.errors import BadInput, keep_printable
from ..run.units import UNITS
from .measure_cells import Row, read_rows
from .measure_names import GENDER_HEADINGS, GENDERS, MEASURE_KINDS, Quantity, find_measures, simplify, split_unit
from .measure_values import Value, read_value

MAX_NAMED_VALUES = 6
"""Largest number of values or headings that a message names [1]."""

UNIT_OPTION = "Say it with --units (cm, inch, mm, m), or write the unit beside the values: 92 cm, or bust (cm)."


class MeasuresBad(BadInput):
    """A table of measures has one line each, name,value or a size; lengths in cm or with units; see the reference."""

    code = "body.measures_bad"


class MeasuresUnclear(BadInput):
    """A table of measures can be read in two ways; say which unit it has with --units."""

    code = "body.measures_unclear"


@dataclass(frozen=True)
class MeasuredRow:
    """Describe the measures of one person or size.

    Attributes:
        name: Of the person or size, as it is written, or an empty text.
        gender: `female`, `male`, or an empty text.
        measures: Lengths and girths [m], weights [kg] and angles [rad], by the names of `MEASURE_KINDS`.
    """

    name: str
    gender: str
    measures: dict[str, float]


@dataclass(frozen=True)
class MeasureTable:
    """Describe a table of measures.

    Attributes:
        rows: One person, or sizes in the table's order.
        unit: What lengths without a unit were read in, or an empty text where each has its own.
        left: What was not understood, as it is written: `age: 34`.
    """

    rows: tuple[MeasuredRow, ...]
    unit: str
    left: tuple[str, ...]


def read_measure_table(text: str, unit: str = "", are_persons: bool = True) -> MeasureTable:
    """Read a table of measures.

    Lengths without a unit have the one unit of m, cm and mm in which all are a person's; a height may be in metres
    beside girths in centimetres. Inches are never assumed: where they, too, give a person, the table is unclear.

    Args:
        text: CSV with commas, semicolons, tabs or bars, one measure or one size a line; a JSON object or list; YAML of
            two levels. Headings as in `MEASURE_KINDS`, numbers as `read_value` takes them.
        unit: The unit of lengths without one, of `UNITS`, or an empty text: found by their sizes.
        are_persons: Whether values with units are to be a person's, too; sizes are checked with their export.

    Raises:
        MeasuresBad: where it is no table of measures, or a value of a measure is no number, or no person's.
        MeasuresUnclear: where units or a heading can be read in two ways.
    """
    rows, left = read_rows(text, MeasuresBad), list[str]()
    file_unit = next((one.unit for one in rows if one.unit), "")
    found = [_read_row(row, file_unit, left) for row in rows]
    if not any(one.values for one in found):
        raise MeasuresBad(f"no measure is known in it. {MeasuresBad().message}")
    bare = {(i, name): value.number for i, one in enumerate(found) for name, value in one.values.items()
            if value.scale is None and MEASURE_KINDS[name].quantity == Quantity.LENGTH}  # fmt: skip
    scales, chosen = _find_unit(bare, unit)
    done = tuple(
        MeasuredRow(one.name, one.gender, {
            name: _to_si(name, value, scales.get(name, 1.0)) for name, value in one.values.items()
        })
        for one in found
    )  # fmt: skip
    if are_persons:
        _check_spans(done)
    return MeasureTable(done, chosen, tuple(dict.fromkeys(left)))


@dataclass
class _FoundRow:
    name: str = ""
    gender: str = ""
    values: dict[str, Value] = field(default_factory=dict)


def _read_row(row: Row, file_unit: str, left: list[str]) -> _FoundRow:
    """Read the cells of a row; what is not understood is added to `left`."""
    found = _FoundRow(row.name)
    headings = [split_unit(cell.heading)[0] for cell in row.cells]
    for cell in row.cells:
        heading, unit = split_unit(cell.heading)
        text = str(cell.value).strip()
        if simplify(heading) in GENDER_HEADINGS and not text.replace(".", "").isdigit():
            gender = GENDERS.get(simplify(text), "")
            if not gender:
                raise MeasuresBad(f"'{keep_printable(text[:40])}' is no gender that is known: female or male.")
            found.gender = gender
            continue
        name = _name_of(heading, text, headings)
        if not name:
            if text == row.name:  # Größe, Taille: the size
                continue
            left.append(keep_printable(f"{cell.heading.strip()[:40]}: {text[:40]}"))
            continue
        is_length = MEASURE_KINDS[name].quantity == Quantity.LENGTH
        value = read_value(cell.value, cell.unit.lower() or unit or (file_unit if is_length else ""))
        if value is None:
            raise MeasuresBad(
                f"{keep_printable(cell.heading[:40])} is '{keep_printable(text[:40])}', which is no number, "
                f"with a unit or without. {MeasuresBad().message}"
            )
        if name in found.values and found.values[name] != value:
            raise MeasuresBad(f"'{name}' is given twice, with other values; leave one out.")
        found.values[name] = value
    return found


def _name_of(heading: str, text: str, headings: list[str]) -> str:
    """Return the measure that a heading means among all headings, or an empty text."""
    name = _meaning(heading, headings)
    if name == "height" and simplify(heading) in ("grosse", "taille"):  # a size, or a height
        value = read_value(text)
        low, high = MEASURE_KINDS["height"].span
        is_height = value is not None and any(low <= value.number * scale <= high for scale in (1.0, 0.01, 0.001))
        return "height" if is_height or (value is not None and value.scale) else ""
    return name


def _meaning(heading: str, headings: Iterable[str]) -> str:
    """Return the measure of a heading; `hips` beside `seat` are the high hips, as pattern makers call them."""
    found = [name for name, _ in find_measures(heading)]
    others = [one for one in headings if one != heading]
    if simplify(heading) == "taille":
        return _meaning_of_taille(others)
    if "hip" in found and simplify(heading) in ("hip", "hips") and "seat" in map(simplify, others):
        return "high_hip"
    return found[0] if found else ""


def _meaning_of_taille(others: list[str]) -> str:
    """Return what `taille` is: the waist (German, French), or the height (French), by the other headings.

    Raises:
        MeasuresUnclear: where these do not show it.
    """
    known = [pair for other in others if simplify(other) != "taille" for pair in find_measures(other)]
    names, languages = {name for name, _ in known}, {language for _, language in known}
    if "waist" in names:
        return "height"
    if "height" in names or ("de" in languages and "fr" not in _own_languages(others)):
        return "waist"
    raise MeasuresUnclear("'taille' is the waist or the height; write 'tour de taille', or 'stature'.")


def _own_languages(headings: list[str]) -> set[str]:
    """Return the languages of headings that are of one language alone."""
    found = [{language for _, language in find_measures(one)} for one in headings]
    return {next(iter(one)) for one in found if len(one) == 1}


def _find_unit(bare: dict[tuple[int, str], float], unit: str) -> tuple[dict[str, float], str]:
    """Return the scale of each measure's lengths without a unit, and how they were read.

    Raises:
        MeasuresBad: where no unit makes all of them a person's.
        MeasuresUnclear: where inches make them a person's.
    """
    names = {name for _, name in bare}
    if not bare or unit:
        return dict.fromkeys(names, UNITS[unit or "cm"]), unit if bare else ""
    readings = {one: dict.fromkeys(names, UNITS[one]) for one in ("cm", "m", "mm", "inch")}
    if "height" in names:
        readings["cm, height in m"] = {name: 1.0 if name == "height" else UNITS["cm"] for name in names}
    misfits = {
        one: [name for (_, name), number in bare.items() if not _is_in_span(name, number * scales[name])]
        for one, scales in readings.items()
    }
    fitting = [one for one in readings if not misfits[one]]
    if len(fitting) == 1 and fitting[0] != "inch":
        return readings[fitting[0]], fitting[0]
    if fitting:
        readable = "; or ".join(f"{one}: {_in_cm(bare, readings[one])}" for one in dict.fromkeys([*fitting, "cm"]))
        raise MeasuresUnclear(f"The lengths have no unit, and read as {readable}. {UNIT_OPTION}")
    best = min(("cm", "m", "mm", "inch"), key=lambda one: len(misfits[one]))
    wrong = misfits[best][0]
    numbers = ", ".join(f"{number:g}" for (_, name), number in bare.items() if name == wrong)
    raise MeasuresBad(f"{wrong} {numbers} {best} is no person's {wrong}; correct it. {UNIT_OPTION}")


def _in_cm(bare: dict[tuple[int, str], float], scales: dict[str, float]) -> str:
    first = list(bare.items())[:MAX_NAMED_VALUES]
    return ", ".join(f"{name} {100.0 * number * scales[name]:.4g} cm" for (_, name), number in first)


def _is_in_span(name: str, value: float) -> bool:
    low, high = MEASURE_KINDS[name].span
    return low <= value <= high


def _to_si(name: str, value: Value, scale: float) -> float:
    """Return a value in SI; angles without a unit are degrees, weights kilograms."""
    quantity = MEASURE_KINDS[name].quantity
    default = {Quantity.LENGTH: scale, Quantity.WEIGHT: 1.0, Quantity.ANGLE: 0.017453292519943295}[quantity]
    return value.number * (default if value.scale is None else value.scale)


def _check_spans(rows: tuple[MeasuredRow, ...]) -> None:
    """Check that each measure is a person's.

    Raises:
        MeasuresBad: where one is not.
    """
    for row in rows:
        for name, value in row.measures.items():
            if not _is_in_span(name, value):
                quantity = MEASURE_KINDS[name].quantity
                unit = {Quantity.LENGTH: "m", Quantity.WEIGHT: "kg", Quantity.ANGLE: "rad"}[quantity]
                low, high = MEASURE_KINDS[name].span
                raise MeasuresBad(
                    f"{name} is {value:.4g} {unit}, and of persons {low:g} to {high:g} {unit}; correct it, or its unit."
                )
