"""`garmentq submit`."""

from __future__ import annotations

from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..core.recover.settings import LATER
from ..service.states import QUEUES, State
from . import exits
from .options import OrderOptions, WaitOptions, home_option, json_option, order_options, wait_options

if TYPE_CHECKING:
    from ..service.backend import Backend
    from ..service.records import Job


@click.command("submit")
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
@order_options
@click.option("--priority", type=click.IntRange(-100, 100), default=0, show_default=True, help="Larger goes first.")
@click.option("--queue", type=click.Choice(QUEUES), default=QUEUES[0], show_default=True, help="Kind of worker.")
@click.option("--wait", is_flag=True, help="Wait until every job has ended.")
@wait_options
@home_option
@json_option
@click.pass_context
def command(
    context: click.Context,
    files: tuple[Path, ...],
    options: OrderOptions,
    priority: int,
    queue: str,
    wait: bool,
    waiting: WaitOptions,
    home: Path | None,
    as_json: bool,
) -> None:
    """Queue one or more scans.

    A folder stands for the scans in it; a table (.csv) has a row for each scan, with the columns scan, body, labels,
    name, tags and others named as the options, and paths relative to the table's folder.

    Prints the id of each job; the same scan with the same settings is the same job. The worker checks the files first;
    a file that is refused within 3 s is named on standard error, the others continue, and the exit status is 4.
    `garmentq up` starts a worker.

    A raw scan of a dressed person needs no further options: its job makes one more for each worn garment. Each --keep
    is a garment, and a job, of its own. A result is ready before its re-drape, which is a job below it; until that has
    ended its verdict is `doubtful` at best (--redrape).

    \b
    Example:
      garmentq submit scan.ply
      garmentq submit scans/*.ply --body body.ply
      garmentq submit scans/
      garmentq submit batch.csv
      garmentq submit person.ply --keep upper --keep lower
    """
    from ..core.run.errors import GarmentqError
    from ..service.backend import open_backend
    from ..service.settings import read_settings
    from .batch import find_scans
    from .order import describe_choice, describe_overrides, make_order, split_garments
    from .terminal import print_error, print_json, print_note

    options = replace(options, redrape=options.redrape or LATER)
    backend = open_backend(read_settings(home=home))
    statuses, made = [], []
    pairs = [(file, one) for file, orders in find_scans(files, options) for one in split_garments(orders)]
    for file, chosen in pairs:
        try:
            order = make_order(backend, file, chosen)
            choice = describe_choice(order) + describe_overrides(chosen)
            submitted = backend.submit(replace(order, terms=replace(order.terms, priority=priority, queue=queue)))
        except GarmentqError as error:
            print_error(error.code, name_file(str(file), error.message))
            if as_json:
                print_json({"file": str(file), "job": None, "error": {"code": error.code, "message": error.message}})
            statuses.append(exits.error_status(error))
            continue
        made.append((file, submitted, choice))
        if not as_json:
            click.echo(submitted.job)
            print_note(f"{file.name}: {choice}")
    jobs = list(dict.fromkeys(submitted.job for _, submitted, _ in made))
    refused: dict[str, Job] = {}
    if jobs and not wait:
        refused, ended = _find_refused(backend, jobs, queue)
        statuses.append(ended)
    for file, submitted, choice in made if as_json else ():
        job = refused.get(submitted.job)
        state, failure = (job.state, job.error) if job else (submitted.state, None)
        shown = {"job": submitted.job, "state": state, "is_new": submitted.is_new}
        print_json({"file": str(file), **shown, "taken_as": choice, "error": asdict(failure) if failure else None})
    if wait:
        statuses.append(_wait(backend, jobs, waiting))
    context.exit(exits.worst(statuses))


def name_file(file: str, message: str) -> str:
    """Return a refusal that names its file, so that it can be found among many."""
    return message if Path(file).name in message else f"{file}: {message}"


def _find_refused(backend: Backend, jobs: list[str], queue: str) -> tuple[dict[str, Job], int]:
    """Return the jobs whose files are refused within a few seconds, and the exit status; the jobs stay queued."""
    from ..core.run.errors import GarmentqError
    from .checked import wait_checked
    from .terminal import print_error, print_note

    try:
        found = wait_checked(backend, jobs, queue)
    except GarmentqError as error:
        print_error(error.code, error.message)
        return {}, exits.error_status(error)
    except KeyboardInterrupt:
        print_note("the jobs continue; `garmentq status` shows their progress.")
        return {}, exits.DETACHED
    refused = {job.id: job for job in found if job.state is State.FAILED and job.bad_input}
    for job in refused.values():
        if job.error:
            print_error(job.error.code, name_file(job.name, job.error.message))
    return refused, exits.BAD_INPUT if refused else exits.OK


def _wait(backend: Backend, jobs: list[str], waiting: WaitOptions) -> int:
    """Follow the whole batch in one view, and return the worst exit status."""
    from ..service.health import find_troubles
    from .follow import WaitTimedOut
    from .live import follow_batch
    from .terminal import print_error, print_note

    for trouble in find_troubles(backend.read_queue()):
        print_note(trouble)
    try:
        rows = follow_batch(backend, jobs, waiting.timeout)
    except WaitTimedOut:
        for job in jobs:
            print_note(f"job {job} continues; `garmentq logs -f {job}` follows it.")
        return exits.TIMED_OUT
    except KeyboardInterrupt:
        print_note("the jobs continue; `garmentq status` shows their progress.")
        return exits.DETACHED
    for row in rows:
        print_note(f"job {row.id} {row.state}")
        if row.error:
            print_error(row.error.code, row.error.message)
    return exits.worst(exits.job_status(row, waiting.lenient) for row in rows)
