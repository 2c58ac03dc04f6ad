"""`garmentq logs`."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING

import click

from . import exits
from .options import json_option, known_home_option

if TYPE_CHECKING:
    from ..service.records import Event


@click.command("logs")
@click.argument("job")
@click.option("--follow", "-f", "follows", is_flag=True, help="Follow until the job has ended.")
@known_home_option
@json_option
@click.pass_context
def command(context: click.Context, job: str, follows: bool, home: Path | None, as_json: bool) -> None:
    """Show the events of a job.

    And those of the jobs below it, whose lines begin with their name.

    \b
    Example:
      garmentq logs -f 3685ecfd4f81
    """
    from ..service.backend import open_backend
    from ..service.settings import read_settings
    from .family import FamilyEvents

    backend = open_backend(read_settings(home=home))
    family = FamilyEvents(backend, backend.find_job(job).id)
    try:
        while True:
            for event in family.poll():
                _print(event, family.names[event.job], as_json)
            if not follows or family.has_ended:
                return
            time.sleep(backend.poll_seconds)
    except KeyboardInterrupt:
        context.exit(exits.DETACHED)


def _print(event: Event, name: str, as_json: bool) -> None:
    from ..core.run.errors import keep_printable
    from .terminal import format_cell, print_json, show_time

    if as_json:
        print_json({"id": event.id, "job": event.job, "at": event.at, "kind": event.kind, **event.data})
        return
    progress = event.progress
    if progress is not None:
        text = f"{progress.stage} {100 * progress.fraction:.0f}% {progress.message}"
    else:
        text = " ".join(f"{name}={value}" for name, value in event.data.items())
    text = f"{name}: {text}" if name else text
    click.echo(f"{show_time(event.at)}  {keep_printable(event.kind):16}  {format_cell(text)}")
