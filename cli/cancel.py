"""`garmentq cancel`."""

from __future__ import annotations

from pathlib import Path

import click

from .options import home_option, json_option


@click.command("cancel")
@click.argument("jobs", nargs=-1, required=True, metavar="JOB...")
@home_option
@json_option
def command(jobs: tuple[str, ...], home: Path | None, as_json: bool) -> None:
    """Stop a job.

    A queued job ends at once, a running one within a second or two; one that has ended stays as it is.
    All jobs below it stop with it.

    \b
    Example:
      garmentq cancel 3685ecfd4f81
    """
    from dataclasses import replace

    from ..service.backend import open_backend
    from ..service.settings import read_settings
    from ..service.states import State
    from .terminal import note, print_json

    backend = open_backend(read_settings(home=home))
    for job in jobs:
        key = backend.find_job(job).id
        state = backend.cancel(key)
        found = backend.find_jobs_by_id([key], below=True)
        for one in [replace(found[0], state=state), *found[1:]]:
            if as_json:
                print_json({"job": one.id, "state": one.state})
            elif one.state == State.RUNNING:
                note(f"job {one.id} stops")
            else:
                note(f"job {one.id} is {one.state}")
