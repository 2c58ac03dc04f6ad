"""`garmentq status`."""

from __future__ import annotations

from pathlib import Path

import click

from .options import home_option, json_option


@click.command("status")
@click.argument("job", required=False)
@click.option("--limit", type=click.IntRange(1, 10000), default=20, show_default=True, help="Jobs shown at most.")
@click.option("--watch", is_flag=True, help="Show jobs and workers until Ctrl-C.")
@home_option
@json_option
def command(job: str | None, limit: int, watch: bool, home: Path | None, as_json: bool) -> None:
    """Show the jobs, or one of them.

    \b
    Example:
      garmentq status
      garmentq status --watch
      garmentq status 3685ecfd4f81 --json
    """
    from ..service.anywhere import describe_job, find_job, list_jobs, open_database
    from ..service.settings import read_settings
    from .terminal import print_error, print_json, print_table, show_time

    database = open_database(read_settings(home=home))
    if watch:
        from .live import watch_queue

        watch_queue(database, job, limit)
        return
    rows = [find_job(database, job)] if job else list_jobs(database, limit)
    if as_json:
        for row in rows:
            print_json(describe_job(database, row))
        return
    print_table(
        ["job", "scan", "state", "stage", "%", "attempts", "created", "ended"],
        [
            [
                row.id,
                row.name,
                row.state,
                row.stage,
                round(100 * row.progress),
                row.attempts,
                show_time(row.created),
                show_time(row.finished),
            ]
            for row in rows
        ],
    )
    if job and rows[0].error_code:
        print_error(rows[0].error_code, rows[0].error_message or "")
