"""`garmentq delete`."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from .options import gather, json_option, known_home_option

if TYPE_CHECKING:
    from ..service.database import Database
    from ..service.deletion import Deleted
    from ..service.persons import Person, PersonDeleted, PersonJob
    from ..service.services import Services

UNITS = {"h": 3600.0, "d": 86400.0, "w": 7 * 86400.0}


@dataclass(frozen=True)
class DeletionOptions:
    """Describe what is deleted; each field is the option of its name."""

    older_than: str | None
    batch: str | None
    subject: str | None
    family: str | None
    person: str | None


deletion_options = gather(
    DeletionOptions,
    [
        click.option("--older-than", metavar="90d", help="All that ended longer ago than this, in h, d or w."),
        click.option("--batch", "--tag", "batch", help="All jobs with this tag."),
        click.option("--subject", metavar="NAME", help="This person, with scans, jobs and everything made of them."),
        click.option("--family", metavar="JOB", help="All jobs of this job's family."),
        click.option("--person", metavar="NAME", help="The same, also found by the name of a job, scan or upload."),
    ],
)


@click.command("delete")
@click.argument("jobs", nargs=-1, metavar="[JOB...]")
@deletion_options
@click.option("--dry-run", is_flag=True, help="List what would be deleted, and delete nothing.")
@click.option("--yes", is_flag=True, help="Do not ask for confirmation.")
@known_home_option
@json_option
def command(
    jobs: tuple[str, ...], options: DeletionOptions, dry_run: bool, yes: bool, home: Path | None, as_json: bool
) -> None:
    """Delete ended jobs with their files.

    All jobs below a job are deleted too, and every job that reads its result. Files that no other job names are deleted
    at once. A person's data is found by the exact name of a subject, a job, a scan or an upload (`anna`, or `anna.ply`
    with its extension), and then by the content of the files under any other name; backups are not changed. With
    --dry-run everything that would be deleted is listed.

    \b
    Example:
      garmentq delete 3685ecfd4f81
      garmentq delete --older-than 90d
      garmentq delete --batch 2026-11
      garmentq delete --person anna --dry-run
    """
    from ..service.deletion import delete_jobs, find_dependent_jobs
    from ..service.persons import describe_jobs
    from ..service.services import open_services
    from ..service.settings import read_settings
    from .confirm import confirm_deletion
    from .terminal import print_json, print_note

    services = open_services(read_settings(home=home))
    database, store = services.database, services.store
    try:
        erase = find_erasure(services, options)
        chosen = choose_jobs(database, jobs, options)
        found = None if erase is None else erase(is_dry_run=True).found
        if found is None and not chosen:
            print_note("nothing to delete")
            return
        if dry_run or not yes:
            going = found.jobs if found else describe_jobs(database, find_dependent_jobs(database, chosen))
            show_person(going, found, as_json)
            if dry_run and as_json:
                print_json(asdict(found) if found else {"jobs": [asdict(one) for one in going]})
        if dry_run:
            return
        if not yes:
            confirm_deletion()
        done = delete_jobs(database, store, chosen) if erase is None else erase()
    finally:
        database.dispose()
    if as_json:
        print_json(asdict(done))
    else:
        show_deleted(done)


def choose_jobs(database: Database, jobs: Sequence[str], options: DeletionOptions) -> list[str]:
    """Return the jobs that a command names; of a person all.

    Raises:
        UsageError: unless they are named in exactly one way.
    """
    from ..service.deletion import find_old_families, find_tagged_families
    from ..service.jobs import find_job
    from ..service.persons import find_person, find_subject_data

    if sum((bool(jobs), *(value is not None for value in asdict(options).values()))) != 1:
        raise click.UsageError("Give jobs, --older-than, --batch, --subject, --family or --person.")
    if options.person is not None:
        return [one.job for one in find_person(database, options.person).jobs]
    if options.subject is not None:
        return [one.job for one in find_subject_data(database, options.subject).jobs]
    if options.family is not None:
        return [find_job(database, options.family).family]
    if options.batch is not None:
        return find_tagged_families(database, options.batch)
    if options.older_than is not None:
        return find_old_families(database, _seconds(options.older_than))
    return [find_job(database, job).id for job in jobs]


def find_erasure(services: Services, options: DeletionOptions) -> Callable[..., PersonDeleted] | None:
    """Return the function that deletes all of a person, not only jobs; None where no person is named."""
    from ..service.persons import delete_person, delete_subject

    if options.person is not None:
        return partial(delete_person, services.database, services.store, options.person)
    if options.subject is not None:
        return partial(delete_subject, services.database, services.store, options.subject)
    return None


def show_deleted(done: Deleted) -> None:
    """Print what was deleted."""
    from .terminal import print_note

    later = f"; {done.young} new files are deleted by `garmentq gc` in a day" if done.young else ""
    size = f"{done.size / 1e6:.1f} MB"
    print_note(f"deleted {len(done.jobs)} jobs, {done.uploads} uploads, {done.files} files of {size}{later}")


def show_person(jobs: Sequence[PersonJob], person: Person | None, as_json: bool) -> None:
    """Show what would be deleted; with JSON output only as a note."""
    from .terminal import print_note, print_table

    uploads = person.uploads if person else ()
    if not as_json:
        rows = [[f"job {one.job}", one.name, one.kind, " ".join(one.keys)] for one in jobs]
        rows += [[f"upload {one.sha256[:12]}", one.name, "", one.key] for one in uploads]
        print_table(["to delete", "name", "kind", "API keys"], rows)
    keys = sorted({key for one in jobs for key in one.keys} | {one.key for one in uploads if one.key})
    owner_text = f" of {len(keys)} API keys ({', '.join(keys)})" if keys else ""
    print_note(f"{len(jobs)} jobs and {len(uploads)} uploads{owner_text}, with their files")


def _seconds(text: str) -> float:
    found = re.fullmatch(r"(\d{1,6})([hdw])", text)
    if found is None:
        raise click.BadParameter(f"'{text}'; write 12h, 90d or 8w.", param_hint="--older-than")
    return int(found[1]) * UNITS[found[2]]
