"""`garmentq restore`."""

from __future__ import annotations

from pathlib import Path

import click

from .options import home_option, json_option


@click.command("restore")
@click.argument("file", type=click.Path(dir_okay=False, path_type=Path))
@click.option("--overwrite", is_flag=True, help="Replace the home's present jobs.")
@home_option
@json_option
def command(file: Path, overwrite: bool, home: Path | None, as_json: bool) -> None:
    """Restore a backup into a home.

    Every file is checked against its hash. Refused if the home has jobs, and while its worker runs. The next worker
    requeues jobs that ran when the backup was made.

    \b
    Example:
      garmentq restore monday.tar --home new
    """
    from ..service.backup import BackupRefused, restore_backup
    from ..service.damage import describe_damaged_rows
    from ..service.settings import read_settings
    from ..workers.embedded import is_worker_up
    from .terminal import print_json, print_note

    settings = read_settings(home=home)
    if is_worker_up(settings):
        raise BackupRefused("the home's worker runs; stop it with `garmentq down` first.")
    saved = restore_backup(settings, file, overwrite)
    if as_json:
        lost = {"missing": len(saved.missing), "rows": len(saved.rows)}
        print_json({"home": str(saved.path), "files": saved.files, "bytes": saved.size, **lost})
        return
    print_note(f"restored the database and {saved.files} files of {saved.size / 1e6:.1f} MB into {saved.path}")
    if saved.rows:
        print_note(describe_damaged_rows(saved.rows))
