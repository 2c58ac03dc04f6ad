"""Write the grade table of a garment: by how much each figure grows from size to size, and by which rule."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from pathlib import Path
from textwrap import wrap

import numpy as np

from ...garment.pattern import Pattern
from ...garment.seams import seam_lengths
from ...garment.sizes.arm_points import ArmHalf, arm_coordinates, find_arm_halves, is_cap_low
from ...garment.sizes.closing import find_eased_seams, measure_ease
from .grading import Size
from .papers import PAPERS, Paper
from .pdf_file import Page, pdf_bytes, show_text
from .registry import TABLE_UNITS
from .size_lines import GIRTHS

SIZES_PER_PAGE_COUNT = 7
"""Number of sizes beside each other on a page of the table."""

TABLE_MARGIN_MM = 15.0
"""Width of the border of a page of the table [mm]."""

TABLE_LINE_MM = 5.5
"""Distance of two lines of the table [mm]."""

TABLE_TEXT_MM = 3.0
"""Size of the letters of the table [mm]."""

RULE_COLUMN_MM, SIZE_COLUMN_MM = 42.0, 82.0
"""Distances from the table's left edge to its rules, and to its sizes, on paper 18 cm wide between the borders [mm]."""

DECIMALS = {"cm": 2, "mm": 1, "inch": 2}
"""Number of decimals in the printed table by unit: tenths of a millimetre, hundredths of an inch."""

RULE_LETTER_COUNT = 34
"""Largest number of letters of a line of a rule; a longer rule has two lines."""

TABLE_NAME = "grade_table"
"""Name of the table's files, without their endings."""

CAP_RULE = "so that the cap fits"
"""Rule of what follows from an armhole and a bicep: the cap's height is the one at which its ease stays."""


@dataclass(frozen=True)
class TableRow:
    """Describe a row: a figure, its rule in words, and its growth over the base size for each size [m]."""

    figure: str
    rule: str
    growth: tuple[float, ...]


def make_grade_table(sizes: list[Size]) -> tuple[TableRow, ...]:
    """Return the rows of a grade table: measures of the wearers, figures with rules, and what follows from these.

    Args:
        sizes: All sizes; one of them is the base.
    """
    base = next(size for size in sizes if size.is_base)
    rows = [TableRow(f"body: {name}", "", tuple(getattr(size.growth, name) for size in sizes)) for name in GIRTHS]
    is_tall = any(size.growth.stature != 1.0 for size in sizes)
    for k, figure in enumerate(base.figures):
        values = [size.figures[k].value(size.pattern) - figure.value(base.pattern) for size in sizes]
        rows.append(TableRow(figure.name, figure.rule.describe(is_tall), tuple(values)))
    halves = find_arm_halves(base.pattern)
    own = _measure_sleeves(base.pattern, halves)
    others = [_measure_sleeves(size.pattern, halves) for size in sizes]
    for name in own:
        rule = "none" if name == "cap ease" else "follows" if name == "armhole seam" else CAP_RULE
        rows.append(TableRow(name, rule, tuple(other[name] - own[name] for other in others)))
    return tuple(rows)


def write_grade_table(sizes: list[Size], title: str, unit: str, paper: Paper, folder: Path) -> list[Path]:
    """Write `grade_table.pdf` and `grade_table.csv`, and return the files.

    Args:
        sizes: All sizes.
        title: The pattern's name, in ASCII.
        unit: One of `TABLE_UNITS`.
        paper: Of the pages; a roll gets pages of A4.
        folder: Where to write.
    """
    rows = make_grade_table(sizes)
    pages = [
        _draw_page(rows, sizes[first : first + SIZES_PER_PAGE_COUNT], first, title, unit, paper)
        for first in range(0, len(sizes), SIZES_PER_PAGE_COUNT)
    ]
    pdf, table = folder / f"{TABLE_NAME}.pdf", folder / f"{TABLE_NAME}.csv"
    pdf.write_bytes(pdf_bytes(pages, f"{title} grade table"))
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["figure", "rule", *(f"{size.name} [{unit}]" for size in sizes)])
    for row in rows:
        writer.writerow([row.figure, row.rule, *(_show(value, unit, 3) for value in row.growth)])
    table.write_text(text.getvalue(), encoding="utf-8")
    return [pdf, table]


