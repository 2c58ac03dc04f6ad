"""`garmentq backup`."""

from __future__ import annotations

from pathlib import Path

import click

from . import exits
from .options import json_option, known_home_option
from .output import writing


@click.command("backup")
@click.argument("file", type=click.Path(dir_okay=False, path_type=Path))
@click.option("--overwrite", is_flag=True, help="Replace the file if it exists.")
@click.option("--without-files", is_flag=True, help="Only name the stored files: a bucket has tools of its own.")
@known_home_option
@json_option
@click.pass_context
def command(
    context: click.Context, file: Path, overwrite: bool, without_files: bool, home: Path | None, as_json: bool
) -> None:
    """Save the database and its files into one tar file.

    Jobs may continue meanwhile: the file holds the state at its start. Stored files that are missing or damaged are
    left out and counted; rows of the database that cannot be read are kept unchanged and named. The exit status is 11
    then. Files --without-files must be copied afterwards, without a `garmentq gc` in between.

    \b
    Example:
      garmentq backup monday.tar
      garmentq backup --without-files monday.tar
    """
    from ..service.backup import make_backup
    from ..service.damage import describe_damaged_rows
    from ..service.settings import read_settings
    from .terminal import print_json, print_note

    with writing(file, is_private=True):
        saved = make_backup(read_settings(home=home), file.absolute(), overwrite, not without_files)
    status = exits.INCOMPLETE if saved.damaged or saved.missing or saved.rows else exits.OK
    if as_json:
        lost = {"missing": len(saved.missing), "damaged": len(saved.damaged), "rows": len(saved.rows)}
        print_json({"file": str(saved.path), "files": saved.files, "bytes": saved.size, **lost})
        context.exit(status)
    print_note(f"saved the database and {saved.files} files of {saved.size / 1e6:.1f} MB in {saved.path}")
    if saved.missing or saved.damaged:
        left = f"{len(saved.missing)} files that the database names are missing, {len(saved.damaged)} are damaged"
        print_note(f"{left}; the backup does not have them; `garmentq verify --read-data` names their jobs")
    if saved.rows:
        print_note(f"kept unchanged: {describe_damaged_rows(saved.rows)}")
    context.exit(status)
