"""`garmentq archive`."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import click

from .delete import DeletionOptions, choose_jobs, deletion_options, find_erasure, show_deleted
from .options import json_option, known_home_option
from .output import writing


@click.command("archive")
@click.argument("file", type=click.Path(dir_okay=False, path_type=Path))
@click.argument("jobs", nargs=-1, metavar="[JOB...]")
@deletion_options
@click.option("--delete", "is_delete", is_flag=True, help="Delete the jobs once the archive was read back.")
@click.option("--overwrite", is_flag=True, help="Replace the file if it exists.")
@click.option("--yes", is_flag=True, help="Do not ask before jobs are deleted.")
@known_home_option
@json_option
def command(
    file: Path, jobs: tuple[str, ...], options: DeletionOptions, is_delete: bool, overwrite: bool, yes: bool,
    home: Path | None, as_json: bool,
) -> None:  # fmt: skip
    """Save ended jobs with their files into one tar file, and delete them if asked.

    Families are archived whole, with what they read and what was made of them, and no other job, key or log entry. The
    file is a backup: `garmentq restore FILE --home DIR` makes a home of it. Every file is read back and compared with
    its hash before anything is deleted.

    \b
    Example:
      garmentq archive 2026-11.tar --batch 2026-11
      garmentq archive old.tar --older-than 90d --delete
      garmentq restore 2026-11.tar --home november
    """
    from dataclasses import asdict

    from ..service.archiving import archive_jobs
    from ..service.deletion import delete_jobs
    from ..service.services import open_services
    from ..service.settings import read_settings
    from .confirm import confirm_deletion
    from .terminal import print_json, print_note

    settings = read_settings(home=home)
    services = open_services(settings)
    try:
        chosen = choose_jobs(services.database, jobs, options)
        if not chosen:
            print_note("nothing to archive")
            return
        with writing(file, is_private=True):
            kept = archive_jobs(services, settings, chosen, file.absolute(), overwrite)
        if not as_json:
            print_note(f"{len(kept)} jobs are in {file}")
        if is_delete and not yes:
            confirm_deletion()
        erase = find_erasure(services, options) or partial(delete_jobs, services.database, services.store, chosen)
        done = erase() if is_delete else None
    finally:
        services.database.dispose()
    if as_json:
        print_json({"file": str(file), "jobs": list(kept), "deleted": asdict(done) if done else None})
    elif done is not None:
        show_deleted(done)
