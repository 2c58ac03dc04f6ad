"""`garmentq restore`."""

from __future__ import annotations

from pathlib import Path

import click

from . import exits
from .options import home_option, json_option


@click.command("restore")
@click.argument("file", type=click.Path(dir_okay=False, path_type=Path))
@click.option("--overwrite", is_flag=True, help="Replace the home's present jobs.")
@home_option
@json_option
@click.pass_context
def command(context: click.Context, file: Path, overwrite: bool, home: Path | None, as_json: bool) -> None:
    """Restore a backup into a home or a server's database.

    Every file is checked against its hash, or looked up if the backup only names it; the exit status is 11 if some are
    missing. Refused if there are jobs, and while a worker runs; stop the API, too. The next worker requeues jobs that
    ran when the backup was made. A backup of either kind of database can be restored into the other.

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
    status = exits.INCOMPLETE if saved.missing else exits.OK
    if as_json:
        lost = {"missing": len(saved.missing), "rows": len(saved.rows)}
        print_json({"home": str(saved.path), "files": saved.files, "bytes": saved.size, **lost})
        context.exit(status)
    print_note(f"restored the database and {saved.files} files of {saved.size / 1e6:.1f} MB into {saved.path}")
    if saved.missing:
        print_note(
            f"{len(saved.missing)} files that the database names are missing; `garmentq verify` names their jobs"
        )
    if saved.rows:
        print_note(describe_damaged_rows(saved.rows))
    context.exit(status)
