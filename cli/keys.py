"""`garmentq keys`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from .options import home_option, json_option


@click.group("keys")
def command() -> None:
    """Make, list and revoke API keys.

    \b
    Example:
      garmentq keys create atelier --scope read --scope submit
    """


@command.command("create")
@click.argument("name")
@click.option(
    "--scope", "scopes", multiple=True, default=("read", "submit"), show_default=True,
    type=click.Choice(["read", "submit", "admin"]), help="What it allows; may be given repeatedly.",
)  # fmt: skip
@click.option("--quota", type=click.IntRange(1, 1_000_000), default=100, show_default=True, help="Open jobs at a time.")
@home_option
@json_option
def create_command(name: str, scopes: tuple[str, ...], quota: int, home: Path | None, as_json: bool) -> None:
    """Make a key and print its token, which is shown only now.

    \b
    Example:
      garmentq keys create atelier --quota 500
    """
    from ..service.anywhere import create_key
    from .terminal import note, print_json

    row, token = create_key(_open(home), name, scopes, quota)
    if as_json:
        print_json(_show(row) | {"token": token})
        return
    note(f"key {row.id} for {name}: {', '.join(row.scopes)}, {quota} open jobs at most; its token is not shown again")
    click.echo(token)


@command.command("list")
@home_option
@json_option
def list_command(home: Path | None, as_json: bool) -> None:
    """List the keys, without their tokens.

    \b
    Example:
      garmentq keys list
    """
    from ..service.anywhere import list_keys
    from .terminal import print_json, print_table, show_time

    rows = list_keys(_open(home))
    if as_json:
        for row in rows:
            print_json(_show(row))
        return
    print_table(
        ["key", "name", "scopes", "quota", "created", "revoked"],
        [[r.id, r.name, ", ".join(r.scopes), r.quota, show_time(r.created), show_time(r.revoked)] for r in rows],
    )


@command.command("revoke")
@click.argument("key")
@home_option
@json_option
def revoke_command(key: str, home: Path | None, as_json: bool) -> None:
    """Take a key back; its jobs stay.

    \b
    Example:
      garmentq keys revoke 5f1d0c9b7a3e
    """
    from ..service.anywhere import revoke_key
    from .terminal import note, print_json

    row = revoke_key(_open(home), key)
    if as_json:
        print_json(_show(row))
    else:
        note(f"key {row.id} is revoked")


def _open(home: Path | None) -> Any:
    from ..service.anywhere import open_database
    from ..service.settings import read_settings

    return open_database(read_settings(home=home))


def _show(row: Any) -> dict[str, Any]:
    shown = {"scopes": row.scopes, "quota": row.quota, "created": row.created, "revoked": row.revoked}
    return {"key": row.id, "name": row.name, **shown}
