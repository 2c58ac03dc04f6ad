"""`garmentq delete`."""

from __future__ import annotations

import re
from pathlib import Path

import click

from .options import json_option, known_home_option

UNITS = {"h": 3600.0, "d": 86400.0, "w": 7 * 86400.0}


@click.command("delete")
@click.argument("jobs", nargs=-1, metavar="[JOB...]")
@click.option("--older-than", metavar="90d", help="All that ended longer ago than so many h, d or w.")
@click.option("--person", metavar="NAME", help="Scans and uploads of this name, and everything made of them.")
@click.option("--yes", is_flag=True, help="Do not ask.")
@known_home_option
@json_option
def command(
    jobs: tuple[str, ...], older_than: str | None, person: str | None, yes: bool, home: Path | None, as_json: bool
) -> None:
    """Delete ended jobs with their files.

    All below a job goes with it, and so does every job that reads its result. Files that nobody else names are removed
    at once. A person's data is found by the name of a job, a scan or an upload, and then by the files themselves,
    whatever they were called elsewhere; backups are not touched.

    \b
    Example:
      garmentq delete 3685ecfd4f81
      garmentq delete --older-than 90d
      garmentq delete --person anna
    """
    from dataclasses import asdict

    from ..service.deletion import delete_jobs, delete_person, find_old, find_person
    from ..service.jobs import find_job
    from ..service.services import open_services
    from ..service.settings import read_settings
    from .terminal import note, print_json

    if sum((bool(jobs), older_than is not None, person is not None)) != 1:
        raise click.UsageError("Give jobs, --older-than or --person.")
    services = open_services(read_settings(home=home))
    database, store = services.database, services.store
    try:
        scans: list[str] = []
        if person is not None:
            chosen, scans = find_person(database, person)
        elif older_than is not None:
            chosen = find_old(database, _seconds(older_than))
        else:
            chosen = [find_job(database, job).id for job in jobs]
        if not chosen and not scans:
            note("nothing to delete")
            return
        if not yes:
            more = f" and {len(scans)} files of '{person}'" if person else ""
            what = f"{len(chosen)} jobs, all made of them{more}"
            click.confirm(f"Delete {what}? This cannot be undone.", abort=True, err=True)
        done = delete_jobs(database, store, chosen) if person is None else delete_person(database, store, person)
    finally:
        database.dispose()
    if as_json:
        print_json(asdict(done))
        return
    later = f"; {done.young} files put a moment ago go with `garmentq gc` in a day" if done.young else ""
    size = f"{done.size / 1e6:.1f} MB"
    note(f"deleted {len(done.jobs)} jobs, {done.uploads} uploads, {done.files} files of {size}{later}")


def _seconds(text: str) -> float:
    found = re.fullmatch(r"(\d{1,6})([hdw])", text)
    if found is None:
        raise click.BadParameter(f"'{text}'; write 12h, 90d or 8w.", param_hint="--older-than")
    return int(found[1]) * UNITS[found[2]]
