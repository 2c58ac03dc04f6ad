"""`garmentq dress`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from ..core.body.spec import is_builtin
from ..core.run.units import UNITS
from .derived import DerivedOptions, derived_options
from .options import AXES, Decorator, gather


@dataclass(frozen=True)
class WearerOptions:
    """Describe the options about the new wearer of a garment; each field is the option of its name."""

    body: str | None
    measures: Path | None
    pose: str | None
    fabric: str | None
    units: str | None
    up: str | None


def wearer_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options about the new wearer of a garment; the command receives them as one `wearer: WearerOptions`."""
    options = [
        click.option("--body", help="The new wearer: a mesh file, or builtin:male,height=1.85.  [default: the wearer]"),
        click.option(
            "--measures", type=click.Path(path_type=Path), help="Measures of the new wearer: CSV, JSON or YAML."
        ),
        click.option("--pose", help="Pose of the body: T, A, arms-down, stride, seated.  [default: its own]"),
        click.option("--fabric", help="A name from `garmentq materials`.  [default: the result's own]"),
        click.option(
            "--units",
            type=click.Choice(tuple(UNITS)),
            help="Unit of the body's file, or of measures without one.  [default: detected]",
        ),
        click.option("--up", type=click.Choice(AXES[:2]), help="Up axis of the body's file.  [default: detected]"),
    ]
    command: Decorator = gather(WearerOptions, options, "wearer")(function)
    return command


def split_wearer(wearer: WearerOptions) -> tuple[dict[str, Any], dict[str, Path]]:
    """Return the options and files of a derived job's request that describe the new wearer.

    Raises:
        UsageError: if both a body and measures are given.
        MeasuresBad: if the measures cannot be read.
        MeasuresUnclear: if they can be read in two ways.
    """
    body, own_units = wearer.body, wearer.units
    if wearer.measures is not None:
        if body is not None:
            raise click.UsageError("give --body or --measures, not both.")
        from ..core.body.measures_file import read_measures
        from .terminal import print_note

        read = read_measures(wearer.measures, wearer.units or "")
        body, own_units = read.spec, None
        if read.left:
            print_note(f"not used of the measures: {', '.join(read.left)}.")
    built_in = body if is_builtin(body) else None
    fields = {"body": built_in, **{name: getattr(wearer, name) for name in ("pose", "fabric", "up")}}
    fields["units"] = own_units
    files = {} if body is None or built_in else {"body": Path(body)}
    return {name: value for name, value in fields.items() if value is not None}, files


@click.command("dress")
@click.argument("job")
@wearer_options
@click.option("--over", default="", metavar="JOB", help="Wear it over this job's garment; both drape together.")
@click.option(
    "--order", metavar="PART,PART", help="For a person's job: the garments from the innermost out.  [default: detected]"
)
@derived_options
@click.pass_context
def command(
    context: click.Context, job: str, wearer: WearerOptions, over: str, order: str | None, options: DerivedOptions
) -> None:
    """Dress another body in a stored result, or in all garments of a person.

    The pattern does not change, and is draped on the other body in its own fabric or another one. Prints the id of the
    job; with --wait the result: whether the garment is at rest, outside the body, and wide enough. With --over it is
    worn over another result's garment, a shirt over trousers: both are draped together with contact between them.

    If JOB is a person's, the body is dressed in all garments that were recovered, each over the one before, the top
    over the bottom unless it is tucked in; --order lower,upper overrides the detected order.

    \b
    Example:
      garmentq dress 3685ecfd4f81 --body builtin:male,height=1.85,weight=85 --pose A --wait
      garmentq dress 3685ecfd4f81 --body body.ply --fabric denim --out dressed
      garmentq dress 3685ecfd4f81 --measures anna.csv --pose stride --wait --json
      garmentq dress 3685ecfd4f81 --over 9be1f0aa2c47 --wait
      garmentq dress 7f2d08c1b5aa --body builtin:male,height=1.85 --pose A --out outfit
    """
    from ..service.derived import DerivedOrder
    from .derived import run_derived

    fields, files = split_wearer(wearer)
    fields |= {} if order is None else {"order": order}
    context.exit(run_derived(DerivedOrder("dress", job, fields, files, over=over), options))
