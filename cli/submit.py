"""`garmentq submit`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..core.recover.settings import LATER
from ..service.checking import DOUBTS
from ..service.states import QUEUES
from . import exits
from .options import OrderOptions, WaitOptions, home_option, json_option, order_options, wait_options

if TYPE_CHECKING:
    from ..core.run.errors import GarmentqError
    from ..service.backend import Backend
    from ..service.order import Order
    from ..service.submission import SubmissionResult

MAX_FILES_AT_ONCE = 4
"""Largest number of files that are read at a time: each may take as much memory as its limited process has."""


@click.command("submit")
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
@order_options
@click.option("--priority", type=click.IntRange(-100, 100), default=0, show_default=True, help="Larger goes first.")
@click.option("--queue", type=click.Choice(QUEUES), default=QUEUES[0], show_default=True, help="Kind of worker.")
@click.option(
    "--check/--no-check", "is_checked", default=True, show_default=True,
    help="Read the files now; otherwise each job does first.",
)  # fmt: skip
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
    is_checked: bool,
    wait: bool,
    waiting: WaitOptions,
    home: Path | None,
    as_json: bool,
) -> None:
    """Queue one or more scans.

    A folder stands for the scans in it; a table (.csv) has a row for each scan, with the columns scan, body, labels,
    name, tags and others named as the options, and paths relative to the table's folder.

    Reads each file, and prints a line for it: the job's id, the file's name and what it is; or `-`, the name and why it
    is refused. The others are queued, and the exit status is 4. The same scan with the same settings is the same job.
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
    from ..service.backend import open_backend
    from ..service.settings import read_settings
    from .batch import find_scans
    from .order import split_garments

    options = replace(options, redrape=options.redrape or LATER)
    backend = open_backend(read_settings(home=home))
    statuses, jobs = [], []
    pairs = [(file, one) for file, orders in find_scans(files, options) for one in split_garments(orders)]
    for outcome in _submit_all(backend, pairs, _Terms(priority, queue, is_checked)):
        _show(outcome, as_json)
        if outcome.error is not None:
            statuses.append(exits.error_status(outcome.error))
        if outcome.submitted is not None:
            jobs.append(outcome.submitted.job)
    if wait and jobs:
        statuses.append(_wait(backend, list(dict.fromkeys(jobs)), waiting))
    context.exit(exits.worst(statuses))


@dataclass(frozen=True)
class _Terms:
    """Describe how all files are submitted: priority, queue, and whether they are read before."""

    priority: int
    queue: str
    is_checked: bool


@dataclass(frozen=True)
class _Outcome:
    """Describe what became of one file: the job and what it is, or why not."""

    file: Path
    submitted: SubmissionResult | None = None
    choice: str = ""
    overrides: str = ""
    error: GarmentqError | None = None


def _submit_all(backend: Backend, pairs: Sequence[tuple[Path, OrderOptions]], terms: _Terms) -> Iterator[_Outcome]:
    """Submit files, several at a time, and yield what became of each.

    Names and headers of all files are looked at before any is read, which takes 2 s for each: a file that is none is
    yielded first, behind however many good ones it stands; the others follow in their order.
    """
    from ..core.run.errors import GarmentqError
    from ..service.headers import check_headers
    from .order import describe_choice, describe_overrides, make_order

    orders: list[tuple[Path, Order, str, str]] = []
    for file, chosen in pairs:
        try:
            order = make_order(backend, file, chosen)
        except GarmentqError as error:
            yield _Outcome(file, error=error)
            continue
        order = replace(order, terms=replace(order.terms, priority=terms.priority, queue=terms.queue))
        orders.append((file, order, describe_choice(order), describe_overrides(chosen)))
    scans = list(dict.fromkeys(order.scan for _, order, *_ in orders))
    refused = check_headers(scans) if terms.is_checked and scans else {}
    yield from (_Outcome(file, error=refused[order.scan]) for file, order, *_ in orders if order.scan in refused)

    def submit(file: Path, order: Order, choice: str, overrides: str) -> _Outcome:
        try:
            return _Outcome(file, backend.submit(order, terms.is_checked), choice, overrides)
        except GarmentqError as error:
            return _Outcome(file, error=error)

    left = [one for one in orders if one[1].scan not in refused]
    with ThreadPoolExecutor(min(len(left), MAX_FILES_AT_ONCE) or 1) as pool:
        waiting = [pool.submit(submit, *one) for one in left]
        try:
            for one in waiting:
                yield one.result()
        except KeyboardInterrupt:
            pool.shutdown(cancel_futures=True)
            raise


def _show(outcome: _Outcome, as_json: bool) -> None:
    """Print one line for a file: its job, its name, and what it is or why it is refused.

    What is wrong with the options or the service is no property of the file, and goes where all errors go.
    """
    from ..core.run.errors import keep_printable
    from .terminal import print_error, print_json, print_note

    submitted, error = outcome.submitted, outcome.error
    understood = submitted.understood if submitted is not None else None
    if as_json:
        problem = None if error is None else {"code": error.code, "message": error.message}
        shown: dict[str, object] = {"file": str(outcome.file), "job": None, "error": problem}
        if submitted is not None:
            shown |= {"job": submitted.job, "state": submitted.state, "is_new": submitted.is_new}
            shown |= {"taken_as": outcome.choice + outcome.overrides, "understood": understood}
        print_json(shown)
        return
    if error is not None and exits.error_status(error) != exits.BAD_INPUT:
        print_error(error.code, error.message)
        return
    job = "-" if submitted is None else submitted.job
    what = f"{error.code}: {error.message}" if error is not None else describe_understood(understood) or outcome.choice
    what += outcome.overrides
    click.echo(keep_printable(f"{job:12}  {outcome.file.name}  {what}"))
    for doubt in (understood or {}).get(DOUBTS, ()):
        print_note(f"{outcome.file.name}: {doubt}")


def describe_understood(understood: Mapping[str, Any] | None) -> str:
    """Return what the check of a scan found, as text for users: `person, 30477 points, in cm`; empty if it is unknown.

    Args:
        understood: As the check returned it, or None.
    """
    scan = (understood or {}).get("scan") or {}
    words = [
        str((understood or {}).get("as") or ""),
        f"{scan['vertex_count']} points" if "vertex_count" in scan else "",
    ]
    words.append(f"in {scan['units']}" if scan.get("units") else "")
    return ", ".join(word for word in words if word)


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
