"""`garmentq run`: the whole road in one command."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..service.states import State
from . import exits
from .options import home_option, json_option, order_options, timeout_option, verbose_option, workers_option

if TYPE_CHECKING:
    from ..service.anywhere import Place
    from ..service.settings import ServiceSettings


@click.command("run")
@click.argument("file", type=click.Path(path_type=Path))
@order_options
@home_option
@click.option("--out", type=click.Path(file_okay=False, path_type=Path), help="Folder for the result's files.")
@workers_option
@timeout_option
@verbose_option
@json_option
@click.pass_context
def command(
    context: click.Context,
    file: Path,
    home: Path | None,
    out: Path | None,
    workers: int | None,
    timeout: float | None,
    verbose: bool,
    as_json: bool,
    **options: Any,
) -> None:
    """Recover a garment: submit it, work on it here, wait, and show the result.

    The job goes through the queue; a broker and a worker are started if none runs, and stop by themselves after a
    while without work (`garmentq down` stops them now). Ctrl-C only stops waiting. Each --keep of a dressed person's
    scan is a garment, and a job, of its own; its files are in a folder of the label's name.

    \b
    Example:
      garmentq run garment.ply --body body.ply --out result
      garmentq run skirt.obj --body builtin:female,height=1.70 --units cm --json
      garmentq run person.ply --labels labels.npz --keep 1
      garmentq run person.ply --keep 1 --keep 2 --out result
    """
    from ..service.anywhere import is_remote, open_database, submit
    from ..service.settings import read_settings
    from ..service.stores import open_store
    from ..workers.embedded import ensure_services
    from .order import make_order, split_garments
    from .terminal import note

    settings = read_settings(home=home)
    database = open_database(settings)
    parts = split_garments(options)
    orders = [make_order(settings, database, file, part) for part in parts]
    garments = [submit(database, open_store(settings), order) for order in orders]

    def keep_up() -> None:
        for name in () if is_remote() else ensure_services(settings, workers):
            note(f"started the {name}")

    if any(submitted.state != State.SUCCEEDED for submitted in garments):
        keep_up()
    for submitted in garments:
        note(f"job {submitted.job}" + ("" if submitted.is_new else f" (known, {submitted.state})"))
    status = exits.OK
    for part, submitted in zip(parts, garments, strict=True):
        folder = out if out is None or len(parts) == 1 else out / folder_name(part["keep"][0])
        ended = wait_and_show(settings, database, submitted.job, timeout, folder, as_json, keep_up, verbose)
        status = max(status, ended)
    context.exit(status)


def folder_name(label: str) -> str:
    """Give the folder of a garment of several: its label, of which only letters, digits, - and _ are kept."""
    return "".join(c if c.isalnum() or c in "-_" else "_" for c in label)


def wait_and_show(
    settings: ServiceSettings,
    database: Place,
    job: str,
    timeout: float | None,
    out: Path | None,
    as_json: bool,
    keep_up: Callable[[], None] | None = None,
    verbose: bool = False,
) -> int:
    """Wait for a job, bring its files out, and show what it found.

    Args:
        settings: Which home.
        database: Its database.
        job: The job's id.
        timeout: Seconds to wait at most, or None.
        out: Folder for the files; None: below the home.
        as_json: Print one object instead of tables.
        keep_up: Called now and then, to start again what died meanwhile.
        verbose: Print every number instead of the summary.

    Returns:
        Exit status.
    """
    from ..service.anywhere import describe_job, export_files
    from ..service.stores import open_store
    from .follow import WaitTimedOut, follow
    from .summary import print_result
    from .terminal import note, print_error, print_json

    try:
        row = follow(database, job, timeout, as_json, keep_up)
    except WaitTimedOut:
        note(f"job {job} goes on; `garmentq logs -f {job}` follows it.")
        return exits.TIMED_OUT
    except KeyboardInterrupt:
        note(f"job {job} goes on; `garmentq logs -f {job}` follows it, `garmentq cancel {job}` stops it.")
        return exits.DETACHED
    found = describe_job(database, row)
    files: list[Path] = []
    if row.state == State.SUCCEEDED:
        folder = (out or settings.home / "results" / job).absolute()
        files = export_files(database, open_store(settings), job, folder)
    if as_json:
        print_json({**found, "files": {path.name: str(path) for path in files}})
    elif files:
        print_result(found, files, verbose)
    if row.error_code:
        print_error(row.error_code, row.error_message or "")
    elif row.state == State.CANCELLED:
        note(f"job {job} was cancelled")
    return exits.job_status(row.state, row.bad_input)
