"""Live tables on the terminal: jobs and workers, or the progress of a batch."""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING

import click

from ..service.backend import Backend
from ..service.records import Job
from ..service.states import ENDED, State
from .family import arrange, find_family, indent
from .follow import WaitTimedOut
from .terminal import format_cell, show_left, show_time

if TYPE_CHECKING:
    from rich.console import RenderableType

TABLE_REFRESH_INTERVAL = 0.5
"""Interval at which the tables are redrawn [s]."""

BATCH_ROWS = 12
"""Largest number of running jobs of a batch that are listed."""


def watch_queue(backend: Backend, job: str | None, limit: int) -> None:
    """Show jobs and workers until Ctrl-C, or once if the output is not a terminal."""
    from rich.console import Console
    from rich.live import Live

    def draw() -> RenderableType:
        return draw_queue(backend, find_family(backend, backend.find_job(job)) if job else backend.list_jobs(limit))

    console = Console()
    if not console.is_terminal:
        Console(width=160).print(draw())
        return
    try:
        with Live(draw(), console=console, auto_refresh=False) as live:
            while True:
                time.sleep(TABLE_REFRESH_INTERVAL)
                live.update(draw(), refresh=True)
    except KeyboardInterrupt:
        return


def draw_queue(backend: Backend, rows: Sequence[Job]) -> RenderableType:
    """Draw the counts by state, the workers, and some jobs."""
    from rich.console import Group
    from rich.text import Text

    queue = backend.read_queue()
    counts, living = queue.states, queue.workers
    title = "  ".join(f"{state} {counts[state]}" for state in sorted(counts)) or "no jobs"
    workers = [[row.name, row.queues, row.concurrency, show_time(row.started), show_time(row.seen)] for row in living]
    jobs = [
        [row.id, indent(depth, row.name), row.queue, row.priority, row.state, row.stage]
        + [round(100 * row.overall), show_left(row), row.attempts]
        for depth, row in arrange(rows)
    ]
    return Group(
        Text(title),
        _table(["worker", "queues", "slots", "since", "seen"], workers),
        _table(["job", "name", "queue", "priority", "state", "stage", "% of all", "to go", "attempt"], jobs),
    )


def follow_batch(backend: Backend, jobs: Sequence[str], timeout: float | None) -> list[Job]:
    """Wait until every job of a batch and all below them have ended, with one view of all of them.

    On a terminal one bar and the running jobs; elsewhere a line whenever another job has ended.

    Raises:
        WaitTimedOut: if `timeout` passed first.
    """
    from rich.console import Console
    from rich.live import Live

    deadline = None if timeout is None else time.monotonic() + timeout
    console = Console(stderr=True)
    ended = -1
    known: dict[str, Job] = {}
    with Live(console=console, auto_refresh=False, transient=not sys.stderr.isatty()) as live:
        while True:
            left = [job for job in dict.fromkeys([*jobs, *known]) if job not in known or known[job].state not in ENDED]
            known |= {row.id: row for row in backend.find_jobs_by_id(left, below=True)}
            rows = list(known.values())
            done = sum(row.state in ENDED for row in rows)
            if console.is_terminal:
                live.update(draw_batch(rows), refresh=True)
            elif done != ended:
                click.echo(f"{done} of {len(rows)} ended", err=True)
            ended = done
            if done == len(rows):
                return rows
            if deadline is not None and time.monotonic() > deadline:
                raise WaitTimedOut()
            time.sleep(TABLE_REFRESH_INTERVAL)


def draw_batch(rows: Sequence[Job]) -> RenderableType:
    """Draw one bar for a batch, the counts by state, and the running jobs."""
    from rich.console import Group
    from rich.progress_bar import ProgressBar
    from rich.text import Text

    total = sum(1.0 if row.state in ENDED else row.overall for row in rows)
    counts = Counter(row.state for row in rows)
    text = "  ".join(f"{state} {count}" for state, count in sorted(counts.items()))
    running = [
        [row.id, row.name, row.stage, round(100 * row.overall), show_left(row)]
        for row in rows if row.state == State.RUNNING
    ]  # fmt: skip
    bar = ProgressBar(total=max(1, len(rows)), completed=total, width=60)
    return Group(bar, Text(text), _table(["job", "name", "stage", "% of all", "to go"], running[:BATCH_ROWS]))


def _table(columns: Sequence[str], rows: Sequence[Sequence[object]]) -> RenderableType:
    from rich import box
    from rich.table import Table
    from rich.text import Text

    table = Table(box=box.SIMPLE_HEAD)
    for name in columns:
        table.add_column(name, overflow="fold")
    for row in rows:
        table.add_row(*(Text(format_cell(cell)) for cell in row))
    return table
