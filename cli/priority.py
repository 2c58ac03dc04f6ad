"""`garmentq priority`."""

from __future__ import annotations

from pathlib import Path

import click

from .options import json_option, known_home_option


@click.command("priority")
@click.argument("jobs", nargs=-1, metavar="JOB...")
@click.option("--to", "priority", type=click.IntRange(-100, 100), required=True, help="Larger goes first.")
@click.option("--batch", "tag", help="The families with this tag.")
@known_home_option
@json_option
def command(jobs: tuple[str, ...], priority: int, tag: str | None, home: Path | None, as_json: bool) -> None:
    """Change the priority of jobs.

    The whole family of each job has it then: of a person all garments, also those that are not found yet. It orders the
    jobs of a lane: edits, exports and previews go before batches in any case. A running job continues.

    \b
    Example:
      garmentq priority 3685ecfd4f81 --to 10
      garmentq priority --batch 2026-11 --to -5
    """
    from ..service.backend import open_backend
    from ..service.query import MAX_QUERY_ROWS, JobQuery
    from ..service.settings import read_settings
    from .terminal import print_json, print_note

    if not jobs and tag is None:
        raise click.UsageError("name a job, or give --batch.")
    backend = open_backend(read_settings(home=home))
    found = [backend.find_job(job).family for job in jobs]
    if tag is not None:
        found += [job.family for job in backend.find_jobs(JobQuery({"tag": tag}, limit=MAX_QUERY_ROWS))]
    for job in dict.fromkeys(found):
        reached = backend.change_priority(job, priority)
        if as_json:
            print_json({"job": job, "priority": reached})
        else:
            print_note(f"job {job} has the priority {reached}, with its family")
    if not found:
        print_note(f"no job has tag {tag}.")
