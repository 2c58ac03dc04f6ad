"""`garmentq db`."""

from __future__ import annotations

from pathlib import Path

import click

from .options import home_option, json_option


@click.group("db")
def command() -> None:
    """Upgrade the database's tables.

    \b
    Example:
      garmentq db upgrade
    """


@command.command("upgrade")
@home_option
@json_option
def upgrade(home: Path | None, as_json: bool) -> None:
    """Create or upgrade the tables, create the store's folder or bucket, and make the home private.

    Only this and a restore do so, except that a home's SQLite file gets its tables from whichever command comes first.
    An older version cannot use upgraded tables. A deployment runs this once before its workers start; two at the same
    time wait for each other.

    \b
    Example:
      garmentq db upgrade
    """
    from ..service.database import open_database, read_revision
    from ..service.home import restrict_permissions
    from ..service.settings import hide_password, read_settings
    from ..service.stores import open_store
    from .terminal import print_json, print_note

    settings = read_settings(home=home)
    database = open_database(settings, is_upgraded=True)
    with database.read() as session:
        revision = read_revision(session.connection())
    database.dispose()
    open_store(settings).prepare()
    restrict_permissions(settings)
    address = hide_password(settings.database)
    if as_json:
        print_json({"database": address, "revision": revision})
    else:
        print_note(f"{address} is at revision {revision}")
