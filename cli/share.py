"""`garmentq share`."""

from __future__ import annotations

from pathlib import Path

import click

from ..service.share_records import DEFAULT_SHARE_DAYS, SHARE_DAYS
from .options import home_option, json_option


@click.command("share")
@click.argument("job")
@click.option(
    "--days", type=click.Choice([str(days) for days in SHARE_DAYS]), default=str(DEFAULT_SHARE_DAYS), show_default=True,
    help="How long the link is valid.",
)  # fmt: skip
@click.option("--list", "is_listed", is_flag=True, help="List the valid links instead.")
@click.option("--revoke", metavar="SHARE", help="Revoke a link, by its id, instead.")
@home_option
@json_option
def command(job: str, days: str, is_listed: bool, revoke: str | None, home: Path | None, as_json: bool) -> None:
    """Make a link that shows one result to whoever has it.

    It shows the garment, its pattern, its measures and its PDF, but neither the body nor other jobs, and needs no key.
    The path is below the address of `garmentq serve`; it is shown only now.

    \b
    Example:
      garmentq share 3685ecfd4f81 --days 30
      garmentq share 3685ecfd4f81 --list
      garmentq share 3685ecfd4f81 --revoke 5f1d0c9b7a3e
    """
    from ..service.backend import open_backend
    from ..service.settings import read_settings
    from .terminal import print_json, print_note, print_table, show_time

    backend = open_backend(read_settings(home=home))
    if revoke is not None:
        backend.revoke_share(job, revoke)
        print_note(f"link {revoke} is revoked")
    elif is_listed:
        found = backend.list_shares(job)
        if as_json:
            for one in found:
                print_json(one.as_json())
            return
        rows = [[one.id, show_time(one.created), show_time(one.expires), one.opened] for one in found]
        print_table(["share", "created", "expires", "opened"], rows)
    else:
        share, path = backend.create_share(job, int(days))
        if as_json:
            print_json(share.as_json() | {"path": path})
            return
        print_note(f"link {share.id}, valid until {show_time(share.expires)}")
        click.echo(path)
