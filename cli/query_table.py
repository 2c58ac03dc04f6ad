"""Jobs as a table for a spreadsheet: people's names, ISO times, and metrics by name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from datetime import datetime
from typing import TYPE_CHECKING

import click

from .export_folders import find_persons

if TYPE_CHECKING:
    from ..service.backend import Backend
    from ..service.records import JobReport

FIRST_COLUMNS = ("job", "person", "name", "garment", "state", "verdict", "error", "created", "finished")
"""Columns of a table if none are chosen."""

TIME_COLUMNS = ("created", "started", "finished")
"""Columns that are times."""

FIELD_COLUMNS = (
    "kind", "template", "fabric", "body", "tags", "family", "parent", "version", "attempts", "priority", "queue",
    "started", "cpu_seconds", "peak_mb",
)  # fmt: skip
"""Further fields of a job; every metric is one more column."""


def tabulate(backend: Backend, jobs: Sequence[JobReport], columns: str | None) -> tuple[list[str], list[list[object]]]:
    """Return columns and rows of jobs: the first columns, those chosen (separated by commas), or `all`.

    Raises:
        BadParameter: if there is no column of a name.
    """
    fields, metrics = (*FIRST_COLUMNS, *FIELD_COLUMNS), sorted({name for job in jobs for name in job.metrics})
    chosen = list(FIRST_COLUMNS)
    if columns == "all":
        chosen = [*fields, *metrics]
    elif columns is not None:
        chosen = [name.strip() for name in columns.split(",")]
        if jobs and (unknown := [name for name in chosen if name not in (*fields, *metrics)]):
            known = ", ".join((*fields, *metrics))
            raise click.BadParameter(f"there is no '{unknown[0][:60]}'; there are {known}.", param_hint="--columns")
    persons = find_persons(backend, jobs)
    return chosen, [[_find_cell(job, name, persons.__getitem__) for name in chosen] for job in jobs]


def _find_cell(job: JobReport, name: str, find_person: Callable[[str], str]) -> object:
    """Return the value of a column."""
    if name == "job":
        return job.id
    if name == "person":
        return find_person(job.id)
    if name == "error":
        return f"{job.error.code}: {job.error.message}" if job.error else None
    if name == "tags":
        return " ".join(job.tags)
    if name in TIME_COLUMNS:
        seconds = getattr(job, name)
        return None if seconds is None else datetime.fromtimestamp(seconds).astimezone().isoformat(timespec="seconds")
    return getattr(job, name) if name in (*FIRST_COLUMNS, *FIELD_COLUMNS) else job.metrics.get(name)
