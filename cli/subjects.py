"""`garmentq subjects`."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from .options import gather, home_option, json_option

if TYPE_CHECKING:
    from ..service.backend import Backend
    from ..service.subject_records import Subject, SubjectFields

NEVER = "never"
"""Value of an option that empties a time."""

DAYS = re.compile(r"(\d{1,5})d")
"""A retention in days."""


@dataclass(frozen=True)
class SubjectOptions:
    """Describe the options about a subject; each field is the option of its name, None if it is not given."""

    note: str | None
    consented: str | None
    consent: str | None
    consent_until: str | None
    keep: tuple[str, ...]


subject_options = gather(
    SubjectOptions,
    [
        click.option("--note", help="Any text."),
        click.option("--consented", metavar="DATE", help="When the person agreed to be scanned."),
        click.option("--consent", metavar="TEXT", help="Where that is written: a reference, or the text itself."),
        click.option("--consent-until", metavar="DATE", help="Until when the person agreed; or never."),
        click.option(
            "--keep", multiple=True, metavar="90d|DATE",
            help="Delete all its data so long after its newest job, or at a date; or never; may be repeated.",
        ),
    ],
)  # fmt: skip


@click.group("subjects")
def command() -> None:
    """List, show, create, update and delete subjects: the persons who were scanned.

    \b
    Example:
      garmentq subjects create 'Anna Mueller' --consented 2026-11-22 --keep 90d
      garmentq submit scans/anna.ply --subject 'Anna Mueller'
    """


@command.command("list")
@click.option("--name", default="", help="Only the subject of exactly this name.")
@click.option("--limit", type=click.IntRange(1, 1000), default=50, show_default=True, help="Largest number.")
@home_option
@json_option
def list_command(name: str, limit: int, home: Path | None, as_json: bool) -> None:
    """List the newest subjects, the number of their jobs, and when their data are deleted.

    \b
    Example:
      garmentq subjects list
    """
    _show(_open(home).list_subjects(name, limit), as_json)


@command.command("show")
@click.argument("subject")
@home_option
@json_option
def show_command(subject: str, home: Path | None, as_json: bool) -> None:
    """Show a subject, by its name or id, with its scans, jobs and body measures.

    \b
    Example:
      garmentq subjects show 'Anna Mueller'
    """
    from .terminal import print_json, print_table, show_time

    found = _open(home).find_subject(subject)
    if as_json:
        print_json(found.as_json())
        return
    _show([found], False)
    if found.note or found.consent:
        print_table(["", "text"], [[name, text] for name, text in (("note", found.note), ("consent", found.consent))])
    print_table(
        ["job", "name", "kind", "state", "verdict", "garments", "created"],
        [
            [one.job, one.name, one.kind, one.state, one.verdict]
            + [one.garment or ", ".join(child.name for child in one.children), show_time(one.created)]
            for one in found.families
        ],
    )
    print_table(
        ["scan", "name", "MB", "stored"],
        [[one.sha256[:12], one.name, round(one.size / 1e6, 1), show_time(one.created)] for one in found.scans],
    )
    for wearer in found.wearers[:1]:
        rows = [[name.replace("_", " "), round(value / 10.0, 1)] for name, value in wearer.measures.items()]
        print_table(["measure", "cm"], rows, f"body of job {wearer.job}")


@command.command("create")
@click.argument("name")
@subject_options
@home_option
@json_option
def create_command(name: str, options: SubjectOptions, home: Path | None, as_json: bool) -> None:
    """Create a subject.

    \b
    Example:
      garmentq subjects create 'Anna Mueller' --consented 2026-11-22 --consent 'form 7' --keep 90d
    """
    from ..service.subject_records import SubjectFields

    _show([_open(home).create_subject(_apply(SubjectFields(name), options))], as_json)


@command.command("update")
@click.argument("subject")
@click.option("--name", help="New name.")
@subject_options
@home_option
@json_option
def update_command(subject: str, name: str | None, options: SubjectOptions, home: Path | None, as_json: bool) -> None:
    """Change what is said of a subject; all else stays.

    \b
    Example:
      garmentq subjects update 'Anna Mueller' --keep never
    """
    backend = _open(home)
    known = backend.find_subject(subject)
    fields = _apply(known.said if name is None else replace(known.said, name=name), options)
    _show([backend.update_subject(known.id, fields)], as_json)


@command.command("add")
@click.argument("subject")
@click.argument("jobs", nargs=-1, required=True)
@home_option
@json_option
def add_command(subject: str, jobs: tuple[str, ...], home: Path | None, as_json: bool) -> None:
    """Make jobs, with all of their families, a subject's.

    \b
    Example:
      garmentq subjects add 'Anna Mueller' 3685ecfd4f81
    """
    backend = _open(home)
    _show([backend.assign_jobs(subject, [backend.find_job(job).id for job in jobs])], as_json)


@command.command("delete")
@click.argument("subject")
@click.option("--dry-run", is_flag=True, help="List what would be deleted, and delete nothing.")
@click.option("--yes", is_flag=True, help="Do not ask for confirmation.")
@home_option
@json_option
def delete_command(subject: str, dry_run: bool, yes: bool, home: Path | None, as_json: bool) -> None:
    """Delete a subject with its scans, uploads and jobs, and all that was made of them; backups are not changed.

    \b
    Example:
      garmentq subjects delete 'Anna Mueller' --dry-run
    """
    from dataclasses import asdict

    from .confirm import confirm_deletion
    from .delete import show_deleted, show_person
    from .terminal import print_json

    backend = _open(home)
    if dry_run or not yes:
        found = backend.delete_subject(subject, dry_run=True).found
        show_person(found.jobs, found, as_json)
        if dry_run:
            if as_json:
                print_json(asdict(found))
            return
        confirm_deletion()
    done = backend.delete_subject(subject)
    if as_json:
        print_json(asdict(done))
    else:
        show_deleted(done)


def _open(home: Path | None) -> Backend:
    from ..service.backend import open_backend
    from ..service.settings import read_settings

    return open_backend(read_settings(home=home))


def _show(subjects: Sequence[Subject], as_json: bool) -> None:
    from .terminal import print_json, print_table

    if as_json:
        for one in subjects:
            print_json(one.as_json())
        return
    print_table(
        ["subject", "name", "jobs", "created", "consented", "until", "deleted on", "API key"],
        [
            [one.id, one.name, one.jobs, _date(one.created), _date(one.consented), _date(one.consent_until)]
            + [_date(one.expires), one.key]
            for one in subjects
        ],
    )


def _date(seconds: float | None) -> str:
    return "" if seconds is None else datetime.fromtimestamp(seconds).strftime("%Y-%m-%d")


def _apply(fields: SubjectFields, options: SubjectOptions) -> SubjectFields:
    """Return what is said of a subject with the options that are given."""
    changes: dict[str, Any] = {}
    for name in ("note", "consent"):
        if (text := getattr(options, name)) is not None:
            changes[name] = text
    for name in ("consented", "consent_until"):
        if (text := getattr(options, name)) is not None:
            changes[name] = read_date(text, f"--{name.replace('_', '-')}")
    if options.keep:
        changes |= {"keep_days": None, "keep_until": None}
    for text in options.keep:
        if days := DAYS.fullmatch(text):
            changes["keep_days"] = float(days[1])
        elif (until := read_date(text, "--keep")) is not None:
            changes["keep_until"] = until
    return replace(fields, **changes)


def read_date(text: str, option: str) -> float | None:
    """Return a date as seconds since 1970, in this machine's zone where it has none; None for `never`.

    Raises:
        BadParameter: if it is no date.
    """
    if text == NEVER:
        return None
    try:
        return datetime.fromisoformat(text).timestamp()
    except (ValueError, OverflowError):
        raise click.BadParameter(f"'{text[:40]}'; write a date as 2026-11-22, or never.", param_hint=option) from None
