"""`garmentq status`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from .options import json_option, known_home_option

if TYPE_CHECKING:
    from ..service.records import Job


@click.command("status")
@click.argument("job", required=False)
@click.option("--limit", type=click.IntRange(1, 10000), default=20, show_default=True, help="Largest number of jobs.")
@click.option("--watch", is_flag=True, help="Show jobs and workers until Ctrl-C.")
@known_home_option
@json_option
def command(job: str | None, limit: int, watch: bool, home: Path | None, as_json: bool) -> None:
    """Show the jobs, or one of them.

    A job that another one made is shown below that one; a single job is shown with all below it. The overall progress
    and the remaining time are estimated from the stages of earlier jobs of the same kind and method.

    \b
    Example:
      garmentq status
      garmentq status --watch
      garmentq status 3685ecfd4f81 --json
    """
    from ..service.backend import open_backend
    from ..service.health import find_troubles
    from ..service.settings import read_settings
    from .family import arrange, find_family, indent
    from .terminal import print_error, print_json, print_note, print_table, show_left, show_time

    backend = open_backend(read_settings(home=home))
    if watch:
        from .live import watch_queue

        watch_queue(backend, job, limit)
        return
    found = find_family(backend, backend.find_job(job)) if job else backend.list_jobs(limit)
    if as_json:
        for one in found:
            print_json(one.as_json())
        return
    print_table(
        ["job", "name", "kind", "state", "verdict", "stage", "% of all", "to go", "attempts", "created", "ended"],
        [
            [one.id, indent(depth, one.name), one.kind, show_state(one), one.verdict, one.stage]
            + [round(100 * one.overall), show_left(one), one.attempts, show_time(one.created), show_time(one.finished)]
            for depth, one in arrange(found)
        ],
    )
    if not found:
        print_note("no jobs yet; `garmentq submit SCAN` creates one.")
    for one in found if job else ():
        if one.error:
            print_error(one.error.code, one.error.message)
    for trouble in find_troubles(backend.read_queue()):
        print_note(trouble)


def show_state(job: Job) -> str:
    """Return a job's state, and the outage for which it is paused, if any."""
    return job.state if job.delay is None else f"{job.state} ({job.delay.code})"
