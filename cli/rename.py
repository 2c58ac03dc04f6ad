"""`garmentq rename`."""

from __future__ import annotations

from pathlib import Path

import click

from .options import json_option, known_home_option


@click.command("rename")
@click.argument("job")
@click.argument("name", required=False)
@click.option("--tag", "tags", multiple=True, help="Tag in place of all that it has; repeatable.")
@known_home_option
@json_option
def command(job: str, name: str | None, tags: tuple[str, ...], home: Path | None, as_json: bool) -> None:
    """Give a job's family another name or tags.

    \b
    Example:
      garmentq rename 3685ecfd4f81 "Anna, second fitting" --tag spring
    """
    from ..service.backend import open_backend
    from ..service.settings import read_settings
    from .terminal import print_json

    found = open_backend(read_settings(home=home)).rename(job, name, list(tags) or None)
    if as_json:
        print_json({"job": found.id, "name": found.name, "tags": found.tags})
    else:
        click.echo(f"{found.id}  {found.name}  {', '.join(found.tags)}".rstrip())
