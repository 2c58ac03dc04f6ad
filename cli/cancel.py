"""`garmentq cancel`."""

from __future__ import annotations

from pathlib import Path

import click

from ..service.states import State
from .options import json_option, known_home_option


@click.command("cancel")
@click.argument("jobs", nargs=-1, required=True, metavar="JOB...")
@known_home_option
@json_option
def command(jobs: tuple[str, ...], home: Path | None, as_json: bool) -> None:
    """Stop a job.

    A queued job ends at once, a running one within a second or two; an ended job does not change. All jobs below it
    stop too.

    \b
    Example:
      garmentq cancel 3685ecfd4f81
    """
    from ..service.backend import open_backend
    from ..service.settings import read_settings
    from .family import change_families

    backend = open_backend(read_settings(home=home))
    change_families(backend, jobs, backend.cancel, {State.RUNNING: "is stopping"}, as_json)
