"""`garmentq query`."""

from __future__ import annotations

from pathlib import Path

import click

from .options import home_option, json_option


@click.command("query")
@click.option("--garment", help="Category: tshirt, tank, dress, trousers, skirt, ...")
@click.option("--state", help="State: queued, running, succeeded, failed, dead, cancelled.")
@click.option("--fabric", help="Name of the fabric.")
@click.option("--where", "wheres", multiple=True, help="NAME OPERATOR VALUE, joined by 'and'; may be given repeatedly.")
@click.option("--sort", default="-created", show_default=True, help="Field or metric; '-' before it: largest first.")
@click.option("--limit", type=click.IntRange(1, 10000), default=50, show_default=True, help="Jobs shown at most.")
@click.option("--csv", "as_csv", is_flag=True, help="Print a table for a spreadsheet, with every metric.")
@home_option
@json_option
def command(
    garment: str | None,
    state: str | None,
    fabric: str | None,
    wheres: tuple[str, ...],
    sort: str,
    limit: int,
    as_csv: bool,
    home: Path | None,
    as_json: bool,
) -> None:
    """Find jobs by what they found.

    Names are the fields job, name, state, version, error, garment, template, fabric, body, method, preset, created,
    started, finished, attempts, priority, cpu_seconds, peak_mb, and every metric. Operators: < <= > >= = !=

    \b
    Example:
      garmentq query --garment skirt --where 'surface_rms_mm.t2s < 4' --sort -created --json
    """
    from ..service.anywhere import describe_job, find_jobs, open_database
    from ..service.query import parse_conditions
    from ..service.settings import read_settings
    from .summary import flatten
    from .terminal import print_csv, print_json, print_table, show_time

    database = open_database(read_settings(home=home))
    given = {"garment": garment, "state": state, "fabric": fabric}
    chosen = {name: value for name, value in given.items() if value is not None}
    conditions = [condition for text in wheres for condition in parse_conditions(text)]
    found = [describe_job(database, row) for row in find_jobs(database, chosen, wheres, sort, limit)]
    if as_json:
        for item in found:
            print_json(item)
        return
    if as_csv:
        print_csv(*flatten(found))
        return
    shown = ["surface_rms_mm.s2t", "surface_rms_mm.t2s"]
    shown += [c.name for c in conditions if any(c.name in item["metrics"] for item in found) and c.name not in shown]
    print_table(
        ["job", "scan", "state", "garment", "fabric", *shown, "created"],
        [
            [
                *(item[name] for name in ("job", "name", "state", "garment", "fabric")),
                *(item["metrics"].get(name) for name in shown),
                show_time(item["created"]),
            ]
            for item in found
        ],
    )
