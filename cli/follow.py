"""Wait for jobs and show their progress, from the events in the database."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from ..core.recover.recovery import STAGES
from ..core.run.errors import keep_printable
from ..service.backend import Backend
from ..service.records import Event, JobReport
from ..service.records import Progress as JobProgress
from .family import FamilyEvents
from .terminal import print_note, show_duration

if TYPE_CHECKING:
    from rich.progress import TaskID

MAX_EVENT_SILENCE = 5.0
"""Time without an event after which a job may lack its broker or worker [s]: a running stage reports twice a second."""


WHOLE = ""
"""Stands for the whole job among the stages."""


class WaitTimedOut(Exception):
    """The job had not ended within the time limit."""


@dataclass(frozen=True)
class Wait:
    """Describe how to wait for a job's end.

    Attributes:
        timeout: Longest wait [s], or None.
        as_json: Show nothing meanwhile, so that only data is printed.
        keep_up: Called every few seconds while the job has no events.
        is_lenient: A result that fails a check has the exit status of one that passes.
        with_redrapes: Wait for re-drapes that results were handed out before.
    """

    timeout: float | None = None
    as_json: bool = False
    keep_up: Callable[[], None] | None = None
    is_lenient: bool = False
    with_redrapes: bool = True


def follow(backend: Backend, job: str, wait: Wait) -> list[JobReport]:
    """Wait until a job and all below it have ended, with a bar per stage on a terminal and a line per stage elsewhere.

    Returns:
        The job, then all below it, each parent before its children.

    Raises:
        WaitTimedOut: if `wait.timeout` passed first.
    """
    deadline = None if wait.timeout is None else time.monotonic() + wait.timeout
    family, last_event = FamilyEvents(backend, job, False, wait.with_redrapes), time.monotonic()
    with _choose_display(wait.as_json) as display:
        while True:
            for event in family.poll():
                last_event = time.monotonic()
                display.show(event, family.names[event.job])
            if family.has_ended:
                return family.reports
            if deadline is not None and time.monotonic() > deadline:
                raise WaitTimedOut()
            if wait.keep_up is not None and time.monotonic() - last_event > MAX_EVENT_SILENCE:
                wait.keep_up()
                last_event = time.monotonic()
            time.sleep(backend.poll_seconds)


class Display(Protocol):
    """Show the events of a job and of those below it."""

    def show(self, event: Event, name: str) -> None:
        """Show one event; `name` is that of a job below, empty for the job itself."""


def _choose_display(is_quiet: bool) -> AbstractContextManager[Display]:
    if is_quiet:
        return nullcontext(_Silence())
    return Bars() if sys.stderr.isatty() else nullcontext(Lines())


class _Silence:
    def show(self, event: Event, name: str) -> None:
        """Show nothing."""


class Lines:
    """Write one line when a stage begins and one for each other event."""

    def __init__(self) -> None:
        """Begin without a stage."""
        self.stages: dict[str, str] = {}

    def show(self, event: Event, name: str) -> None:
        """Write the event if it is new."""
        progress = event.progress
        if progress is None:
            print_note(_label(name, _describe_event(event)))
        elif progress.stage != self.stages.get(event.job):
            self.stages[event.job] = progress.stage
            print_note(f"  {_label(name, progress.stage)} ...{_describe_overall(progress)}")


class Bars:
    """Draw a bar for each stage of each job on the terminal."""

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
        self.tasks: dict[tuple[str, str], TaskID] = {}

    def __enter__(self) -> Bars:
        """Start drawing."""
        self.progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Stop drawing; the last picture stays on the screen."""
        self.progress.stop()

    def show(self, event: Event, name: str) -> None:
        """Draw the event."""
        progress = event.progress
        if progress is None:
            if event.kind not in ("queued", "started", "succeeded"):
                self.progress.console.print(keep_printable(_label(name, _describe_event(event))), markup=False)
            if event.kind == "succeeded" and (event.job, WHOLE) in self.tasks:
                self.progress.update(self.tasks[event.job, WHOLE], completed=1.0, message="")
            return
        if progress.overall is not None:
            self._draw_whole(event.job, name, progress.overall, progress.left_seconds)
        task = (event.job, progress.stage)
        if task not in self.tasks:
            self._finish_before(*task)
            shown = keep_printable(_label(name, progress.stage))
            self.tasks[task] = self.progress.add_task(shown, total=1.0, message="")
        self.progress.update(self.tasks[task], completed=progress.fraction, message=keep_printable(progress.message))

    def _draw_whole(self, job: str, name: str, share: float, left: float | None) -> None:
        """Draw the overall progress of a job, above its stages."""
        if (job, WHOLE) not in self.tasks:
            self.tasks[job, WHOLE] = self.progress.add_task(keep_printable(_label(name, "all")), total=1.0, message="")
        message = "" if left is None else f"{show_duration(left)} to go"
        self.progress.update(self.tasks[job, WHOLE], completed=share, message=message)

    def _finish_before(self, job: str, stage: str) -> None:
        order = STAGES.index(stage) if stage in STAGES else len(STAGES)
        for (other, name), task in self.tasks.items():
            if other == job and name != WHOLE and (name not in STAGES or STAGES.index(name) < order):
                self.progress.update(task, completed=1.0)
                self.progress.stop_task(task)


def _describe_overall(progress: JobProgress) -> str:
    """Return the overall progress, to follow the name of a stage that begins."""
    if progress.overall is None:
        return ""
    left = "" if progress.left_seconds is None else f", {show_duration(progress.left_seconds)} to go"
    return f" {round(100 * progress.overall)} % of all{left}"


def _describe_event(event: Event) -> str:
    """Return the event's kind, and its doubts about files."""
    doubts = " ".join(event.data.get("doubts", []))
    return f"{event.kind}: {doubts}" if doubts else event.kind


def _label(name: str, text: str) -> str:
    return f"{name}: {text}" if name else text
