"""`garmentq audit`."""

from __future__ import annotations

from pathlib import Path

import click

from .options import json_option, known_home_option


@click.command("audit")
@click.option("--limit", type=click.IntRange(1, 100000), default=50, show_default=True, help="Largest number of rows.")
@click.option("--key", help="Only requests of this key, by its id.")
@known_home_option
@json_option
def command(limit: int, key: str | None, home: Path | None, as_json: bool) -> None:
    """Show changes, downloads and deletions over HTTP.

    \b
    Example:
      garmentq audit
      garmentq audit --key 5f1d0c9b7a3e --limit 1000 --json
    """
    from dataclasses import asdict

    from ..service.audit import list_accesses
    from ..service.database import open_database
    from ..service.settings import read_settings
    from .terminal import print_json, print_table, show_time

    database = open_database(read_settings(home=home))
    found = list_accesses(database, limit, key)
    database.dispose()
    if as_json:
        for one in found:
            print_json(asdict(one))
        return
    rows = [[show_time(one.at), one.key, one.action, one.subject, one.address, one.request] for one in found]
    print_table(["at", "key", "", "what", "from", "request"], rows)
