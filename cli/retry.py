"""`garmentq retry`."""

from __future__ import annotations

from pathlib import Path

import click

from .options import home_option, json_option


@click.command("retry")
@click.argument("jobs", nargs=-1, required=True, metavar="JOB...")
@home_option
@json_option
def command(jobs: tuple[str, ...], home: Path | None, as_json: bool) -> None:
    """Queue an ended job again.

    It has all its attempts once more, and goes on from its last checkpoint.

    \b
    Example:
      garmentq retry 3685ecfd4f81
    """
    from ..service.anywhere import find_job, open_database, retry
    from ..service.settings import read_settings
    from ..service.states import State
    from .terminal import note, print_json

    database = open_database(read_settings(home=home))
    for job in jobs:
        key = find_job(database, job).id
        retry(database, key)
        if as_json:
            print_json({"job": key, "state": State.QUEUED})
        else:
            note(f"job {key} is queued")
