"""`garmentq man`."""

from __future__ import annotations

import click


@click.command("man")
def command() -> None:
    """Print the manual page of all commands.

    \b
    Example:
      garmentq man > ~/.local/share/man/man1/garmentq.1
    """
    from .main import group
    from .manual_page import format_manual_page

    click.echo(format_manual_page(group))