def _measure_sleeves(pattern: Pattern, halves: tuple[ArmHalf, ...]) -> dict[str, float]:
    """Return what follows from the rules of a sleeve and its armhole, means of both arms [m]; empty without sleeves.

    Args:
        pattern: A size.
        halves: The halves of the base size's sleeves.
    """
    if not halves:
        return {}
    arms = len({half.sign for half in halves})
    eased, lengths, ease = find_eased_seams(pattern), seam_lengths(pattern), measure_ease(pattern)
    found = []
    for half in halves:
        under, end = (pattern.panel(name) for name, _ in (half.under, half.ends[1]))
        high, wide = arm_coordinates(pattern, half, under, under.points[[half.under[1]]])
        long, _ = arm_coordinates(pattern, half, end, end.points[[half.ends[1][1]]])
        found.append((float(high[0]), float(wide[0]), float(long[0])))
    caps, widths, ends = np.array(found).T
    bicep = {"bicep": float(widths.sum()) / arms} if is_cap_low(halves) else {}
    return bicep | {
        "cap height": float(caps.mean()),
        "underarm seam": float((ends - caps).mean()),
        "armhole seam": float((lengths[eased].mean(axis=1) - 0.5 * ease).sum()) / arms,
        "cap ease": float(ease.sum()) / arms,
    }


def _draw_page(rows: tuple[TableRow, ...], sizes: list[Size], first: int, title: str, unit: str, paper: Paper) -> Page:
    """Return a page with some of the sizes, the first of them at an index of the rows."""
    width, height = (paper.width, paper.height) if not paper.is_roll else PAPERS["a4"]
    column = (width - 2.0 * TABLE_MARGIN_MM - SIZE_COLUMN_MM) / SIZES_PER_PAGE_COUNT
    y = height - TABLE_MARGIN_MM - TABLE_LINE_MM
    base = next((size.name for size in sizes if size.is_base), "the base size")
    parts = [
        "0 G 0 g\n",
        show_text(TABLE_MARGIN_MM, y, 1.6 * TABLE_TEXT_MM, f"{title}: grade table", True),
        show_text(
            TABLE_MARGIN_MM,
            y - TABLE_LINE_MM,
            TABLE_TEXT_MM,
            f"growth over {base} [{unit}]; rules: shares of the growth of body measures",
        ),
    ]
    y -= 2.6 * TABLE_LINE_MM
    for x, head in ((0.0, "figure"), (RULE_COLUMN_MM, "rule")):
        parts.append(show_text(TABLE_MARGIN_MM + x, y, TABLE_TEXT_MM, head, True))
    for k, size in enumerate(sizes):
        parts.append(show_text(TABLE_MARGIN_MM + SIZE_COLUMN_MM + k * column, y, TABLE_TEXT_MM, size.name, True))
    parts.append(f"0.2 w {TABLE_MARGIN_MM:.1f} {y - 1.5:.2f} m {width - TABLE_MARGIN_MM:.1f} {y - 1.5:.2f} l S\n")
    for row in rows:
        y -= TABLE_LINE_MM
        parts.append(show_text(TABLE_MARGIN_MM, y, TABLE_TEXT_MM, row.figure))
        lines = wrap(row.rule, RULE_LETTER_COUNT)
        for n, line in enumerate(lines):
            above = 0.22 * TABLE_LINE_MM * (len(lines) - 1 - 2 * n)
            parts.append(show_text(TABLE_MARGIN_MM + RULE_COLUMN_MM, y + above, 0.8 * TABLE_TEXT_MM, line))
        for k in range(len(sizes)):
            x = TABLE_MARGIN_MM + SIZE_COLUMN_MM + k * column
            parts.append(show_text(x, y, TABLE_TEXT_MM, _show(row.growth[first + k], unit, DECIMALS[unit])))
    return Page(width, height, "".join(parts))


def _show(length: float, unit: str, decimals: int) -> str:
    """Return a growth [m] in a unit, with its sign."""
    value = round(100.0 * length / TABLE_UNITS[unit], decimals) + 0.0
    return f"{value:+.{decimals}f}" if value else f"{0.0:.{decimals}f}"
