"""`garmentq verify`."""

from __future__ import annotations

from pathlib import Path

import click

from . import exits
from .options import json_option, known_home_option


@click.command("verify")
@click.option(
    "--read-data", is_flag=True, help="Read every file and compare its hash; otherwise check only that it exists."
)
@known_home_option
@json_option
@click.pass_context
def command(context: click.Context, read_data: bool, home: Path | None, as_json: bool) -> None:
    """Check that every stored file exists and is undamaged.

    Names each missing or damaged file, with the jobs, templates and uploads that it belongs to, and each row of the
    database that cannot be read. The exit status is 11 if there is one. Nothing is changed.

    \b
    Example:
      garmentq verify
      garmentq verify --read-data
    """
    from dataclasses import asdict

    from ..service.damage import describe_damaged_rows
    from ..service.database import check_integrity
    from ..service.services import open_services
    from ..service.settings import read_settings
    from ..service.verify import verify_store
    from .terminal import print_json, print_note, print_table

    services = open_services(read_settings(home=home))
    check_integrity(services.database)
    found = verify_store(services.database, services.store, read_data)
    services.database.dispose()
    status = exits.INCOMPLETE if found.faults or found.rows else exits.OK
    if as_json:
        for line in (*map(asdict, found.faults), *map(asdict, found.rows)):
            print_json(line)
        context.exit(status)
    if found.rows:
        print_table(
            ["damaged row of", "key", "columns"], [[one.table, one.key, ", ".join(one.columns)] for one in found.rows]
        )
        print_note(describe_damaged_rows(found.rows))
    if found.faults:
        rows = [[one.owner, one.name, fault.fault, fault.sha256[:12]] for fault in found.faults for one in fault.named]
        print_table(["belongs to", "file", "", "hash"], rows)
    what = f"{found.files} files of {found.size / 1e6:.1f} MB {'were read' if read_data else 'were looked up'}"
    wrong = f"{len(found.faults)} missing or damaged; restore them from a backup, or run their jobs with --force"
    print_note(f"{what}: {wrong if found.faults else 'all exist' + (' and are undamaged' if read_data else '')}")
    context.exit(status)
