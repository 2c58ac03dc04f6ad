"""`garmentq serve`."""

from __future__ import annotations

from pathlib import Path

import click

from .options import home_option


@click.command("serve")
@click.option("--host", default="127.0.0.1", show_default=True, envvar="GARMENTQ_API_HOST", help="Where to listen.")
@click.option(
    "--port", type=click.IntRange(1, 65535), default=8080, show_default=True, envvar="GARMENTQ_API_PORT", help="Port."
)
@click.option("--max-upload-mb", type=click.IntRange(1, 512), help="Largest upload [MiB].  [default: 512]")
@home_option
def command(host: str, port: int, max_upload_mb: int | None, home: Path | None) -> None:
    """Serve the HTTP API until told to stop.

    The description of every route is at /docs. Without keys only this machine may ask; an address that others reach
    needs a key first (`garmentq keys create`). Workers run apart: `garmentq worker`, or `garmentq up`.

    \b
    Example:
      garmentq serve
      garmentq serve --host 0.0.0.0 --port 8080
    """
    from dataclasses import replace

    from ..service.api.limits import read_limits
    from ..service.api.server import serve
    from ..service.settings import read_settings
    from .terminal import note

    settings, limits = read_settings(home=home), read_limits()
    if max_upload_mb is not None:
        limits = replace(limits, upload_bytes=max_upload_mb << 20)
    note(f"the API of {settings.home} is at http://{host}:{port}, its description at /docs")
    serve(settings, host, port, limits)
