"""`garmentq export`."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..core.deliver.formats.registry import DIALECTS, FORMATS
from ..core.run.errors import GarmentqError
from .export_folders import find_chosen, find_garments, prefix_files
from .options import Decorator, gather, json_option, known_home_option, out_option, timeout_option, workers_option
from .output import writing

if TYPE_CHECKING:
    from ..service.backend import Backend

JOB_ID = re.compile(r"[0-9a-f]{4,16}")
"""Form of a job's id, or of its beginning."""

MAX_EXPORT_TABLE_SIZE = 1 << 20
"""Largest size of a table of allowances or sizes [bytes]."""


@dataclass(frozen=True)
class ProductionOptions:
    """Describe the options of exported files; each field is the option of its name."""

    dialect: str | None
    allowance: str | None
    paper: str | None
    fold: bool
    texel: float | None
    timeout: float | None
    workers: int | None
    out: Path
    home: Path | None
    as_json: bool


def production_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options of exported files; the command receives them as one `production: ProductionOptions`."""
    options = [
        click.option("--dialect", type=click.Choice(DIALECTS), help="Dialect of DXF.  [default: aama]"),
        click.option(
            "--allowance",
            help="Seam allowances: 15mm, 5/8in, seam=10,hem=1in, a file of these, or none.  [default: usual]",
        ),
        click.option("--paper", help="a4, letter, a3, a0, roll, or roll:WIDTH in mm.  [default: a4]"),
        click.option("--fold", is_flag=True, help="Draw symmetric pieces as halves on the fold."),
        click.option("--texel", type=float, help="Width of a texel of a texture: 0.5, 1 or 2 mm.  [default: 1]"),
        timeout_option,
        workers_option,
        out_option,
        known_home_option,
        json_option,
    ]
    command: Decorator = gather(ProductionOptions, options, "production")(function)
    return command


@click.command("export")
@click.argument("job", required=False)
@click.argument("names", nargs=-1)
@click.option("--batch", "--tag", "tag", help="All recovered garments with this tag, each into a folder of its own.")
@click.option("--subject", help="All of this person.")
@click.option("--family", metavar="JOB", help="All of this job's family.")
@click.option("--as", "form", type=click.Choice(tuple(FORMATS)), help="Write the garment in another format.")
@production_options
@click.pass_context
def command(
    context: click.Context,
    job: str | None,
    names: tuple[str, ...],
    tag: str | None,
    subject: str | None,
    family: str | None,
    form: str | None,
    production: ProductionOptions,
) -> None:
    """Copy a job's files into a folder, or write its garment in another format.

    Without --as: all stored files, or only those named; every copy is checked against its hash. With --as a job of kind
    `export` writes the files; the command waits for it and copies them. Prints the paths. With --batch, --subject or
    --family, or with --as and a person's job, each garment goes into a folder PERSON_GARMENT, and a single or named
    file has that in front of its name; a garment that cannot be written does not stop the others.

    \b
    Example:
      garmentq export 3685ecfd4f81 pattern.svg detail.glb --out result
      garmentq export 3685ecfd4f81 --as pdf --paper a4 --allowance seam=10,hem=30
      garmentq export 3685ecfd4f81 --as dxf --dialect clo --fold --out for_clo
      garmentq export 3685ecfd4f81 --as texture --out print
      garmentq export --batch 2026-11 --as pdf --out patterns
      garmentq export --subject 'Anna Mueller' --out anna
    """
    from ..service.backend import open_backend
    from ..service.settings import read_settings

    chosen = {name: value for name, value in (("tag", tag), ("subject", subject), ("family", family)) if value}
    if chosen and job is not None and not JOB_ID.fullmatch(job):  # the first word is a file's name then
        names, job = (job, *names), None
    if (job is None) != bool(chosen) or len(chosen) > 1:
        raise click.UsageError("give a job, or one of --batch, --subject and --family.")
    if form is not None:
        if names:
            raise click.UsageError("give names of stored files, or --as FORMAT, not both.")
        options = {"format": form, **read_options(production)}
        context.exit(_write_all(job, chosen, options, production))
    if any((production.dialect, production.allowance, production.paper, production.fold, production.texel)):
        raise click.UsageError("--dialect, --allowance, --paper, --fold and --texel go with --as FORMAT.")
    backend = open_backend(read_settings(home=production.home))
    if job is None:
        context.exit(_copy_all(backend, chosen, production, names))
    found = backend.find_job(job)
    _print_paths(found.id, _copy(backend, found.id, production, names), production.as_json)


def _copy_all(backend: Backend, chosen: Mapping[str, str], production: ProductionOptions, names: Sequence[str]) -> int:
    """Copy the files of each garment that is meant; return the worst exit status."""
    from . import exits
    from .terminal import print_error

    statuses: list[int] = []
    for folder, garment in find_chosen(backend, _complete(backend, chosen)).items():
        try:
            paths = _copy(backend, garment, replace(production, out=production.out / folder), names)
            _print_paths(garment, prefix_files(folder, paths) if names else paths, production.as_json)
        except GarmentqError as error:
            print_error(error.code, f"{folder}: {error}")
            statuses.append(exits.error_status(error))
    return exits.worst(statuses)


def _complete(backend: Backend, chosen: Mapping[str, str]) -> dict[str, str]:
    """Return the fields of the jobs that are meant, with the family of the job that is named."""
    family = {"family": backend.find_job(chosen["family"]).family} if "family" in chosen else {}
    return {**chosen, **family}


def _write_all(
    job: str | None, chosen: Mapping[str, str], options: Mapping[str, Any], production: ProductionOptions
) -> int:
    """Write each garment that is meant in another format; return the worst exit status."""
    from ..service.backend import open_backend
    from ..service.settings import read_settings
    from . import exits
    from .terminal import print_error

    backend = open_backend(read_settings(home=production.home))
    if job is None:
        found = find_chosen(backend, _complete(backend, chosen))
    else:
        found = find_garments(backend, backend.find_job(job))
    if job is not None and len(found) < 2:
        return write_production(job, options, production)
    statuses: list[int] = []
    for folder, garment in found.items():
        try:
            own = write_production(garment, options, replace(production, out=production.out / folder), folder)
        except GarmentqError as error:
            print_error(error.code, f"{folder}: {error}")
            own = exits.error_status(error)
        statuses.append(own)
    return exits.worst(statuses)


def read_options(production: ProductionOptions) -> dict[str, Any]:
    """Return the fields of an export's request that were given."""
    fields: dict[str, Any] = {"dialect": production.dialect, "paper": production.paper, "texel": production.texel}
    if production.allowance is not None:
        fields["allowance"] = read_table(production.allowance)
    if production.fold:
        fields["fold"] = True
    return {name: value for name, value in fields.items() if value is not None}


