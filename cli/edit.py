"""`garmentq edit`."""

from __future__ import annotations

from pathlib import Path

import click

from .derived import DerivedOptions, derived_options


@click.command("edit")
@click.argument("job")
@click.option(
    "--pattern", type=click.Path(path_type=Path), required=True, help="The edited pattern: a result's pattern.json."
)
@derived_options
@click.pass_context
def command(context: click.Context, job: str, pattern: Path, options: DerivedOptions) -> None:
    """Drape an edited pattern of a stored result.

    The drape starts from the result's garment, on the same wearer and in the same fabric. A pattern that cannot be sewn
    or meshed is refused with panel, edge and seam. The result is a new version: it names its predecessor and never
    replaces it.

    \b
    Example:
      garmentq export 3685ecfd4f81 --out result
      garmentq edit 3685ecfd4f81 --pattern result/pattern.json --wait
      garmentq edit 3685ecfd4f81 --pattern wider.json --out wider --json
    """
    from ..service.derived import DerivedOrder
    from .derived import run_derived

    context.exit(run_derived(DerivedOrder("edit", job, files={"pattern": pattern}), options))
