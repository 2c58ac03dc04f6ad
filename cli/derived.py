"""Shared parts of the commands on stored results: options, submission, and waiting for the end."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..service.states import QUEUES, State
from . import exits
from .options import Decorator, gather, home_option, json_option, lenient_option, timeout_option, workers_option
from .output import NewFolder

if TYPE_CHECKING:
    from ..service.backend import Backend
    from ..service.derived import DerivedOrder
    from ..service.submission import SubmissionResult


@dataclass(frozen=True)
class EndOptions:
    """Describe the options about the end of a job that was queued; each field is the option of its name."""

    wait: bool
    timeout: float | None
    lenient: bool
    out: Path | None
    workers: int | None
    home: Path | None
    as_json: bool


@dataclass(frozen=True)
class DerivedOptions(EndOptions):
    """Describe the options of a derived job; each field is the option of its name."""

    name: str
    tags: tuple[str, ...]
    priority: int
    queue: str
    force: bool


def end_options() -> list[Decorator]:
    """Return the options about the end of a job that was queued."""
    return [
        click.option("--wait", is_flag=True, help="Start a worker here if none runs, wait, and show the result."),
        timeout_option,
        lenient_option,
        click.option("--out", type=NewFolder(), help="Folder for the result's files; waits."),
        workers_option,
        home_option,
        json_option,
    ]


def derived_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options of every derived job; the command takes them as one `options: DerivedOptions`."""
    options = [
        click.option("--name", default="", help="Name of the job.  [default: the result's]"),
        click.option("--tag", "tags", multiple=True, help="Tag by which it is found; may be repeated."),
        click.option("--priority", type=click.IntRange(-100, 100), default=0, show_default=True, help="Larger first."),
        click.option(
            "--queue", type=click.Choice(QUEUES), default=QUEUES[0], show_default=True, help="Kind of worker."
        ),
        click.option("--force", is_flag=True, help="Create a new job even if an equal one exists."),
        *end_options(),
    ]
    command: Decorator = gather(DerivedOptions, options)(function)
    return command


def run_derived(order: DerivedOrder, options: DerivedOptions) -> int:
    """Queue a derived job, and with `--wait` or `--out` wait for it and show its result.

    Args:
        order: The order; name, tags, priority, queue and force are set from the options.
        options: The options.

    Returns:
        The exit status.
    """
    from ..service.terms import JobTerms

    terms = JobTerms(options.name, options.tags, options.priority, options.queue, options.force)
    return queue_and_end(lambda backend: backend.submit_derived(replace(order, terms=terms)), options)


def queue_and_end(queue: Callable[[Backend], SubmissionResult], options: EndOptions) -> int:
    """Queue a job, and with `--wait` or `--out` wait for it and show its result.

    Args:
        queue: Queues the job in a backend.
        options: The options.

    Returns:
        The exit status.
    """
    from ..service.backend import open_backend
    from ..service.settings import read_settings
    from ..workers.embedded import ensure_services
    from .follow import Wait
    from .run import wait_and_show
    from .terminal import print_json, print_note

    settings = read_settings(home=options.home)
    backend = open_backend(settings)
    done = queue(backend)
    if not (options.wait or options.out):
        if options.as_json:
            print_json({"job": done.job, "state": done.state, "is_new": done.is_new})
        else:
            click.echo(done.job)
        return exits.OK

    def keep_up() -> None:
        for name in () if backend.is_remote else ensure_services(settings, options.workers):
            print_note(f"started the {name}")

    if done.state != State.SUCCEEDED:
        keep_up()
    print_note(f"job {done.job}" + ("" if done.is_new else f" (known, {done.state})"))
    folder = options.out or settings.home / "results" / done.job
    wait = Wait(options.timeout, options.as_json, keep_up, options.lenient)
    return wait_and_show(backend, done.job, folder.absolute(), wait, in_home=options.out is None)
