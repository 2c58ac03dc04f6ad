"""Records of batches; see `records.py`."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

from .records import CLOSED, Failure, JobId, JsonRecord
from .states import OPEN, State


@dataclass(frozen=True)
class FamilyCount(JsonRecord):
    """Describe how many families have succeeded, have a job that failed, and have one that is open.

    A family with an open job counts as open, whatever else failed in it.
    """

    __pydantic_config__: ClassVar = CLOSED
    succeeded: int = 0
    failed: int = 0
    open: int = 0

    @property
    def total(self) -> int:
        """Return the number of families."""
        return self.succeeded + self.failed + self.open


@dataclass(frozen=True)
class Batch(JsonRecord):
    """Describe the jobs with a tag, with those below them.

    Attributes:
        tag: The tag.
        latest: When a job with it was last ordered [s since 1970].
        jobs: Number of its jobs.
        scans: Number of them that were ordered; all others were made by these.
        states: Number of jobs in each state that occurs.
        share: How much of it is done, 0..1; a running job counts by its progress.
        left_seconds: Estimated time until all have ended [s]; None if unknown, or without a worker.
        verdicts: Number of results by verdict.
        garments: Number of garments by category.
        cpu_seconds: CPU time of all results [s].
        families: Number of its families; None from a service of an earlier version.
    """

    __pydantic_config__: ClassVar = CLOSED
    tag: str
    latest: float
    jobs: int
    scans: int
    states: dict[State, int]
    share: float
    left_seconds: float | None
    verdicts: dict[str, int]
    garments: dict[str, int]
    cpu_seconds: float
    families: FamilyCount | None = None

    @property
    def open_jobs(self) -> int:
        """Return the number of jobs that have not ended."""
        return sum(self.states.get(state, 0) for state in OPEN)


@dataclass(frozen=True)
class BatchFailure(JsonRecord):
    """Describe a job of a batch that failed, and why."""

    __pydantic_config__: ClassVar = CLOSED
    job: JobId
    family: JobId
    name: str
    kind: str
    state: State
    error: Failure | None


@dataclass(frozen=True, kw_only=True)
class BatchReport(Batch):
    """Describe a batch with its failures, the newest first, at most `MAX_BATCH_FAILURES`."""

    __pydantic_config__: ClassVar = CLOSED
    failures: tuple[BatchFailure, ...] = field(default_factory=tuple)
