"""`garmentq match`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from .options import home_option, json_option

if TYPE_CHECKING:
    from ..service.backend import Backend


@click.command("match")
@click.argument("first")
@click.argument("second")
@click.option(
    "--pairs",
    type=click.Path(path_type=Path),
    help='Pairs of panels: JSON {"of FIRST": "of SECOND", ...}, or CSV with two names a line.',
)
@click.option("--csv", "as_csv", is_flag=True, help="Print the pairs as CSV.")
@home_option
@json_option
def command(first: str, second: str, pairs: Path | None, as_csv: bool, home: Path | None, as_json: bool) -> None:
    """Compare two patterns panel by panel.

    Each is a pattern file, a job, or a template's name. Panels are paired as --pairs says, then by name, then by shape;
    each pair shows the turning distance (0 for similar shapes), how much larger the first is, and the RMS distance of
    their outlines.

    \b
    Example:
      garmentq match 3685ecfd4f81 truth.json
      garmentq match tshirt mine.json --pairs pairs.csv --csv > differences.csv
    """
    import tempfile

    from ..core.run.errors import keep_printable
    from ..service.backend import open_backend
    from ..service.matching import match_files, read_pairs
    from ..service.settings import read_settings
    from .terminal import print_csv, print_json, print_table

    named_pairs = read_pairs(pairs) if pairs else {}
    backend = open_backend(read_settings(home=home))
    with tempfile.TemporaryDirectory() as folder:
        files = [_find_file(backend, word, Path(folder) / str(at)) for at, word in enumerate((first, second))]
        found = match_files(files[0], files[1], named_pairs)
    heads = ["first", "second", "paired by", "turning rad", "area %", "outline mm"]
    rows = [list(pair.values())[: len(heads)] for pair in found["pairs"]]
    if as_json:
        print_json(found)
    elif as_csv:
        print_csv(heads, rows)
    else:
        print_table(heads, rows)
        for name, word in (("only_first", first), ("only_second", second)):
            if found[name]:
                click.echo(f"only in {keep_printable(word)}: {keep_printable(', '.join(found[name]))}")


def _find_file(backend: Backend, word: str, folder: Path) -> Path:
    """Return the pattern file for a word: a file, else a job's pattern, else a template."""
    from ..service.jobs import JobUnknown

    if Path(word).is_file():
        return Path(word)
    folder.mkdir()
    try:
        return backend.export_files(backend.find_job(word).id, folder, ["pattern.json"])[0]
    except JobUnknown:
        path = folder / "template.json"
        path.write_bytes(backend.read_template(word))
        return path
