"""`garmentq keys`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from .options import home_option, json_option

if TYPE_CHECKING:
    from ..service.backend import Backend


@click.group("keys")
def command() -> None:
    """Create, list, rotate and revoke API keys.

    \b
    Example:
      garmentq keys create atelier --scope read --scope submit
    """


@command.command("create")
@click.argument("name")
@click.option(
    "--scope", "scopes", multiple=True, default=("read", "submit"), show_default=True,
    type=click.Choice(["read", "submit", "metrics", "admin"]), help="Permission of the key; may be repeated.",
)  # fmt: skip
@click.option("--quota", type=click.IntRange(1, 1_000_000), default=100, show_default=True, help="Open jobs at a time.")
@click.option(
    "--priority", type=click.IntRange(0, 100), default=0, show_default=True, help="Highest priority of its jobs."
)
@click.option("--days", type=click.FloatRange(0.001, 36500), help="Days until it expires.  [default: never]")
@home_option
@json_option
def create_command(
    name: str,
    scopes: tuple[str, ...],
    quota: int,
    priority: int,
    days: float | None,
    home: Path | None,
    as_json: bool,
) -> None:
    """Create a key and print its token, which is shown only now.

    \b
    Example:
      garmentq keys create atelier --quota 500
      garmentq keys create guest --days 14
    """
    from .terminal import print_json, print_note

    key, token = _open(home).create_key(name, scopes, quota, priority, days)
    if as_json:
        print_json(key.as_json() | {"token": token})
        return
    print_note(
        f"key {key.id} for {name}: {', '.join(key.scopes)}, {quota} open jobs at most; its token is not shown again"
    )
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
    from .terminal import print_json, print_table, show_time

    found = _open(home).list_keys()
    if as_json:
        for key in found:
            print_json(key.as_json())
        return
    print_table(
        ["key", "name", "scopes", "quota", "priority", "created", "used", "expires", "revoked"],
        [
            [k.id, k.name, ", ".join(k.scopes), k.quota, k.priority]
            + [show_time(at) for at in (k.created, k.used, k.expires, k.revoked)]
            for k in found
        ],
    )


@command.command("rotate")
@click.argument("key")
@click.option(
    "--hours",
    type=click.FloatRange(0, 168),
    default=24.0,
    show_default=True,
    help="Time for which the token before stays.",
)
@home_option
@json_option
def rotate_command(key: str, hours: float, home: Path | None, as_json: bool) -> None:
    """Give a key a new token, and print it; the one before stays valid for some hours.

    \b
    Example:
      garmentq keys rotate 5f1d0c9b7a3e --hours 1
    """
    from .terminal import print_json, print_note, show_time

    rotated, token = _open(home).rotate_key(key, hours)
    if as_json:
        print_json(rotated.as_json() | {"token": token})
        return
    print_note(
        f"key {rotated.id} has a new token, which is not shown again; "
        f"the one before ends {show_time(rotated.earlier_until)}"
    )
    click.echo(token)


@command.command("revoke")
@click.argument("key")
@home_option
@json_option
def revoke_command(key: str, home: Path | None, as_json: bool) -> None:
    """Revoke a key; its jobs stay.

    \b
    Example:
      garmentq keys revoke 5f1d0c9b7a3e
    """
    from .terminal import print_json, print_note

    revoked = _open(home).revoke_key(key)
    if as_json:
        print_json(revoked.as_json())
    else:
        print_note(f"key {revoked.id} is revoked")


def _open(home: Path | None) -> Backend:
    from ..service.backend import open_backend
    from ..service.settings import read_settings

    return open_backend(read_settings(home=home))
