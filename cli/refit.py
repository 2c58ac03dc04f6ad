"""`garmentq refit`."""

from __future__ import annotations

import click

from .derived import DerivedOptions, derived_options
from .dress import WearerOptions, split_wearer, wearer_options


@click.command("refit")
@click.argument("job")
@wearer_options
@derived_options
@click.pass_context
def command(context: click.Context, job: str, wearer: WearerOptions, options: DerivedOptions) -> None:
    """Fit a stored result to another body's measures.

    The control points move by the difference of the template's drafts for the wearer and for the other body, and
    further where girths without a draft would lose their ease. The seams are made equal, and the body is dressed in the
    pattern. A warning names where the ease is not kept within 5 mm, or that the pattern has no draft and was scaled by
    the measures' ratios.

    \b
    Example:
      garmentq refit 3685ecfd4f81 --measures anna.csv --wait
      garmentq refit 3685ecfd4f81 --body builtin:female,height=1.60,weight=80 --out refitted
    """
    from ..service.derived import DerivedOrder
    from .derived import run_derived

    fields, files = split_wearer(wearer)
    context.exit(run_derived(DerivedOrder("refit", job, fields, files), options))
