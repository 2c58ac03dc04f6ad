"""Exit statuses, by which a script reads the outcome of a command."""

from __future__ import annotations

from collections.abc import Iterable

from ..core.run.errors import BadInput, Cancelled, GarmentqError, NotFound, Unavailable
from ..core.run.verdict import Verdict
from ..service.records import Job
from ..service.states import State

OK = 0
FAULT = 1
USAGE = 2
NOT_FOUND = 3
BAD_INPUT = 4
FAILED = 5
DEAD = 6
CANCELLED = 7
TIMED_OUT = 8
UNREACHABLE = 9
FAILED_CHECK = 10
INCOMPLETE = 11
DETACHED = 130

SEVERITY = (
    OK, FAILED_CHECK, INCOMPLETE, FAULT, USAGE, NOT_FOUND, BAD_INPUT, FAILED, DEAD, CANCELLED, TIMED_OUT, UNREACHABLE,
    DETACHED,
)  # fmt: skip
"""Every status, the least severe first: of several jobs the most severe counts. A result that fails a check is less
severe than any job without one."""

USAGE_CODES = (
    "query.bad",
    "settings.bad",
    "service.setting_bad",
    "template.name_bad",
    "template.shipped",
    "fabric.shipped",
    "command.local_only",
    "command.unconfirmed",
    "serve.host_bad",
    "output.unwritable",
)
"""Codes of errors in the command line, not in a file."""


def error_status(error: GarmentqError) -> int:
    """Return the exit status of an error."""
    if error.code in USAGE_CODES:
        return USAGE
    if isinstance(error, NotFound):
        return NOT_FOUND
    if isinstance(error, BadInput):
        return BAD_INPUT
    if isinstance(error, Cancelled):
        return CANCELLED
    is_away = isinstance(error, Unavailable) or error.code.startswith("service.")
    return UNREACHABLE if is_away else FAULT


def job_status(job: Job, is_lenient: bool = False) -> int:
    """Return the exit status of an ended job; if `is_lenient`, a result that fails a check counts as any other."""
    if job.state == State.FAILED:
        return BAD_INPUT if job.bad_input else FAILED
    if job.state == State.SUCCEEDED:
        return FAILED_CHECK if job.verdict == Verdict.FAIL and not is_lenient else OK
    return {State.DEAD: DEAD, State.CANCELLED: CANCELLED}[job.state]


def worst(statuses: Iterable[int]) -> int:
    """Return the most severe of some exit statuses by `SEVERITY`; `OK` if there is none."""
    return max(statuses, key=SEVERITY.index, default=OK)
