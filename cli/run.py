"""`garmentq run`: submission, worker and result in one command."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..service.states import OPEN, State
from . import exits
from .options import (
    OrderOptions,
    WaitOptions,
    home_option,
    json_option,
    order_options,
    verbose_option,
    wait_options,
    workers_option,
)
from .output import NewFolder, writing

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..service.backend import Backend
    from ..service.records import JobReport
    from .follow import Wait

MAX_FOLDER_NAME_LENGTH = 60
"""Largest number of letters of a folder's name: file systems allow 255 bytes, and a letter has up to four."""


@click.command("run")
@click.argument("file", type=click.Path(path_type=Path))
@order_options
@home_option
@click.option("--out", type=NewFolder(), help="Folder for the result's files.")
@workers_option
@wait_options
@verbose_option
@json_option
def command(
    file: Path,
    options: OrderOptions,
    home: Path | None,
    out: Path | None,
    workers: int | None,
    waiting: WaitOptions,
    verbose: bool,
    as_json: bool,
) -> None:
    """Recover a garment: submit its scan, run the job here, wait, and show the result.

    The job is queued; a broker and a worker are started if none runs, and stop by themselves after a while without work
    (`garmentq down` stops them now). Ctrl-C only stops waiting. A raw scan of a dressed person needs no further
    options: each worn garment is a job below it, with its files in a folder of the garment's name. Each --keep is a
    garment, and a job, of its own; its files are in a folder of the label's name.

    \b
    Example:
      garmentq run scan.ply --out result
      garmentq run garment.ply --body body.ply --out result
      garmentq run skirt.obj --body builtin:female,height=1.70 --units cm --json
      garmentq run person.ply --labels labels.npz --keep 1
      garmentq run person.ply --keep 1 --keep 2 --out result
    """
    from ..service.backend import open_backend
    from ..service.settings import read_settings
    from ..workers.embedded import StoppedByUser, ensure_services, was_stopped
    from .follow import Wait
    from .order import describe_choice, describe_overrides, make_order, split_garments
    from .terminal import print_note

    settings = read_settings(home=home)
    backend = open_backend(settings)
    parts = list(split_garments(options))
    orders = [make_order(backend, file, part) for part in parts]
    garments = [backend.submit(order) for order in orders]

    def start() -> None:
        for name in () if backend.is_remote else ensure_services(settings, workers):
            print_note(f"started the {name}")

    def keep_up() -> None:
        """Restart what died, but not what a user stopped."""
        if not backend.is_remote and was_stopped(settings):
            raise StoppedByUser()
        start()

    if any(submitted.state != State.SUCCEEDED for submitted in garments):
        start()
    for order, submitted in zip(orders, garments, strict=True):
        print_note(f"job {submitted.job}" + ("" if submitted.is_new else f" (known, {submitted.state})"))
        print_note(f"{file.name}: {describe_choice(order)}{describe_overrides(options)}")
    submitted_jobs = {submitted.job for submitted in garments if submitted.state in OPEN}
    others = sum(count for state, count in backend.read_queue().states.items() if state in OPEN) - len(submitted_jobs)
    if submitted_jobs and others > 0:
        print_note(f"{others} other jobs wait or run; `garmentq status` shows them")
    statuses, wait = [], Wait(waiting.timeout, as_json, keep_up, waiting.lenient)
    for part, submitted in zip(parts, garments, strict=True):
        folder = out or settings.home / "results" / submitted.job
        if out is not None and len(parts) > 1:
            folder = out / folder_name(part.keep[0])
        statuses.append(wait_and_show(backend, submitted.job, folder.absolute(), wait, verbose, out is None))
        if statuses[-1] == exits.DETACHED:  # one Ctrl-C ends all waits
            break
    click.get_current_context().exit(exits.worst(statuses))


def folder_name(label: str) -> str:
    """Return the folder name for a garment's label: other characters than letters, digits, - and _ are replaced."""
    return "".join(c if c.isalnum() or c in "-_" else "_" for c in label[:MAX_FOLDER_NAME_LENGTH]) or "_"


def wait_and_show(
    backend: Backend, job: str, folder: Path, wait: Wait, verbose: bool = False, in_home: bool = False
) -> int:
    """Wait for a job and all below it, copy their files, and show their results.

    Args:
        backend: The job's backend.
        job: Its id.
        folder: Folder for its files; those of a job below it are written into a folder of that job's name.
        wait: How to wait for its end; with `as_json` one object is printed instead of tables.
        verbose: Print every number instead of the summary.
        in_home: The folder is in the home and private.

    Returns:
        Exit status, the worst of the family.
    """
    from contextlib import suppress

    from ..service.results import ResultMissing
    from .family import drop_redrapes
    from .follow import WaitTimedOut, follow
    from .summary import print_result
    from .terminal import print_error, print_json, print_note

    try:
        family = drop_redrapes(follow(backend, job, wait))
    except WaitTimedOut:
        print_note(f"job {job} continues; `garmentq logs -f {job}` follows it.")
        return exits.TIMED_OUT
    except KeyboardInterrupt:
        print_note(f"job {job} continues; `garmentq logs -f {job}` follows it, `garmentq cancel {job}` stops it.")
        return exits.DETACHED
    folders = name_folders(family, folder)
    for found in family:
        files: list[Path] = []
        # not every kind of job has files, and failed jobs seldom have
        with suppress(ResultMissing), writing(folder, in_home):
            files = backend.export_files(found.id, folders[found.id])
        if wait.as_json:
            local = {path.relative_to(folders[found.id]).as_posix(): str(path) for path in files}
            print_json({**found.as_json(), "files": local})
        elif found.state == State.SUCCEEDED or files:
            print_result(found, files, verbose)
        if found.error:
            print_error(found.error.code, found.error.message)
        elif found.state == State.CANCELLED:
            print_note(f"job {found.id} was cancelled")
    return exits.worst(exits.job_status(found, wait.is_lenient) for found in family)


def name_folders(family: Sequence[JobReport], folder: Path) -> dict[str, Path]:
    """Return the folder of each job of a family: that of a job below is in its parent's and has its name."""
    folders: dict[str, Path] = {}
    for job in family:
        if job.parent not in folders:
            folders[job.id] = folder
            continue
        target = folders[job.parent] / folder_name(job.name)
        folders[job.id] = target if target not in folders.values() else target.with_name(f"{target.name}_{job.id}")
    return folders
