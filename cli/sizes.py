"""`garmentq sizes`."""

from __future__ import annotations

import csv
import io
import re
from typing import Any

import click

from ..core.run.text import read_json
from .export import ProductionOptions, production_options, read_options, read_table, write_production


@click.command("sizes")
@click.argument("job")
@click.option(
    "--step", type=float, default=4.0, show_default=True, help="Step between sizes, in bust, waist and hip [cm]."
)
@click.option("--range", "span", default="-2..2", show_default=True, help="Steps below and above the wearer's size.")
@click.option("--drape", is_flag=True, help="Also drape each size on a body of its measures; 10 to 30 s of CPU a size.")
@click.option(
    "--table",
    type=click.Path(exists=True, dir_okay=False),
    help="A table of sizes instead: name,bust,waist,hip,height in cm, CSV or JSON.",
)
@production_options
@click.pass_context
def command(
    context: click.Context,
    job: str,
    step: float,
    span: str,
    table: str | None,
    drape: bool,
    production: ProductionOptions,
) -> None:
    """Grade a result's pattern to other sizes.

    Writes a pattern for each size, a nest of all sizes as PDF and DXF, and the base size with its grade rules. Every
    control point moves by the change of the base pattern's draft; a pattern without a draft is scaled, with a warning.
    With --drape also each size on a body of the wearer's figure with its girths, in A pose, with verdicts in
    sizes.json.

    \b
    Example:
      garmentq sizes 3685ecfd4f81 --step 4 --range -2..4 --out sizes
      garmentq sizes 3685ecfd4f81 --range -1..1 --drape --out tried_on
      garmentq sizes 3685ecfd4f81 --table sizes.csv --dialect gerber
    """
    options: dict[str, Any] = {"format": "sizes", "step": step, **read_options(production)}
    found = re.fullmatch(r"\s*([+-]?\d{1,3})\s*\.\.\s*([+-]?\d{1,3})\s*", span)
    if not found:
        raise click.UsageError("--range is FIRST..LAST, as in -2..4.")
    options.update(first=int(found[1]), last=int(found[2]))
    if table is not None:
        options["sizes"] = read_sizes(read_table(table))
    if drape:
        options["drape"] = True
    context.exit(write_production(job, options, production))


def read_sizes(text: str) -> list[dict[str, Any]]:
    """Return the rows of a table of sizes; their values are checked with the request.

    Raises:
        UsageError: if it is neither a JSON list of objects nor CSV with a header.
    """
    try:
        if text.lstrip().startswith("["):
            found = read_json(text)
            if not all(isinstance(line, dict) for line in found):
                raise ValueError
            return list(found)
        rows = [
            {key.strip().lower(): value.strip() for key, value in line.items() if key and value and value.strip()}
            for line in csv.DictReader(io.StringIO(text))
        ]
        if not rows:
            raise ValueError
        return [{key: value if key == "name" else float(value) for key, value in line.items()} for line in rows]
    except (ValueError, TypeError, AttributeError, RecursionError, csv.Error) as error:
        raise click.UsageError(
            "a table of sizes needs the header name,bust,waist,hip,height and one line a size."
        ) from error
