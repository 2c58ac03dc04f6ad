"""`garmentq down`."""

from __future__ import annotations

from pathlib import Path

import click

from .options import home_option, json_option


@click.command("down")
@home_option
@json_option
def command(home: Path | None, as_json: bool) -> None:
    """Stop the embedded worker and broker; the jobs stay.

    Running jobs return to the queue and continue at the next `garmentq up` or `garmentq run`.

    \b
    Example:
      garmentq down
    """
    from ..service.settings import read_settings
    from ..workers.embedded import stop_services
    from .terminal import print_json, print_note

    settings = read_settings(home=home)
    stopped = stop_services(settings)
    if as_json:
        print_json({"stopped": stopped, "home": str(settings.home)})
    else:
        print_note(f"stopped the {' and the '.join(stopped)}" if stopped else "nothing is running here")
