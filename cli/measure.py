"""`garmentq measure`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..core.body.spec import is_builtin
from ..core.run.units import UNITS
from .options import AXES, home_option, json_option
from .output import NewFolder, writing

if TYPE_CHECKING:
    from ..core.body.body import Body
    from ..core.garment.pattern import Pattern


@click.command("measure")
@click.argument("source")
@click.option("--units", type=click.Choice(tuple(UNITS)), help="Unit of a body's file.  [default: detected]")
@click.option("--up", type=click.Choice(AXES[:2]), help="Up axis of a body's file.  [default: detected]")
@click.option("--out", "-o", type=NewFolder(), help="Also write them and how they are taken: a table, and figures.")
@click.option("--csv", "as_csv", is_flag=True, help="Print the measures as CSV.")
@home_option
@json_option
def command(
    source: str, units: str | None, up: str | None, out: Path | None, as_csv: bool, home: Path | None, as_json: bool
) -> None:
    """Measure a body, a pattern, or a job's garment and wearer.

    SOURCE is a body's file, builtin:female,height=1.70, a pattern's JSON file, or a job. Of a body 26 measures are
    taken, of a garment those at the points of the trade, flat and without allowance. With --out the folder gets
    measures.csv, and body.svg and garment.svg that show where.

    \b
    Example:
      garmentq measure body.ply --out measures
      garmentq measure builtin:female,height=1.70 --csv
      garmentq measure 3685ecfd4f81 --json
    """
    from .terminal import format_csv, print_csv, print_json, print_table

    found = _find_source(source, units, up, home)
    rows = [*_body_rows(found, out), *_garment_rows(found, out)]
    heads = ["of", "measure", "value", "unit", "how it is taken"]
    _write(out, "measures.csv", lambda: format_csv(heads, rows))
    if as_json:
        for row in rows:
            print_json(dict(zip(("of", "measure", "value", "unit", "how"), row, strict=True)))
    elif as_csv:
        print_csv(heads, rows)
    else:
        print_table(heads, rows)


@dataclass(frozen=True)
class _Source:
    """Describe what is measured: a body, a garment's pattern, or both."""

    body: Body | None = None
    pattern: Pattern | None = None


def _find_source(source: str, units: str | None, up: str | None, home: Path | None) -> _Source:
    """Return what a word means: a built-in body, a file, else a job.

    Raises:
        BadInput: if the file cannot be read.
        JobUnknown: if there is no such job.
    """
    from ..core.body.builtin import builtin_body
    from ..core.body.models.anny_file import is_anny_file
    from ..core.garment.garmentcode import load_pattern
    from ..core.reuse.wear.bodies import find_file_body, read_body_file

    if is_builtin(source):
        return _Source(builtin_body(source))
    path = Path(source)
    if not path.is_file():
        return _read_job(source, home)
    if path.suffix.lower() == ".json" and not is_anny_file(path):
        return _Source(pattern=load_pattern(path))
    return _Source(find_file_body(read_body_file(path, units, up)))


def _read_job(word: str, home: Path | None) -> _Source:
    """Return the garment and the wearer of a job's result."""
    import tempfile

    from ..core.garment.contour_edges import name_open_edges
    from ..core.reuse.wear.worn import WORN_FILE_NAME, load_worn
    from ..service.backend import open_backend
    from ..service.settings import read_settings

    backend = open_backend(read_settings(home=home))
    with tempfile.TemporaryDirectory() as folder:
        backend.export_files(backend.find_job(word).id, Path(folder), [WORN_FILE_NAME])
        worn = load_worn(Path(folder))
    return _Source(worn.body, name_open_edges(worn.garment))


def _write(folder: Path | None, name: str, text: Callable[[], str]) -> None:
    """Write a text to a file of a folder, if there is one."""
    if folder is not None:
        with writing(folder):
            folder.mkdir(parents=True, exist_ok=True)
            (folder / name).write_text(text(), encoding="utf-8")


def _body_rows(found: _Source, out: Path | None) -> list[list[object]]:
    """Return a row for each measure of the body, and draw them."""
    if found.body is None:
        return []
    import math

    from ..core.body.body_tape import measure_body
    from ..core.deliver.export.measure_figures import body_figure_svg

    taken = measure_body(found.body)
    _write(out, "body.svg", lambda: body_figure_svg(taken))
    rows: list[list[object]] = []
    for one in taken.measures:
        value = math.degrees(one.value) if one.is_angle else 100.0 * one.value
        number = round(value, 1) if math.isfinite(value) else None
        rows.append(["body", one.name, number, "degrees" if one.is_angle else "cm", one.how])
    return rows


def _garment_rows(found: _Source, out: Path | None) -> list[list[object]]:
    """Return a row for each finished measure of the garment, and draw them."""
    if found.pattern is None:
        return []
    from ..core.deliver.export.measure_figures import garment_figure_svg
    from ..core.garment.pieces.finished_measures import measure_finished
    from ..core.garment.pieces.trueing import true_pattern

    pattern = true_pattern(found.pattern).pattern  # as it is cut
    measures = measure_finished(pattern)
    _write(out, "garment.svg", lambda: garment_figure_svg(pattern, measures))
    return [["garment", str(one.point), round(100.0 * one.value, 1), "cm", one.how] for one in measures]
