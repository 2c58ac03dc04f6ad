"""`garmentq retry`."""

from __future__ import annotations

from pathlib import Path

import click

from ..service.states import State
from .options import json_option, known_home_option

ENDS = (State.FAILED.value, State.DEAD.value, State.CANCELLED.value)


@click.command("retry")
@click.argument("jobs", nargs=-1, metavar="[JOB...]")
@click.option("--state", type=click.Choice(ENDS), help="All jobs in this state, instead of single ones.")
@click.option("--error", metavar="CODE", help="With --state: only those with this error code.")
@known_home_option
@json_option
def command(jobs: tuple[str, ...], state: str | None, error: str | None, home: Path | None, as_json: bool) -> None:
    """Queue ended jobs again.

    Each has all its attempts again, and continues from its last checkpoint. Of a family only unsuccessful jobs are run
    again.

    \b
    Example:
      garmentq retry 3685ecfd4f81
      garmentq retry --state dead
      garmentq retry --state failed --error job.crashed
    """
    from ..service.backend import open_backend
    from ..service.query import MAX_QUERY_ROWS, JobQuery
    from ..service.settings import read_settings
    from .family import change_families
    from .terminal import print_note

    if bool(jobs) == (state is not None) or (error is not None and state is None):
        raise click.UsageError("Give jobs, or --state, and --error with it.")
    backend = open_backend(read_settings(home=home))
    if state is not None:
        conditions = {"state": state} | ({} if error is None else {"error": error})
        found = backend.find_jobs(
            JobQuery({}, [f"{name} = '{value}'" for name, value in conditions.items()], limit=MAX_QUERY_ROWS)
        )
        jobs = tuple(job.id for job in found)
        print_note(f"{len(jobs)} jobs match")
    change_families(backend, jobs, backend.retry, {}, as_json)
