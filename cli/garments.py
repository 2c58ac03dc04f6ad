"""Wait for the garments of segmented persons."""

from __future__ import annotations

from collections.abc import Sequence

from ..service.backend import Backend
from ..service.order import PERSON
from ..service.records import JobReport
from ..service.states import ENDED, State
from .terminal import print_note


def wait_garments(backend: Backend, family: Sequence[JobReport], timeout: float | None) -> list[JobReport]:
    """Return a family after the garments of a person in it have ended.

    It is returned at once if its first job is not a segmented person, if no worker runs, or when the time is over.

    Args:
        backend: The jobs' backend.
        family: A job, then all below it.
        timeout: Longest wait [s], or None.
    """
    from .follow import Wait, WaitTimedOut, follow

    person = family[0]
    is_apart = person.kind == PERSON and person.state == State.SUCCEEDED
    if not is_apart or all(job.state in ENDED for job in family):
        return list(family)
    if not backend.read_queue().workers:
        print_note("no worker is up, so the command does not wait; `garmentq up` starts one.")
        return list(family)
    try:
        return follow(backend, person.id, Wait(timeout, as_json=True, with_redrapes=False))
    except WaitTimedOut:
        return list(family)
