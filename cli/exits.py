"""Exit statuses: what a script learns from a command without reading its words."""

from __future__ import annotations

from ..core.errors import BadInput, Cancelled, GarmentqError, NotFound
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
DETACHED = 130

USAGE_CODES = (
    "query.bad",
    "settings.bad",
    "service.setting_bad",
    "template.name_bad",
    "fabric.shipped",
    "command.local_only",
)
"""Errors in what was typed, not in a file."""


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
    return UNREACHABLE if error.code.startswith("service.") else FAULT


def job_status(job: Job) -> int:
    """Return the exit status of an ended job."""
    if job.state == State.FAILED:
        return BAD_INPUT if job.bad_input else FAILED
    return {State.SUCCEEDED: OK, State.DEAD: DEAD, State.CANCELLED: CANCELLED}[job.state]
