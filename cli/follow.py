"""Wait for jobs and show how far they are, from the events in the database."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from typing import Any, cast

from ..core.recovery import STAGES
from ..service.anywhere import ENDED, Place, find_job, is_remote, look
from ..service.models import EventRow, JobRow
from .terminal import note, plain

PERIOD_SECONDS = 0.2
"""How often the database is asked [s]; a person sees no difference below."""

REMOTE_SECONDS = 0.5
"""How often a service is asked [s]; progress is written twice a second."""


SILENT_SECONDS = 5.0
"""A job without an event for so long [s] may lack its broker or worker: a working stage reports twice a second."""


class WaitTimedOut(Exception):
    """The job had not ended when the time was over."""


def follow(
    database: Place,
    job: str,
    timeout: float | None,
    is_quiet: bool,
    keep_up: Callable[[], None] | None = None,
) -> JobRow:
    """Wait until a job has ended, with a bar per stage on a terminal and a line per stage elsewhere.

    Args:
        database: Where the job is.
        job: Its id.
        timeout: Seconds to wait at most, or None.
        is_quiet: Show nothing.
        keep_up: Called every few seconds while nothing happens to the job.

    Raises:
        WaitTimedOut: where `timeout` seconds went by first.
    """
    deadline = None if timeout is None else time.monotonic() + timeout
    seen, heard = 0, time.monotonic()
    with _choose_display(is_quiet) as display:
        while True:
            state, events = look(database, job, seen)
            for event in _latest_run(events) if not seen else events:
                seen, heard = event.id, time.monotonic()
                display.show(event)
            if state in ENDED:
                return cast(JobRow, find_job(database, job))
            if deadline is not None and time.monotonic() > deadline:
                raise WaitTimedOut()
            if keep_up is not None and time.monotonic() - heard > SILENT_SECONDS:
                keep_up()
                heard = time.monotonic()
            time.sleep(REMOTE_SECONDS if is_remote() else PERIOD_SECONDS)


def _latest_run(events: list[EventRow]) -> list[EventRow]:
    """Give the events since the job was last put into the queue by a person."""
    begins = [index for index, event in enumerate(events) if event.kind in ("queued", "resubmitted", "retried")]
    return events[begins[-1] :] if begins else events


def _choose_display(is_quiet: bool) -> AbstractContextManager[Any]:
    if is_quiet:
        return nullcontext(_Silence())
    return Bars() if sys.stderr.isatty() else nullcontext(Lines())


class _Silence:
    def show(self, event: EventRow) -> None:
        """Show nothing."""


class Lines:
    """Write one line when a stage begins and one for each thing that happens to the job."""

    def __init__(self) -> None:
        """Begin with no stage."""
        self.stage = ""

    def show(self, event: EventRow) -> None:
        """Write what is new."""
        if event.kind != "progress":
            note(event.kind)
        elif event.data["stage"] != self.stage:
            self.stage = event.data["stage"]
            note(f"  {self.stage} ...")


class Bars:
    """Draw a bar for each stage on the terminal."""

    def __init__(self) -> None:
        """Prepare the bars."""
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

        self.progress = Progress(
            TextColumn("{task.description:9}", markup=False),
            BarColumn(),
            TextColumn("{task.percentage:3.0f}%"),
            TimeElapsedColumn(),
            TextColumn("{task.fields[message]}", markup=False),
            console=Console(stderr=True),
        )
        self.tasks: dict[str, Any] = {}

    def __enter__(self) -> Bars:
        """Begin to draw."""
        self.progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Leave the last picture on the screen."""
        self.progress.stop()

    def show(self, event: EventRow) -> None:
        """Draw what is new."""
        if event.kind != "progress":
            if event.kind not in ("queued", "started", "succeeded"):
                self.progress.console.print(plain(event.kind), markup=False)
            return
        stage = plain(event.data["stage"])
        if stage not in self.tasks:
            self._finish_before(stage)
            self.tasks[stage] = self.progress.add_task(stage, total=1.0, message="")
        message = plain(event.data["message"])
        self.progress.update(self.tasks[stage], completed=event.data["fraction"], message=message)

    def _finish_before(self, stage: str) -> None:
        order = STAGES.index(stage) if stage in STAGES else len(STAGES)
        for name, task in self.tasks.items():
            if name not in STAGES or STAGES.index(name) < order:
                self.progress.update(task, completed=1.0)
                self.progress.stop_task(task)
