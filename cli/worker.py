"""`garmentq worker`: a worker in the foreground, for production."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

import click

from . import exits
from .options import home_option


@click.command("worker")
@click.option("--workers", type=click.IntRange(1, 256), help="Jobs at a time.  [default: cores]")
@click.option("--embedded", is_flag=True, help="Run as the home's embedded worker, which stops when idle.")
@click.option("--queues", default="cpu,gpu", show_default=True, help="Queues to serve.")
@click.option("--check", "is_check", is_flag=True, help="Only check that one works in this home; status 9: none does.")
@home_option
@click.pass_context
def command(
    context: click.Context, workers: int | None, embedded: bool, queues: str, is_check: bool, home: Path | None
) -> None:
    """Run a worker until stopped.

    SIGTERM, SIGHUP or Ctrl-C returns its jobs to the queue, where they continue from their last checkpoint. Any number
    of workers on any number of hosts may share a database, a broker and a store. --check is for health checks; an
    unavailable database is not a fault of the worker, which waits for it.

    \b
    Example:
      garmentq worker --workers 4
    """
    from ..service.settings import read_settings
    from ..workers.alive import Kept, check_heartbeat

    if is_check:
        check_heartbeat(read_settings(home=home), Kept.WORKER)
        return
    from ..service.database import open_database
    from ..service.logs import set_up_logs
    from ..service.reaper import is_idle
    from ..service.states import QUEUES
    from ..workers.broker import start_broker, stop_broker
    from ..workers.embedded import hold_worker_lock
    from ..workers.threads import count_cores
    from ..workers.worker import run_worker
    from .terminal import print_note

    settings = read_settings(home=home)
    set_up_logs(bool(settings.log_json))
    served = tuple(dict.fromkeys(queues.split(",")))
    if set(served) - set(QUEUES):
        raise click.BadParameter(f"'{queues}'; give a list of {', '.join(QUEUES)}.", param_hint="--queues")
    status, lock = exits.OK, None
    with suppress(KeyboardInterrupt):  # stopped before it worked
        start_broker(settings)
        lock = hold_worker_lock(settings) if embedded else None
        if embedded and lock is None:
            print_note("another embedded worker runs in this home")
            context.exit(exits.OK)
        if lock is not None:
            os.chdir(settings.home)  # a background process must not block the folder it was started in
        status = run_worker(settings, workers or count_cores(), lock, served)
    if lock is not None and settings.idle_seconds and is_idle(open_database(settings), settings.idle_seconds):
        stop_broker(settings)
    context.exit(status)
