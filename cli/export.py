"""`garmentq export`."""

from __future__ import annotations

from pathlib import Path

import click

from .options import json_option, known_home_option


@click.command("export")
@click.argument("job")
@click.argument("names", nargs=-1)
@click.option(
    "--out", "-o", type=click.Path(file_okay=False, path_type=Path), default=Path("."), help="Folder.  [default: here]"
)
@known_home_option
@json_option
def command(job: str, names: tuple[str, ...], out: Path, home: Path | None, as_json: bool) -> None:
    """Copy a job's files into a folder.

    All of them, or only those named; every copy is checked against its hash. Prints the paths.

    \b
    Example:
      garmentq export 3685ecfd4f81 pattern.svg detail.glb --out result
    """
    from ..service.backend import open_backend
    from ..service.settings import read_settings
    from .terminal import print_json

    backend = open_backend(read_settings(home=home))
    found = backend.find_job(job)
    for path in backend.export_files(found.id, out.absolute(), names):
        if as_json:
            print_json({"job": found.id, "name": path.name, "path": str(path)})
        else:
            click.echo(str(path))
