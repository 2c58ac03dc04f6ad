"""`garmentq completion`."""

from __future__ import annotations

import click

SHELLS = ("bash", "zsh", "fish")
"""Shells for which click writes completion."""


@click.command("completion")
@click.argument("shell", type=click.Choice(SHELLS))
def command(shell: str) -> None:
    """Print the completion script of a shell.

    \b
    Example:
      garmentq completion bash > ~/.local/share/bash-completion/completions/garmentq
      garmentq completion zsh > ~/.zfunc/_garmentq
      garmentq completion fish > ~/.config/fish/completions/garmentq.fish
    """
    from click.shell_completion import get_completion_class

    from .main import group

    found = get_completion_class(shell)
    assert found is not None
    click.echo(found(group, {}, "garmentq", "_GARMENTQ_COMPLETE").source())
