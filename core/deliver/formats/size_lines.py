"""The lines of a table of sizes, and whether they can be meant as they are."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from itertools import pairwise
from types import MappingProxyType

from ...run.errors import keep_printable
from .errors import SizesBad, SizesUnclear
from .registry import TABLE_UNITS

MAX_SIZE_COUNT = 40
"""Largest number of sizes in one export."""

MAX_TABLE_NAME_LENGTH = 40
"""Largest length of a size's name in a table [letters]: no file hash, of 64 letters, can be a name. A DXF block's name
has 31 with the piece's."""

MIN_MEASURE_CM, MAX_MEASURE_CM = 20.0, 300.0
"""Smallest and largest accepted girth or height [cm]."""

GIRTH_RANGE_CM = (45.0, 200.0)
"""Usual range of girths of the trunk [cm]: of a child of 95 cm, the smallest body that is read, and of the largest
sizes of clothes."""

HEIGHT_RANGE_CM = (85.0, 230.0)
"""Usual range of heights [cm]: those of the bodies that are read, 95 cm to 2.4 m, and a child's first sizes."""

MAX_SIZE_STEP_CM = 16.0
"""Largest usual step of a girth between two sizes [cm]: double sizes of large women are 12 cm apart."""

MAX_WAIST_HIP_RATIO = 1.35
"""Largest usual ratio of a waist to hips [1]; assumed: beyond it columns are exchanged or misprinted."""

LEFT_OUT: Mapping[str, bool] = MappingProxyType({"is_left_out": True})
"""Metadata of fields that a stored order leaves out while they are None, so that older orders keep their hash."""

GIRTHS = ("bust", "waist", "hip")
"""Girths of a line that a wearer is found by."""


@dataclass(frozen=True)
class SizeLine:
    """Describe one size of a table: its name, girths and height of its wearer [cm], None for the wearer of the pattern
    that is graded; and measures of which only the differences between sizes count [cm], None for the usual ones.

    Attributes:
        name: Of the size.
        bust, waist, hip, height: Of the size's wearer [cm].
        neck, upper_arm, wrist: Girths [cm].
        shoulder: Length of one shoulder [cm].
        armhole_depth: From the shoulder down to the chest [cm].
        arm_length: From the shoulder to the wrist [cm].
        back_length: From the nape to the waist [cm].
        rise: Body rise, from the waist to the seat of a chair [cm].
    """

    name: str
    bust: float | None = None
    waist: float | None = None
    hip: float | None = None
    height: float | None = None
    neck: float | None = field(default=None, metadata=LEFT_OUT)
    shoulder: float | None = field(default=None, metadata=LEFT_OUT)
    upper_arm: float | None = field(default=None, metadata=LEFT_OUT)
    wrist: float | None = field(default=None, metadata=LEFT_OUT)
    armhole_depth: float | None = field(default=None, metadata=LEFT_OUT)
    arm_length: float | None = field(default=None, metadata=LEFT_OUT)
    back_length: float | None = field(default=None, metadata=LEFT_OUT)
    rise: float | None = field(default=None, metadata=LEFT_OUT)

    @staticmethod
    def more_names() -> tuple[str, ...]:
        """Return the names of the measures of which the differences between sizes count."""
        return ("neck", "shoulder", "upper_arm", "wrist", "armhole_depth", "arm_length", "back_length", "rise")


