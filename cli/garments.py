"""Wait for the garments of persons that were taken apart."""

from __future__ import annotations

from collections.abc import Sequence

from ..service.backend import Backend
from ..service.order import PERSON
from ..service.records import JobReport
from ..service.states import ENDED, State
from .terminal import print_note


def wait_garments(backend: Backend, family: Sequence[JobReport], timeout: float | None) -> list[JobReport]:
    """Return a family once the garments of a person in it have ended.

    It is returned as it is where its first job is no person that was taken apart, where no worker is up, or where the
    time is over.

    Args:
        backend: Where the jobs are.
        family: A job, then all below it.
        timeout: Seconds at most, or None.
    """
    from .follow import Wait, WaitTimedOut, follow

    person = family[0]
    is_apart = person.kind == PERSON and person.state == State.SUCCEEDED
    if not is_apart or all(job.state in ENDED for job in family):
        return list(family)
    if not backend.read_queue().workers:
        print_note("no worker is up, so nothing is waited for; `garmentq up` starts one.")
        return list(family)
    try:
        return follow(backend, person.id, Wait(timeout, as_json=True))
    except WaitTimedOut:
        return list(family)
