"""`garmentq refine`."""

from __future__ import annotations

import click

from .derived import EndOptions, end_options, queue_and_end
from .options import gather


@click.command("refine")
@click.argument("job")
@gather(EndOptions, end_options())
@click.pass_context
def command(context: click.Context, job: str, options: EndOptions) -> None:
    """Recover a preview's garment at standard quality.

    The job is a recovery of the same files with the same other settings, so that nothing is sent again; an equal one
    that exists is not repeated, and the preview stays. The garment of a person is recovered from the labels and the
    body that were found for the preview; everything else is computed anew. Of a person's job all garments are
    recovered, from its scan.

    \b
    Example:
      garmentq run scan.ply --quality preview
      garmentq refine 3685ecfd4f81 --wait
    """
    context.exit(queue_and_end(lambda backend: backend.refine(job), options))
