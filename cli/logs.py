"""`garmentq logs`."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import click

from . import exits
from .options import home_option, json_option


@click.command("logs")
@click.argument("job")
@click.option("--follow", "-f", "follows", is_flag=True, help="Go on until the job has ended.")
@home_option
@json_option
@click.pass_context
def command(context: click.Context, job: str, follows: bool, home: Path | None, as_json: bool) -> None:
    """Show what happened to a job.

    \b
    Example:
      garmentq logs -f 3685ecfd4f81
    """
    from ..service.anywhere import ENDED, find_job, is_remote, look, open_database
    from ..service.settings import read_settings
    from .follow import PERIOD_SECONDS, REMOTE_SECONDS

    database = open_database(read_settings(home=home))
    found = find_job(database, job)
    seen = 0
    try:
        while True:
            state, events = look(database, found.id, seen)
            for event in events:
                seen = event.id
                _print(event, as_json)
            if not follows or state in ENDED:
                return
            time.sleep(REMOTE_SECONDS if is_remote() else PERIOD_SECONDS)
    except KeyboardInterrupt:
        context.exit(exits.DETACHED)


def _print(event: Any, as_json: bool) -> None:
    from .terminal import plain, print_json, show, show_time

    if as_json:
        print_json({"id": event.id, "job": event.job, "at": event.at, "kind": event.kind, **event.data})
        return
    data = dict(event.data)
    if event.kind == "progress":
        text = f"{data['stage']} {100 * data['fraction']:.0f}% {data['message']}"
    else:
        text = " ".join(f"{name}={value}" for name, value in data.items())
    click.echo(f"{show_time(event.at)}  {plain(event.kind):16}  {show(text)}")
