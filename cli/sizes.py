"""`garmentq sizes`."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from ..core.body.measures_file import read_table_text
from ..core.deliver.formats.registry import CHARTS, TABLE_UNITS
from .export import ProductionOptions, production_options, read_options, write_production
from .options import gather
from .size_table import read_sizes


@dataclass(frozen=True)
class SizeOptions:
    """Describe which sizes are made; each field is the option of its name."""

    step: float
    span: str
    table: str | None
    chart: str | None
    chosen: tuple[str, ...]
    unit: str | None
    sure: bool
    drape: bool

    def as_request(self) -> dict[str, Any]:
        """Return them as an export's request has them.

        Raises:
            UsageError: if the range or the table cannot be read.
        """
        found = re.fullmatch(r"\s*([+-]?\d{1,3})\s*\.\.\s*([+-]?\d{1,3})\s*", self.span)
        if not found:
            raise click.UsageError("--range is FIRST..LAST, as in -2..4.")
        options: dict[str, Any] = {"step": self.step, "first": int(found[1]), "last": int(found[2])}
        if self.table is not None:
            options["sizes"] = read_sizes(read_table_text(Path(self.table)), self.unit or "", self.sure)
        chosen = {"chart": self.chart, "chosen": list(self.chosen), "is_sure": self.sure, "drape": self.drape}
        options |= {name: value for name, value in chosen.items() if value}
        return options if self.unit in (None, "cm") else options | {"unit": self.unit}


SIZE_OPTIONS = [
    click.option(
        "--step", type=float, default=4.0, show_default=True, help="Step between sizes, in bust, waist and hip [cm]."
    ),
    click.option(
        "--range", "span", default="-2..2", show_default=True, help="Steps below and above the wearer's size."
    ),
    click.option(
        "--drape", is_flag=True, help="Also drape each size on a body of its measures; 10 to 30 s of CPU a size."
    ),
    click.option(
        "--table",
        type=click.Path(exists=True, dir_okay=False),
        help="A table of sizes instead, CSV, JSON or YAML: name, bust, waist, hip, height, neck and more.",
    ),
    click.option("--chart", type=click.Choice(tuple(CHARTS)), help="A published chart of sizes instead."),
    click.option("--size", "chosen", multiple=True, help="Only this size of the table or chart; several times."),
    click.option(
        "--unit",
        "--units",
        "unit",
        type=click.Choice(tuple(TABLE_UNITS)),
        help="Unit of a table that names none, and of the grade table.  [default: detected, and cm]",
    ),
    click.option("--sure", is_flag=True, help="Take a table as it is that looks wrong."),
]
"""Options of `SizeOptions`."""


@click.command("sizes")
@click.argument("job")
@gather(SizeOptions, SIZE_OPTIONS, "sizes")
@production_options
@click.pass_context
def command(context: click.Context, job: str, sizes: SizeOptions, production: ProductionOptions) -> None:
    """Grade a result's pattern to other sizes.

    Writes a pattern for each size, a nest of all sizes as PDF and DXF, the base size with its grade rules, and a grade
    table in words. Named points (neck, shoulder, underarm, sleeve, waist, hip, crotch, hem) move by rules of the trade;
    the rest follows the base pattern's draft, or is spread between them where the pattern has none. With --drape also
    each size on a body of the wearer's figure with its girths, in A pose, with verdicts in sizes.json.

    \b
    Example:
      garmentq sizes 3685ecfd4f81 --step 4 --range -2..4 --out sizes
      garmentq sizes 3685ecfd4f81 --range -1..1 --drape --out tried_on
      garmentq sizes 3685ecfd4f81 --table sizes.csv --unit inch --dialect gerber
      garmentq sizes 3685ecfd4f81 --chart de-women --size 36 --size 38 --size 40
    """
    options = {"format": "sizes", **read_options(production), **sizes.as_request()}
    context.exit(write_production(job, options, production))
