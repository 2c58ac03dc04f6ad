"""`garmentq retry`."""

from __future__ import annotations

from pathlib import Path

import click

from .options import json_option, known_home_option


@click.command("retry")
@click.argument("jobs", nargs=-1, required=True, metavar="JOB...")
@known_home_option
@json_option
def command(jobs: tuple[str, ...], home: Path | None, as_json: bool) -> None:
    """Queue an ended job again.

    It has all its attempts once more, and goes on from its last checkpoint. Of a family only what did not succeed is
    run again.

    \b
    Example:
      garmentq retry 3685ecfd4f81
    """
    from ..service.backend import open_backend
    from ..service.settings import read_settings
    from .family import change_families

    backend = open_backend(read_settings(home=home))
    change_families(backend, jobs, backend.retry, {}, as_json)
