"""The states of a job and their transitions; the module is light, so that a command's help can import it."""

from __future__ import annotations

from enum import StrEnum


class State(StrEnum):
    """State of a job."""

    WAITING = "waiting"  # for siblings: queued once all of them have succeeded
    QUEUED = "queued"  # any worker of its queue may claim it
    RUNNING = "running"  # a worker has a lease on it
    SUCCEEDED = "succeeded"  # its result is stored; final
    FAILED = "failed"  # ended with an error of its own, or of a job that it waited for
    DEAD = "dead"  # its worker was lost in every attempt
    CANCELLED = "cancelled"  # by a user


TRANSITIONS: dict[State, frozenset[State]] = {
    State.WAITING: frozenset({State.QUEUED, State.FAILED, State.CANCELLED}),
    State.QUEUED: frozenset({State.RUNNING, State.CANCELLED}),
    State.RUNNING: frozenset({State.QUEUED, State.SUCCEEDED, State.FAILED, State.DEAD, State.CANCELLED}),
    State.SUCCEEDED: frozenset(),
    State.FAILED: frozenset({State.QUEUED, State.WAITING}),
    State.DEAD: frozenset({State.QUEUED, State.WAITING}),
    State.CANCELLED: frozenset({State.QUEUED, State.WAITING}),
}
"""The states that may follow each state; `jobs.change_state` refuses every other change."""

OPEN = frozenset({State.WAITING, State.QUEUED, State.RUNNING})
"""States of a job that counts against its key's quota, and during which an embedded worker does not stop."""

UNSUCCESSFUL = frozenset({State.FAILED, State.DEAD, State.CANCELLED})
"""States that only a retry leaves."""

ENDED = UNSUCCESSFUL | {State.SUCCEEDED}
"""States that a job does not leave by itself."""

QUEUES = ("cpu", "gpu")
"""Queues of jobs; a worker serves one or both, a job is in one."""