def read_table(text: str) -> str:
    """Return the text of a file if there is one of that name, else the text itself.

    Raises:
        UsageError: if the file is too large or is not text.
    """
    path = Path(text)
    try:
        if not path.is_file():
            return text
        content = path.read_bytes()[: MAX_EXPORT_TABLE_SIZE + 1]
        if len(content) > MAX_EXPORT_TABLE_SIZE:
            raise click.UsageError(f"{path.name} is too large for a table.")
        return content.decode("utf-8-sig")
    except (OSError, ValueError) as error:
        raise click.UsageError(f"'{text[:60]}' cannot be read as text.") from error


def write_production(job: str, options: Mapping[str, Any], production: ProductionOptions, prefix: str = "") -> int:
    """Queue an export, wait for it, copy its files, print the paths, and return the exit status.

    A single file gets the prefix; several may name each other.
    """
    from ..service.backend import open_backend
    from ..service.derived import DerivedOrder
    from ..service.settings import read_settings
    from ..service.states import State
    from ..workers.embedded import ensure_services
    from . import exits
    from .follow import Wait, WaitTimedOut, follow
    from .terminal import print_error, print_note

    settings = read_settings(home=production.home)
    backend = open_backend(settings)
    done = backend.submit_derived(DerivedOrder("export", job, options))

    def keep_up() -> None:
        for name in () if backend.is_remote else ensure_services(settings, production.workers):
            print_note(f"started the {name}")

    if done.state != State.SUCCEEDED:
        keep_up()
    try:
        report = follow(backend, done.job, Wait(production.timeout, production.as_json, keep_up))[0]
    except WaitTimedOut:
        print_note(f"job {done.job} continues; `garmentq export {done.job}` copies its files.")
        return exits.TIMED_OUT
    if report.error:
        print_error(report.error.code, report.error.message)
    if report.state == State.SUCCEEDED:
        paths = _copy(backend, done.job, production)
        paths = prefix_files(prefix, paths) if prefix and len(paths) == 1 else paths
        _print_paths(done.job, paths, production.as_json)
    return exits.job_status(report, False)


def _copy(backend: Backend, job: str, production: ProductionOptions, names: Sequence[str] = ()) -> list[Path]:
    with writing(production.out):
        return backend.export_files(job, production.out.absolute(), names)


def _print_paths(job: str, paths: list[Path], as_json: bool) -> None:
    from .terminal import print_json

    for path in paths:
        if as_json:
            print_json({"job": job, "name": path.name, "path": str(path)})
        else:
            click.echo(str(path))
