"""The states of a job and the moves between them; light, so that a command's help can name them."""

from __future__ import annotations

from enum import StrEnum


class State(StrEnum):
    """Name where a job stands."""

    WAITING = "waiting"  # for siblings: queued once all that it awaits have succeeded
    QUEUED = "queued"  # any worker of its queue may claim it
    RUNNING = "running"  # a worker holds a lease on it
    SUCCEEDED = "succeeded"  # its result is stored; final
    FAILED = "failed"  # ended with an error of its own, or of a job that it waited for
    DEAD = "dead"  # its worker was lost in every attempt
    CANCELLED = "cancelled"  # somebody asked for it


TRANSITIONS: dict[State, frozenset[State]] = {
    State.WAITING: frozenset({State.QUEUED, State.FAILED, State.CANCELLED}),
    State.QUEUED: frozenset({State.RUNNING, State.CANCELLED}),
    State.RUNNING: frozenset({State.QUEUED, State.SUCCEEDED, State.FAILED, State.DEAD, State.CANCELLED}),
    State.SUCCEEDED: frozenset(),
    State.FAILED: frozenset({State.QUEUED, State.WAITING}),
    State.DEAD: frozenset({State.QUEUED, State.WAITING}),
    State.CANCELLED: frozenset({State.QUEUED, State.WAITING}),
}
"""Where a job may go from each state; `jobs.move` refuses every other move."""

OPEN = frozenset({State.WAITING, State.QUEUED, State.RUNNING})
"""States of a job that counts against its key's quota, and that keeps a worker from going home."""

UNSUCCESSFUL = frozenset({State.FAILED, State.DEAD, State.CANCELLED})
"""States that only a retry leaves."""

ENDED = UNSUCCESSFUL | {State.SUCCEEDED}
"""States that a job does not leave by itself."""

QUEUES = ("cpu", "gpu")
"""Kinds of workers; a worker serves one or both, a job waits for one."""
