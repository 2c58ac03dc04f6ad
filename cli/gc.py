"""`garmentq gc`."""

from __future__ import annotations

from pathlib import Path

import click

from . import exits
from .options import json_option, known_home_option

GARBAGE_GRACE_HOURS = 24.0
"""Least age of a file that may be deleted [h], as in `service.garbage`, which is not imported for `--help`; a test
compares them."""


@click.command("gc")
@click.option("--delete", "is_delete", is_flag=True, help="Delete them; otherwise they are only counted.")
@click.option(
    "--grace-hours",
    type=click.FloatRange(min=0.0),
    default=GARBAGE_GRACE_HOURS,
    show_default=True,
    help="Keep younger files [h]: a running job may be about to use them.",
)
@known_home_option
@json_option
@click.pass_context
def command(context: click.Context, is_delete: bool, grace_hours: float, home: Path | None, as_json: bool) -> None:
    """Delete stored files that no job names.

    Such files remain after crashes, and from checkpoints that newer ones replaced. Families and subjects whose
    retention is over are deleted first. Without --delete nothing is changed.
    Each database must have a store of its own. If a row of the database is damaged nothing is deleted, because it may
    name any file; the exit status is 11 then.

    \b
    Example:
      garmentq gc
      garmentq gc --delete
    """
    from ..service.damage import describe_damaged_rows
    from ..service.database import open_database
    from ..service.garbage import collect_garbage
    from ..service.retention import delete_expired, find_expired
    from ..service.settings import read_settings
    from ..service.stores import open_store
    from .terminal import print_json, print_note

    settings = read_settings(home=home)
    database, store = open_database(settings), open_store(settings)
    try:
        expired = find_expired(database, settings)
        ended = delete_expired(database, store, expired) if is_delete else 0
        found = collect_garbage(database, store, grace_hours * 3600.0, is_delete)
    finally:
        database.dispose()
    if as_json:
        counts = {"files": len(found.files), "bytes": found.size, "removed": found.removed}
        counts |= {"expired": expired.count, "expired_removed": ended}
        print_json({**counts, "kept_bytes": found.kept_bytes, "damaged_rows": len(found.damaged)})
        context.exit(exits.INCOMPLETE if found.damaged else exits.OK)
    if expired.count:
        over = f"{len(expired.families)} families and {len(expired.subjects)} subjects whose retention is over"
        print_note(f"deleted {ended} of {over}" if is_delete else over)
    what = f"{len(found.files)} files of {found.size / 1e6:.1f} MB that no job names"
    print_note(f"deleted {found.removed} of {what}" if is_delete else f"{what}; `garmentq gc --delete` deletes them")
    if found.damaged:
        print_note(f"nothing is deleted, because one of these may name a file: {describe_damaged_rows(found.damaged)}")
        context.exit(exits.INCOMPLETE)
