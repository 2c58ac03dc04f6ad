"""`garmentq up`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import click

from .options import allow_host_option, home_option, json_option, workers_option


@click.command("up")
@workers_option
@click.option("--serve", "is_serving", is_flag=True, help="Serve the HTTP API too, and keep all of it alive.")
@click.option("--host", default="127.0.0.1", show_default=True, envvar="GARMENTQ_API_HOST", help="With --serve.")
@click.option(
    "--port", type=click.IntRange(1, 65535), default=8080, show_default=True, envvar="GARMENTQ_API_PORT",
    help="With --serve.",
)  # fmt: skip
@allow_host_option
@home_option
@json_option
def command(
    workers: int | None, is_serving: bool, host: str, port: int, allow_host: tuple[str, ...], home: Path | None,
    as_json: bool,
) -> None:  # fmt: skip
    """Start the embedded broker and worker.

    They stop after a while without work. With --serve they stay, and start again where they die, until this command is
    told to stop; then they stop with it.

    \b
    Example:
      garmentq up --workers 2
      garmentq up --serve --port 8080
    """
    from ..service.database import open_database
    from ..service.settings import read_settings
    from ..workers.embedded import ensure_services
    from .terminal import note, print_json

    settings = read_settings(home=home)
    if is_serving:
        settings = replace(settings, idle_seconds=0.0)
    open_database(settings).dispose()
    started = ensure_services(settings, workers)
    if as_json:
        print_json({"started": started, "home": str(settings.home)})
    else:
        note(f"started the {' and the '.join(started)}" if started else "everything runs already")
    if is_serving:
        from ..service.api.server import serve
        from ..workers.embedded import keeping_up, stop_services
        from .serve import announce

        try:
            with keeping_up(settings, workers):
                announce(settings, host, port, is_alone=not allow_host)
                serve(settings, host, port, hosts=allow_host)
        finally:
            stop_services(settings)
