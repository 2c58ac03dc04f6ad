"""`garmentq backup`."""

from __future__ import annotations

from pathlib import Path

import click

from .options import home_option, json_option


@click.command("backup")
@click.argument("file", type=click.Path(dir_okay=False, path_type=Path))
@click.option("--overwrite", is_flag=True, help="Replace the file if it exists.")
@home_option
@json_option
def command(file: Path, overwrite: bool, home: Path | None, as_json: bool) -> None:
    """Save the embedded database and its files into one tar file.

    Jobs may go on meanwhile: the file holds the state of the moment it was begun.

    \b
    Example:
      garmentq backup monday.tar
    """
    from ..service.backup import make_backup
    from ..service.settings import read_settings
    from .terminal import note, print_json

    saved = make_backup(read_settings(home=home), file.absolute(), overwrite)
    if as_json:
        print_json({"file": str(saved.path), "files": saved.files, "bytes": saved.size, "missing": len(saved.missing)})
        return
    note(f"saved the database and {saved.files} files of {saved.size / 1e6:.1f} MB in {saved.path}")
    if saved.missing:
        note(f"{len(saved.missing)} files that the database names are gone from the store")
