"""The thread beside a running job: it renews the job's lease and detects that the job must stop."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import suppress

from ..core.run.errors import GarmentqError
from ..service.database import Database
from ..service.jobs import Claim, HeartbeatResult, read_cancel_flag, renew

BEATS_PER_LEASE = 4
"""Number of heartbeats in one lease: three may fail before another worker takes over."""


class JobTooLong(GarmentqError):
    """The job took longer than GARMENTQ_MAX_SECONDS; use fewer --vertices, or raise the limit."""

    code = "job.too_long"


def _do_nothing(reason: str) -> None:
    """Do nothing."""


class LeaseKeeper:
    """Renew a claim's lease in a background thread.

    Attributes:
        reason: Empty while the job may continue; else `lost`, `cancelled`, `released` or `too_long`.
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
        self._thread = threading.Thread(target=self._run, name=f"watch-{claim.job}", daemon=True)

    def __enter__(self) -> LeaseKeeper:
        """Start the thread."""
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Stop the thread."""
        self._ended.set()
        self._thread.join()

    def must_stop(self) -> bool:
        """Return whether the job must stop; `reason` says why."""
        return bool(self.reason)

    def _run(self) -> None:
        started = renewed = time.monotonic()
        while not self._ended.wait(self._poll):
            now = time.monotonic()
            is_due = now - renewed >= self._lease / BEATS_PER_LEASE
            try:
                pulse = (
                    renew(self.database, self._claim, self._lease)
                    if is_due
                    else read_cancel_flag(self.database, self._claim)
                )
            except GarmentqError:  # the database is unavailable; the fence will show whose the job is
                pulse = HeartbeatResult(is_owner=True, is_cancelled=False)
            else:
                renewed = now if is_due else renewed
            self.reason = self._judge(pulse, now - started)
            if self.reason:
                self._keep_alive(renewed)
                return

    def _judge(self, pulse: HeartbeatResult, seconds: float) -> str:
        if not pulse.is_owner:
            return "lost"
        if pulse.is_cancelled:
            return "cancelled"
        if self._is_draining():
            return "released"
        return "too_long" if seconds > self._max else ""

    def _keep_alive(self, renewed: float) -> None:
        """Continue to renew the lease while the stage stops, and call `force` if it does not."""
        deadline = time.monotonic() + self._grace
        while time.monotonic() < deadline:
            if self._ended.wait(min(self._grace, self._lease / BEATS_PER_LEASE)):
                return
            if self.reason != "lost":
                with suppress(GarmentqError):
                    renew(self.database, self._claim, self._lease)
        self._force(self.reason)
