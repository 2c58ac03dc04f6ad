"""`garmentq query`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import click

from .options import gather, json_option, known_home_option

OPTION_FIELDS = ("garment", "state", "fabric", "name", "kind", "family", "tag", "subject")
"""Fields that have an option of their own."""


@dataclass(frozen=True)
class QueryOptions:
    """Describe the options of a query; each field is the option of its name."""

    garment: str | None
    state: str | None
    fabric: str | None
    name: str | None
    kind: str | None
    family: str | None
    tag: str | None
    subject: str | None
    wheres: tuple[str, ...]
    sort: str
    limit: int


query_options = gather(
    QueryOptions,
    [
        click.option("--garment", help="Category: tshirt, tank, dress, trousers, skirt, ..."),
        click.option("--state", help="State: waiting, queued, running, succeeded, failed, dead, cancelled."),
        click.option("--fabric", help="Name of the fabric."),
        click.option("--name", help="Name of the job."),
        click.option("--kind", help="Kind of job, such as recover."),
        click.option("--family", help="Id of the root job of a family."),
        click.option("--batch", "--tag", "tag", help="Tag that was given at submission."),
        click.option("--subject", help="Name or id of the person who was scanned."),
        click.option("--where", "wheres", multiple=True, help="NAME OPERATOR VALUE, joined by 'and'; may be repeated."),
        click.option(
            "--sort", default="-created", show_default=True, help="Field or metric; '-' before it: largest first."
        ),
        click.option(
            "--limit", type=click.IntRange(1, 10000), default=50, show_default=True, help="Largest number of jobs."
        ),
    ],
)


@click.command("query")
@query_options
@click.option("--csv", "as_csv", is_flag=True, help="Print a table for a spreadsheet, with times as in ISO 8601.")
@click.option("--columns", metavar="all|NAME,NAME", help="Columns of that table: all, or fields and metrics by name.")
@known_home_option
@json_option
def command(options: QueryOptions, as_csv: bool, columns: str | None, home: Path | None, as_json: bool) -> None:
    """Search completed jobs by their results.

    Names are the fields job, name, kind, family, parent, tag, subject, state, version, error, garment, template,
    fabric, body, method, preset, created, started, finished, attempts, priority, cpu_seconds, peak_mb, and every
    metric. Operators: < <= > >= = !=

    \b
    Example:
      garmentq query --garment skirt --where 'surface_rms_mm.t2s < 4' --sort -created --json
      garmentq query --batch 2026-11 --csv
    """
    from ..service.backend import open_backend
    from ..service.query import JobQuery
    from ..service.settings import read_settings
    from .query_table import tabulate
    from .terminal import print_csv, print_json, print_note, print_table, show_time

    fields = {name: value for name in OPTION_FIELDS if (value := getattr(options, name)) is not None}
    query = JobQuery(fields, options.wheres, options.sort, options.limit)
    if columns is not None and not as_csv:
        raise click.UsageError("--columns is for --csv.")
    backend = open_backend(read_settings(home=home))
    found = backend.find_jobs(query)
    if as_json:
        for job in found:
            print_json(job.as_json())
        return
    if as_csv:
        print_csv(*tabulate(backend, found, columns))
        return
    if not found:
        print_note("no job matches; `garmentq query` alone lists the newest jobs")
        return
    metrics = [c.name for c in query.conditions if any(c.name in job.metrics for job in found)]
    shown = list(dict.fromkeys(["surface_rms_mm.s2t", "surface_rms_mm.t2s", *metrics]))
    print_table(
        ["job", "name", "kind", "state", "garment", "fabric", *shown, "created"],
        [
            [job.id, job.name, job.kind, job.state, job.garment, job.fabric]
            + [job.metrics.get(name) for name in shown]
            + [show_time(job.created)]
            for job in found
        ],
    )
