"""Wait for the first stage of new jobs, which reads their files and refuses unusable ones."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..service.checking import STAGE
from ..service.states import State
from .terminal import print_note

if TYPE_CHECKING:
    from ..service.backend import Backend
    from ..service.records import Job

CHECK_SECONDS = 3.0
"""Longest wait of `submit` for the checks of all its files [s]; a pair of meshes takes 1 s on an idle core."""


def wait_checked(backend: Backend, jobs: Sequence[str], queue: str) -> list[Job]:
    """Wait until the files of all jobs are checked, at most `CHECK_SECONDS`, and not without a worker.

    Args:
        backend: The jobs' backend.
        jobs: Their ids.
        queue: Their queue.

    Returns:
        The jobs after the wait.
    """
    deadline = time.monotonic() + CHECK_SECONDS
    while True:
        found = backend.find_jobs_by_id(jobs)
        if not any(is_unchecked(job) for job in found):
            return found
        if not any(queue in worker.queues.split(",") for worker in backend.read_queue().workers):
            print_note("no worker is up, so the files are not checked yet; `garmentq up` starts one.")
            return found
        if time.monotonic() > deadline:
            print_note("not all files are checked yet; `garmentq status` shows the jobs.")
            return found
        time.sleep(backend.poll_seconds)


def is_unchecked(job: Job) -> bool:
    """Return whether a job's files have not been read yet."""
    return job.state in (State.WAITING, State.QUEUED) or (job.state == State.RUNNING and job.stage in ("", STAGE))
