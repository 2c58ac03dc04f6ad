"""`garmentq serve`."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import click

from .options import allow_host_option, home_option

if TYPE_CHECKING:
    from ..service.settings import ServiceSettings


@click.command("serve")
@click.option(
    "--host", default="127.0.0.1", show_default=True, envvar="GARMENTQ_API_HOST", help="Address to listen on."
)
@click.option(
    "--port", type=click.IntRange(1, 65535), default=8080, show_default=True, envvar="GARMENTQ_API_PORT", help="Port."
)
@allow_host_option
@click.option("--max-upload-mb", type=click.IntRange(1, 512), help="Largest upload [MiB].  [default: 512]")
@click.option(
    "--await-key", is_flag=True,
    help="Start on a public address before a key exists: every request is refused until one is created.",
)  # fmt: skip
@home_option
def command(
    host: str, port: int, allow_host: tuple[str, ...], max_upload_mb: int | None, await_key: bool, home: Path | None
) -> None:
    """Serve the HTTP API and its pages until stopped.

    The printed link signs your browser in. The description of every route is at /docs. Without keys only this machine
    may use it; a service that others reach, by --host or by a proxy with --allow-host, needs a key first (`garmentq
    keys create`). Workers run separately: `garmentq worker`, or `garmentq up`.

    \b
    Example:
      garmentq serve
      garmentq serve --host 0.0.0.0 --port 8080
      garmentq serve --allow-host garmentq.example
    """
    from dataclasses import replace

    from ..service.api.limits import read_limits
    from ..service.api.server import check_keys, serve
    from ..service.logs import set_up_logs
    from ..service.settings import read_settings

    settings, limits = read_settings(home=home), read_limits()
    set_up_logs(bool(settings.log_json))
    if max_upload_mb is not None:
        limits = replace(limits, upload_bytes=max_upload_mb << 20)
    with suppress(KeyboardInterrupt):
        if not await_key:
            check_keys(settings, host, allow_host)  # before anything is announced
        announce(settings, host, port, is_alone=not allow_host)
        serve(settings, host, port, limits, allow_host, needs_key=not await_key)


def announce(settings: ServiceSettings, host: str, port: int, is_alone: bool = True) -> None:
    """Print the API's address, its authentication, and missing workers; `is_alone`: without a proxy in front of it."""
    from ..service.api.guard import is_loopback
    from ..service.database import open_database
    from ..service.keys import LOCAL_CALLER, has_keys
    from ..service.reaper import list_workers
    from ..service.sessions import begin_session
    from ..service.settings import hide_password
    from .terminal import print_note

    database = open_database(settings)
    try:
        has_no_worker, is_keyless = (
            not list_workers(database),
            is_alone and is_loopback(host) and not has_keys(database),
        )
        # A log is read by more people than a terminal: it gets no link that signs in.
        is_linked = is_keyless and not settings.log_json
        link = f"?link={begin_session(database, LOCAL_CALLER, is_link=True)}" if is_linked else ""
    finally:
        database.dispose()
    of = hide_password(settings.database_url) or settings.home
    print_note(f"the API of {of} is at http://{host}:{port}, its description at /docs")
    print_note(f"its pages: http://{host}:{port}/signin{link}{' (once, within 10 minutes)' if link else ''}")
    if is_keyless:
        print_note(f"there are no keys: programs of this user send the token in {settings.home / 'api.token'}")
    if has_no_worker:
        embedded = "`garmentq up` starts one, `garmentq up --serve` keeps both running"
        start = "start `garmentq worker` on each host that computes" if settings.is_database_server else embedded
        print_note(f"no worker is up, so jobs will wait; {start}")
