"""Read tables of sizes by the reader of measures: the same words, units, languages and questions."""

from __future__ import annotations

from typing import Any

import click

from ..core.body.measure_table import MeasuresBad, read_measure_table
from ..core.run.errors import keep_printable

SIZE_FIELDS = {
    "bust": "bust", "waist": "waist", "hip": "hip", "height": "height", "neck": "neck", "upper_arm": "upper_arm",
    "wrist": "wrist", "shoulder": "shoulder", "armscye_depth": "armhole_depth", "arm_length": "arm_length",
    "back_waist_length": "back_length", "rise": "rise",
}  # fmt: skip
"""The measures of tables that a size has, and its fields."""


def read_sizes(text: str, unit: str = "", is_sure: bool = False) -> list[dict[str, Any]]:
    """Return the rows of a table of sizes in centimetres; their values are checked with the request.

    Args:
        text: A table as for `read_measure_table`.
        unit: Unit of lengths without one, of `TABLE_UNITS`, or an empty text: found by their sizes.
        is_sure: Whether lengths without any unit are centimetres, whatever their sizes.

    Raises:
        UsageError: if it is no table, a size has no name, or a column is none of a size's.
        MeasuresUnclear: if it can be read in two ways.
    """
    try:
        table = read_measure_table(text, unit or ("cm" if is_sure else ""), are_persons=False)
    except MeasuresBad as error:
        raise click.UsageError(f"the table of sizes cannot be read: {error.message}") from error
    others = [name for row in table.rows for name in row.measures if name not in SIZE_FIELDS]
    genders = [f"gender: {row.gender}" for row in table.rows if row.gender]
    for left in (*table.left, *others, *genders):
        raise click.UsageError(f"no size has '{keep_printable(left)}'; a table of sizes has {', '.join(SIZE_FIELDS)}.")
    if not all(row.name for row in table.rows):
        raise click.UsageError("a table of sizes has the header name,bust,waist,hip,height and one line a size.")
    return [
        {"name": row.name} | {SIZE_FIELDS[name]: round(100.0 * value, 4) for name, value in row.measures.items()}
        for row in table.rows
    ]
