"""Output of the commands: data on standard output, everything else on standard error."""

from __future__ import annotations

import csv
import io
import json
import logging
import math
import time
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import click

from ..core.run.errors import keep_printable

if TYPE_CHECKING:
    from ..service.records import Job


log = logging.getLogger(__name__)


def print_json(value: Any) -> None:
    """Print one object on one line."""
    click.echo(json.dumps(value, allow_nan=False))


def print_note(text: str) -> None:
    """Print a note on standard error, without control characters; log it where every line has to be JSON."""
    from ..service.logs import is_log_json

    if is_log_json():
        log.info("%s", text)
    else:
        click.echo(keep_printable(text), err=True)


def print_error(code: str, message: str) -> None:
    """Print an error as one line, without control characters; log it where every line has to be JSON."""
    from ..service.logs import is_log_json

    if is_log_json():
        log.error("%s: %s", code, message)
    else:
        click.echo(keep_printable(f"error {code}: {message}"), err=True)


def print_table(columns: Sequence[str], rows: Iterable[Sequence[object]], title: str | None = None) -> None:
    """Print a table; numbers right-aligned, nothing truncated, plain text if the output is not a terminal."""
    from rich import box
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    rows = [list(row) for row in rows]
    shown = None if title is None else Text(keep_printable(title))
    table = Table(title=shown, box=box.SIMPLE_HEAD, title_justify="left", title_style="bold")
    for index, name in enumerate(columns):
        is_number = bool(rows) and all(isinstance(row[index], int | float) or row[index] is None for row in rows)
        table.add_column(Text(keep_printable(name)), justify="right" if is_number else "left", overflow="fold")
    for row in rows:
        table.add_row(*(Text(format_cell(cell)) for cell in row))
    Console(width=None if Console().is_terminal else 160).print(table)


def print_csv(columns: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Print a table as `format_csv` writes it."""
    click.echo(format_csv(columns, rows), nl=False)


def format_csv(columns: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return a table as CSV (RFC 4180); a text that a spreadsheet would run as a formula gets an apostrophe first."""
    out = io.StringIO()
    writer = csv.writer(out)
    writer.writerow([_escape_formula(name) for name in columns])
    writer.writerows([_escape_formula(cell) for cell in row] for row in rows)
    return out.getvalue()


FORMULA = ("=", "+", "-", "@", "|", "\uff1d", "\uff0b", "\uff0d", "\uff20")
"""Beginnings of a cell that a spreadsheet runs; the last four are the full-width forms of the first."""


def _escape_formula(cell: object) -> object:
    """Return a cell that no spreadsheet runs as a formula; numbers are not changed."""
    if not isinstance(cell, str):
        return cell
    text = keep_printable(cell)
    return f"'{text}" if text.lstrip().startswith(FORMULA) else text


def format_cell(cell: object) -> str:
    """Return a cell as text: 4 significant digits, `-` for an empty one, no control characters."""
    if cell is None or cell == "":
        return "-"
    if isinstance(cell, float):
        return f"{cell:.4g}"
    return keep_printable(str(cell))


def show_duration(seconds: float | None) -> str:
    """Return a remaining time as minutes and seconds, with hours if there are any."""
    if seconds is None or not math.isfinite(seconds):
        return "-"
    minutes, rest = divmod(max(0, round(seconds)), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"


def show_left(job: Job) -> str:
    """Return the remaining time of a running job, or the time until a queued one starts, if it is known."""
    start = getattr(job, "expected_start", None)
    if start is not None:
        return f"starts in {show_duration(start - time.time())}"
    return show_duration(None if job.expected_end is None else job.expected_end - time.time())


def show_time(seconds: float | None) -> str:
    """Return a time as local date and time."""
    return "-" if seconds is None else time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(seconds))
