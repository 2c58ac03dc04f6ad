"""Families of jobs: display of children below their parent, and waiting for all jobs below a job."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TypeVar

from ..service.backend import Backend
from ..service.kinds.redrape_request import REDRAPE
from ..service.query import MAX_QUERY_ROWS, JobQuery
from ..service.records import Event, Job, JobReport
from ..service.states import ENDED, State
from .terminal import print_json, print_note

J = TypeVar("J", bound=Job)

QUEUE_EVENTS = ("queued", "resubmitted", "retried")
"""Events by which a user put a job into the queue."""


def arrange(jobs: Sequence[J]) -> list[tuple[int, J]]:
    """Return jobs with their depth, each parent before its children; a job whose parent is missing counts as a root.

    Roots keep their order, children are in order of creation.
    """
    known = {job.id for job in jobs}
    below: dict[str | None, list[J]] = {}
    for job in jobs:
        below.setdefault(job.parent if job.parent in known else None, []).append(job)

    def walk(parent: str | None, depth: int) -> Iterator[tuple[int, J]]:
        found = below.get(parent, [])
        for job in found if parent is None else sorted(found, key=lambda job: (job.created, job.id)):
            yield depth, job
            yield from walk(job.id, depth + 1)

    return list(walk(None, 0))


def indent(depth: int, name: str) -> str:
    """Return a job's name, indented by its depth in a table."""
    return f"{'  ' * depth}{name}"


def find_family(backend: Backend, job: JobReport) -> list[JobReport]:
    """Return a job and all below it, each parent before its children."""
    if not job.children:
        return [job]
    found = arrange(backend.find_jobs(JobQuery({"family": job.family}, sort="created", limit=MAX_QUERY_ROWS)))
    place = next((index for index, (_, one) in enumerate(found) if one.id == job.id), None)
    if place is None:  # more jobs than one query returns
        return [job]
    end = place + 1
    while end < len(found) and found[end][0] > found[place][0]:
        end += 1
    return [one for _, one in found[place:end]]


def drop_redrapes(family: Sequence[JobReport]) -> list[JobReport]:
    """Return a family without the re-drapes below its first job, which are parts of other jobs' results."""
    return [job for number, job in enumerate(family) if not number or job.kind != REDRAPE]


def change_families(
    backend: Backend, jobs: Sequence[str], change: Callable[[str], State], words: Mapping[State, str], as_json: bool
) -> None:
    """Change jobs given by their ids or beginnings of them, and show each with all below it.

    Args:
        backend: The jobs' backend.
        jobs: Ids as they were typed.
        change: Function that changes a job and returns its state after that.
        words: Text for a job in a state; by default "is STATE".
        as_json: Print an object for each job instead of a line.
    """
    for job in jobs:
        key = backend.find_job(job).id
        state = change(key)
        found = backend.find_jobs_by_id([key], below=True)
        for one in [replace(found[0], state=state), *found[1:]]:
            if as_json:
                print_json({"job": one.id, "state": one.state})
            else:
                print_note(f"job {one.id} {words.get(one.state, f'is {one.state}')}")


class FamilyEvents:
    """Poll the events of a job and of all below it, including those created meanwhile.

    Attributes:
        names: Names of the jobs below by id; that of the job itself is empty.
    """

    def __init__(self, backend: Backend, job: str, is_whole: bool = True, with_redrapes: bool = True) -> None:
        """Begin with one job; if not `is_whole`, with the events since it was last queued."""
        self._left_out = () if with_redrapes else (REDRAPE,)
        self.names: dict[str, str] = {job: ""}
        self._reports: dict[str, JobReport] = {}
        self._backend, self._is_whole = backend, is_whole
        self._seen: dict[str, int] = {}

    @property
    def reports(self) -> list[JobReport]:
        """Return the jobs that have ended, each parent before its children, with current states."""
        found = [self._reports[job] for job in self.names if job in self._reports]
        states = {job.id: job.state for job in found}
        return [
            replace(job, children=[replace(one, state=states.get(one.job, one.state)) for one in job.children])
            for job in found
        ]

    @property
    def has_ended(self) -> bool:
        """Return whether the job and all below it have ended."""
        return len(self._reports) == len(self.names)

    def poll(self) -> list[Event]:
        """Return the events since the last poll, in order."""
        events: list[Event] = []
        left = [job for job in self.names if job not in self._reports]
        for job in left:  # grows by the children of ended jobs
            latest = self._backend.poll_events(job, self._seen.get(job, 0))
            events += latest.events if self._is_whole or job in self._seen else _latest_run(latest.events)
            self._seen[job] = latest.events[-1].id if latest.events else self._seen.get(job, 0)
            if latest.state in ENDED:
                left += self._end(job)
        return sorted(events, key=lambda event: event.id)

    def _end(self, job: str) -> list[str]:
        """Record that a job has ended, and return its children."""
        found = self._reports[job] = self._backend.find_job(job)
        children = found.children if found.state == State.SUCCEEDED else []
        children = [child for child in children if child.kind not in self._left_out]
        self.names |= {child.job: child.name for child in children}
        return [child.job for child in children]


def _latest_run(events: list[Event]) -> list[Event]:
    """Return the events since a user last queued the job."""
    begins = [index for index, event in enumerate(events) if event.kind in QUEUE_EVENTS]
    return events[begins[-1] :] if begins else events
