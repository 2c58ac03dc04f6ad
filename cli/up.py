"""`garmentq up`."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from .options import allow_host_option, home_option, json_option, workers_option
from .signals import ignore_stop_signals

if TYPE_CHECKING:
    from ..service.settings import ServiceSettings


@click.command("up")
@workers_option
@click.option("--serve", "is_serving", is_flag=True, help="Also serve the HTTP API, and restart what dies.")
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

    They stop after a while without work. With --serve they keep running, and are restarted if they die, until this
    command is stopped (Ctrl-C, SIGTERM, SIGHUP); then they stop too.

    \b
    Example:
      garmentq up --workers 2
      garmentq up --serve --port 8080
    """
    from ..service.settings import read_settings

    settings = read_settings(home=home)
    if is_serving:
        _serve(replace(settings, idle_seconds=0.0), workers, (host, port), allow_host, as_json)
    else:
        _start(settings, workers, as_json)


def _start(settings: ServiceSettings, workers: int | None, as_json: bool) -> None:
    """Start what does not run, and print what was started."""
    from ..service.database import open_database
    from ..workers.embedded import ensure_services
    from .terminal import print_json, print_note

    open_database(settings).dispose()
    started = ensure_services(settings, workers)
    if as_json:
        print_json({"started": started, "home": str(settings.home)})
    else:
        print_note(f"started the {' and the '.join(started)}" if started else "everything is running already")


def _serve(
    settings: ServiceSettings, workers: int | None, address: tuple[str, int], hosts: tuple[str, ...], as_json: bool
) -> None:
    """Start everything, restart what dies, and stop all of it on a stop signal, at whatever point of the start."""
    from ..service.api.server import check_keys, serve
    from ..service.logs import set_up_logs
    from ..workers.embedded import keep_services_up, stop_services
    from .serve import announce

    set_up_logs(bool(settings.log_json))
    check_keys(settings, address[0], hosts)
    kept = ExitStack()
    try:
        _start(settings, workers, as_json)
        kept.enter_context(keep_services_up(settings, workers))
        announce(settings, *address, is_alone=not hosts)
        serve(settings, *address, hosts=hosts)
    except KeyboardInterrupt:
        pass  # stopped before the API was ready
    finally:
        with ignore_stop_signals():
            kept.close()
            stop_services(settings)