def check_size_lines(lines: tuple[SizeLine, ...], is_sure: bool) -> None:
    """Check the lines of a table.

    Args:
        lines: The lines.
        is_sure: Whether what can hardly be meant was confirmed.

    Raises:
        SizesBad: where a line is not valid.
        SizesUnclear: where the table can hardly be meant as it is.
    """
    if len(lines) > MAX_SIZE_COUNT or len({line.name for line in lines}) < len(lines):
        raise SizesBad(f"a table holds at most {MAX_SIZE_COUNT} sizes, each of another name.")
    if any(len(line.name) > MAX_TABLE_NAME_LENGTH for line in lines):
        raise SizesBad(f"a size's name has at most {MAX_TABLE_NAME_LENGTH} letters; name sizes as S, M, L or 38, 40.")
    for line in lines:
        values = [getattr(line, one.name) for one in fields(line) if one.name != "name"]
        if any(value is not None and not (math.isfinite(value) and value > 0.0) for value in values):
            raise SizesBad(f"size {_name(line)} has a measure that is no length.")
    for name in SizeLine.more_names():
        count = sum(getattr(line, name) is not None for line in lines)
        if 0 < count < len(lines) or (count and any(line.bust is None for line in lines)):
            raise SizesBad(f"{name} says how sizes differ: give it, and bust, for each size, or leave the column out.")
    if not is_sure:
        _check_units(lines)
        _check_order(lines)
    for line in lines:
        own = [getattr(line, name) for name in (*GIRTHS, "height")]
        if not all(value is None or MIN_MEASURE_CM <= value <= MAX_MEASURE_CM for value in own):
            raise SizesBad("girths and heights of a table are centimetres from 20 to 300.")


def _check_units(lines: tuple[SizeLine, ...]) -> None:
    """Check that girths and heights are those of people in centimetres.

    Raises:
        SizesUnclear: where they are not; the message has the readings that are possible.
    """
    odd = [line for line in lines if not _is_usual(line, 1.0)]
    if not odd:
        return
    readings = [f"{unit} ({_describe(odd[0], factor)} cm)" for unit, factor in TABLE_UNITS.items()
                if unit != "cm" and all(_is_usual(line, factor) for line in lines)]  # fmt: skip
    read = f"; read as {' or '.join(readings)} they are" if readings else ""
    raise SizesUnclear(
        f"size {_name(odd[0])} has {_describe(odd[0], 1.0)} cm, which are measures of no wearer{read}. Say the unit "
        f"with --unit or in the table's head (bust [inch]); over HTTP give centimetres. If it is meant so, confirm "
        f"with --sure (is_sure)."
    )


def _check_order(lines: tuple[SizeLine, ...]) -> None:
    """Check that girths grow together, in steps of sizes, and make a figure.

    Raises:
        SizesUnclear: where they do not.
    """
    for line in lines:
        if line.waist is not None and line.hip is not None and line.waist > MAX_WAIST_HIP_RATIO * line.hip:
            raise SizesUnclear(_ask(f"size {_name(line)} has a waist of {line.waist:g} cm and hips of {line.hip:g} cm"))
    known = [name for name in GIRTHS if all(getattr(line, name) is not None for line in lines)]
    if not known:
        return
    ordered = sorted(lines, key=lambda line: tuple(float(getattr(line, name)) for name in known))
    for first, second in pairwise(ordered):
        for name in known:
            step = float(getattr(second, name)) - float(getattr(first, name))
            if step < 0.0 or step > MAX_SIZE_STEP_CM:
                pair = f"{getattr(first, name):g} and {getattr(second, name):g} cm"
                what = "shrinks while others grow" if step < 0.0 else "jumps"
                raise SizesUnclear(_ask(f"from size {_name(first)} to {_name(second)} {name} {what}: {pair}"))


def _ask(what: str) -> str:
    return f"{what}. Correct the table; if it is meant so, confirm with --sure (is_sure)."


def _is_usual(line: SizeLine, factor: float) -> bool:
    """Check whether a line's measures times a factor are those of a wearer in centimetres."""
    girths = [getattr(line, name) for name in GIRTHS]
    return all(value is None or GIRTH_RANGE_CM[0] <= factor * value <= GIRTH_RANGE_CM[1] for value in girths) and (
        line.height is None or HEIGHT_RANGE_CM[0] <= factor * line.height <= HEIGHT_RANGE_CM[1]
    )


def _describe(line: SizeLine, factor: float) -> str:
    values = {name: getattr(line, name) for name in (*GIRTHS, "height")}
    return " ".join(f"{name} {factor * value:.4g}" for name, value in values.items() if value is not None)


def _name(line: SizeLine) -> str:
    return f"'{keep_printable(line.name)}'"
