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

    It has all its attempts once more, and goes on from its last checkpoint. Of a family only what did not succeed is
    run again.

    \b
    Example:
      garmentq retry 3685ecfd4f81
    """
    from dataclasses import replace

    from ..service.backend import open_backend
    from ..service.settings import read_settings
    from .terminal import note, print_json

    backend = open_backend(read_settings(home=home))
    for job in jobs:
        key = backend.find_job(job).id
        state = backend.retry(key)
        found = backend.find_jobs_by_id([key], below=True)
        for one in [replace(found[0], state=state), *found[1:]]:
            if as_json:
                print_json({"job": one.id, "state": one.state})
            else:
                note(f"job {one.id} is {one.state}")
