"""`garmentq result`."""

from __future__ import annotations

from pathlib import Path

import click

from . import exits
from .options import home_option, json_option, verbose_option


@click.command("result")
@click.argument("job")
@home_option
@verbose_option
@json_option
@click.pass_context
def command(context: click.Context, job: str, home: Path | None, verbose: bool, as_json: bool) -> None:
    """Show what a job found.

    The exit status is the job's: 0 succeeded, 4 bad input, 5 failed, 6 dead, 7 cancelled; 3 where it has no result yet.

    \b
    Example:
      garmentq result 3685ecfd4f81
    """
    from ..service.anywhere import ENDED, ResultMissing, describe_job, find_job, list_files, open_database
    from ..service.settings import read_settings
    from ..service.states import State
    from .summary import print_result
    from .terminal import print_error, print_json, print_table

    database = open_database(read_settings(home=home))
    row = find_job(database, job)
    if row.state not in ENDED:
        raise ResultMissing(f"job {row.id} is {row.state}; `garmentq logs -f {row.id}` follows it.")
    found = describe_job(database, row)
    files = list_files(database, row.id)
    if as_json:
        kept = [{"name": file.name, "sha256": file.sha256, "size": file.size} for file in files]
        print_json({**found, "files": kept})
    elif row.state == State.SUCCEEDED:
        print_result(found, [], verbose)
        if verbose:
            print_table(["file", "bytes", "sha256"], [[file.name, file.size, file.sha256[:12]] for file in files])
    if row.error_code:
        print_error(row.error_code, row.error_message or "")
    context.exit(exits.job_status(row.state, row.bad_input))
