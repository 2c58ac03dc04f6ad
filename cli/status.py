"""`garmentq status`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..core.run.errors import keep_printable
from ..service.states import State
from .options import json_option, known_home_option

if TYPE_CHECKING:
    from ..service.batch_records import Batch
    from ..service.records import Job


STATES = [state.value for state in State]


@click.command("status")
@click.argument("job", required=False)
@click.option("--limit", type=click.IntRange(1, 10000), default=20, show_default=True, help="Largest number of jobs.")
@click.option("--state", type=click.Choice(STATES), help="Only the newest jobs in this state, with the reason.")
@click.option("--batch", "--tag", "tag", help="The progress of all jobs with this tag, and the newest of them.")
@click.option("--subject", help="Only the newest jobs of this person.")
@click.option("--watch", is_flag=True, help="Show jobs and workers until Ctrl-C.")
@known_home_option
@json_option
def command(
    job: str | None,
    limit: int,
    state: str | None,
    tag: str | None,
    subject: str | None,
    watch: bool,
    home: Path | None,
    as_json: bool,
) -> None:
    """Show the jobs, or one of them.

    A job that another one made is shown below that one; a single job is shown with all below it. The overall progress
    and the remaining time are estimated from the stages of earlier jobs of the same kind and method.

    \b
    Example:
      garmentq status
      garmentq status --watch
      garmentq status --state failed --batch 2026-11
      garmentq status 3685ecfd4f81 --json
    """
    from ..service.backend import open_backend
    from ..service.health import find_troubles
    from ..service.query import JobQuery
    from ..service.settings import read_settings
    from .family import arrange, find_family, indent
    from .terminal import print_error, print_json, print_note, print_table, show_left, show_time

    backend = open_backend(read_settings(home=home))
    chosen = {name: value for name, value in (("state", state), ("tag", tag), ("subject", subject)) if value}
    if chosen and (job or watch):
        raise click.UsageError("--state, --batch and --subject choose among all jobs; leave out JOB and --watch.")
    if watch:
        from .live import watch_queue

        watch_queue(backend, job, limit)
        return
    if chosen:
        found: Sequence[Job] = backend.find_jobs(JobQuery(chosen, limit=limit))
    else:
        found = find_family(backend, backend.find_job(job)) if job else backend.list_jobs(limit)
    if as_json:
        for one in found:
            print_json(one.as_json())
        return
    if chosen:
        if tag and found:
            click.echo(keep_printable(describe_batch(backend.find_batch(tag))))
        rows = [[one.id, one.name, one.kind, show_state(one), show_time(one.finished), explain(one)] for one in found]
        print_table(["job", "name", "kind", "state", "ended", "why"], rows)
        if not found:
            print_note(f"no job has {' and '.join(f'{name} {value}' for name, value in chosen.items())}.")
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


def describe_batch(batch: Batch) -> str:
    """Return the progress of a batch in one line."""
    from .terminal import show_duration

    states, open_jobs = batch.states, batch.open_jobs
    running, failed = states.get(State.RUNNING, 0), states.get(State.FAILED, 0) + states.get(State.DEAD, 0)
    counts = {
        "done": states.get(State.SUCCEEDED, 0), "failed": failed, "cancelled": states.get(State.CANCELLED, 0),
        "running": running, "queued": open_jobs - running,
    }  # fmt: skip
    parts = [f"{batch.jobs} jobs of {batch.scans} scans: {_count(counts)}", f"{100.0 * batch.share:.0f} %"]
    if open_jobs:
        left = "time to go unknown" if batch.left_seconds is None else f"{show_duration(batch.left_seconds)} to go"
        parts.append(left)
    parts += [text for text in (_count(batch.verdicts), _count(batch.garments)) if text]
    return f"{batch.tag}: {'; '.join(parts)}; {batch.cpu_seconds / 3600.0:.2g} h of CPU"


def _count(numbers: Mapping[str, int]) -> str:
    return ", ".join(f"{number} {name}" for name, number in numbers.items() if number)


def explain(job: Job) -> str:
    """Return why a job ended without a result: its error's code and message; empty where there is none."""
    return f"{job.error.code}: {job.error.message}" if job.error else ""


def show_state(job: Job) -> str:
    """Return a job's state, with the outage for which it is paused, or its place in the queue."""
    if job.delay is not None:
        return f"{job.state} ({job.delay.code})"
    place = getattr(job, "place", None)
    return job.state if place is None else f"{job.state}, place {place}"
