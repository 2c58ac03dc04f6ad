"""The thread beside a running job: it renews the job's lease and detects that the job must stop."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from types import FrameType
from typing import Any

from ..core.run.errors import GarmentqError
from ..service.database import Database
from ..service.jobs import Claim, HeartbeatResult, read_flags, renew

BEATS_PER_LEASE = 4
"""Number of heartbeats in one lease: three may fail before another worker takes over."""


INTERRUPT_SHARE = 0.5
"""Share of the time to stop after which a job's code is interrupted; the rest is for code that no signal reaches."""


IMPORT_SYSTEM_FILE = "<frozen importlib"
"""Beginning of the file names of Python's import system in frames."""

CHECKPOINT_WAIT_SECONDS = 6.0
"""Longest wait of a preempted job for its next checkpoint [s]; then it stops between two iterations, and loses what it
has computed since the last one."""


ITERATION_WAIT_SECONDS = 3.0
"""Longest wait of a preempted job for the end of an iteration, after that for a checkpoint [s]; then it is interrupted:
an iteration of the fit takes up to 20 s of CPU."""


class JobInterrupted(BaseException):
    """The code of a job that must stop did not notice; no handler of errors is to catch it."""


class JobTooLong(GarmentqError):
    """The job took longer than GARMENTQ_MAX_SECONDS; use fewer --vertices, or raise the limit."""

    code = "job.too_long"


def _do_nothing(reason: str) -> None:
    """Do nothing."""


class LeaseKeeper:
    """Renew a claim's lease in a background thread, and interrupt a job that must stop and does not.

    Python code of the main thread is interrupted by a signal: `JobInterrupted` is raised in it, and its process goes on
    with other jobs. What runs in compiled code for longer is ended with its process.

    Attributes:
        reason: Empty while the job may continue, or is only preempted; else `lost`, `cancelled`, `released` or
            `too_long`.
        database: The job's database.
    """

    def __init__(
        self,
        database: Database,
        claim: Claim,
        lease_seconds: float,
        poll_seconds: float,
        max_seconds: float,
        is_draining: Callable[[], bool],
        grace_seconds: float = 10.0,
        force: Callable[[str], None] = _do_nothing,
    ) -> None:
        """Prepare the thread; `with` runs it.

        Args:
            database: The job's database.
            claim: The claim that is renewed.
            lease_seconds: Duration of a lease [s].
            poll_seconds: Interval of the checks whether the job was cancelled [s].
            max_seconds: Longest time of the attempt [s].
            is_draining: Returns whether the worker must stop.
            grace_seconds: Time that the job has to stop [s].
            force: Called with the reason if the job has not stopped after `grace_seconds`.
        """
        self.reason = ""
        self.database = database
        self._claim = claim
        self._lease = lease_seconds
        self._poll = min(poll_seconds, lease_seconds / BEATS_PER_LEASE)
        self._max = max_seconds
        self._is_draining = is_draining
        self._grace = grace_seconds
        self._force = force
        self._ended = threading.Event()
        self._job_thread = 0
        self._handler: Any = None
        self._is_interrupted = False
        self._preempted: float | None = None
        self._gives_way = False
        self._is_computed = False
        self._thread = threading.Thread(target=self._run, name=f"watch-{claim.job}", daemon=True)

    def __enter__(self) -> LeaseKeeper:
        """Start the thread."""
        self._job_thread = threading.get_ident()
        if threading.current_thread() is threading.main_thread():
            self._handler = signal.signal(signal.SIGUSR2, self._interrupt)
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Stop the thread."""
        self._ended.set()
        self._thread.join()
        if self._handler is not None:
            signal.signal(signal.SIGUSR2, self._handler)

    def end(self) -> None:
        """Neither renew the lease nor interrupt the job from now on: it has stopped, and its end is being written."""
        self._ended.set()

    def must_stop(self) -> bool:
        """Return whether the job must stop; `reason` says why, and is empty if the job is preempted."""
        return bool(self.reason) or self._gives_way

    def note_computed(self) -> None:
        """Let the job no longer give way: its result is being stored."""
        self._is_computed = True

    def note_checkpoint(self) -> None:
        """Let a preempted job stop now, right after a checkpoint."""
        if self._preempted is not None:
            self._gives_way = True

    def _run(self) -> None:
        started = renewed = time.monotonic()
        while not self._ended.wait(self._poll):
            now = time.monotonic()
            is_due = now - renewed >= self._lease / BEATS_PER_LEASE
            try:
                pulse = (
                    renew(self.database, self._claim, self._lease) if is_due else read_flags(self.database, self._claim)
                )
            except GarmentqError:  # the database is unavailable; the fence will show whose the job is
                pulse = HeartbeatResult(is_owner=True, is_cancelled=False)
            else:
                renewed = now if is_due else renewed
                self._note_preemption(pulse.is_preempted, now)
            self.reason = self._judge(pulse, now - started)
            if self.reason:
                self._keep_alive()
                return

    def _note_preemption(self, is_preempted: bool, now: float) -> None:
        """Note since when the job is to give way; a job that has begun to stop goes on doing so."""
        if not is_preempted:
            self._preempted = None
        elif self._preempted is None:
            self._preempted = now
        elif now - self._preempted > CHECKPOINT_WAIT_SECONDS and not self._is_computed:
            self._gives_way = True
            if self._handler is not None and now - self._preempted > CHECKPOINT_WAIT_SECONDS + ITERATION_WAIT_SECONDS:
                signal.pthread_kill(self._job_thread, signal.SIGUSR2)

    def _judge(self, pulse: HeartbeatResult, seconds: float) -> str:
        if not pulse.is_owner:
            return "lost"
        if pulse.is_cancelled:
            return "cancelled"
        if self._is_draining():
            return "released"
        return "too_long" if seconds > self._max else ""

    def _keep_alive(self) -> None:
        """Continue to renew the lease while the stage stops; interrupt it, then call `force`, if it does not."""
        begun = time.monotonic()
        while (seconds := time.monotonic() - begun) < self._grace:
            if self._ended.wait(min(self._poll, self._grace - seconds)):
                return
            if self._handler is not None and time.monotonic() - begun >= INTERRUPT_SHARE * self._grace:
                signal.pthread_kill(self._job_thread, signal.SIGUSR2)
            if self.reason != "lost":
                with suppress(GarmentqError):
                    renew(self.database, self._claim, self._lease)
        self._force(self.reason)

    def _interrupt(self, number: int, frame: FrameType | None) -> None:
        """Raise `JobInterrupted` in the job's code once, unless it has stopped, or imports a module.

        A module that is imported in part would fail the next job of the process; the signal comes again.
        """
        while frame is not None and not frame.f_code.co_filename.startswith(IMPORT_SYSTEM_FILE):
            frame = frame.f_back
        may = not self._ended.is_set() and bool(self.reason or not self._is_computed)
        if frame is None and may and not self._is_interrupted:
            self._is_interrupted = True
            raise JobInterrupted(self.reason)
