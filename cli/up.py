"""`garmentq up`."""

from __future__ import annotations

from pathlib import Path

import click

from .options import home_option, json_option, workers_option


@click.command("up")
@workers_option
@home_option
@json_option
def command(workers: int | None, home: Path | None, as_json: bool) -> None:
    """Start the embedded broker and worker.

    \b
    Example:
      garmentq up --workers 2
    """
    from ..service.database import open_database
    from ..service.settings import read_settings
    from ..workers.embedded import ensure_services
    from .terminal import note, print_json

    settings = read_settings(home=home)
    open_database(settings).dispose()
    started = ensure_services(settings, workers)
    if as_json:
        print_json({"started": started, "home": str(settings.home)})
    else:
        note(f"started the {' and the '.join(started)}" if started else "everything runs already")
