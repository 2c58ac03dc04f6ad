"""Count of each key's recent requests, for this process only."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from ...core.run.errors import GarmentqError, Unavailable
from .limits import ApiLimits

FORGIVEN_SECONDS = 10.0
"""Time after which one wrong key no longer counts [s]."""

TRIAL_SECONDS, TRIAL_BURST_COUNT = 10.0, 5
"""Interval at which a key may send test messages to a webhook in the long run [s], and the number that it may send at
once. A person who sets a webhook up tries a few times a minute; a search for hosts by it is too slow."""

MAX_PROCESS_DOWNLOADS = 256
"""Largest number of downloads of this process at a time, for all keys together: each has an open file beside its
connection, and a process may have 1024 of both."""

MAX_TRACKED_ADDRESSES = 10_000
"""Largest number of addresses and of keys that are remembered; it bounds the memory."""


class TooManyRequests(GarmentqError):
    """The key sends too many requests; wait as long as Retry-After says."""

    code = "key.too_many_requests"

    def __init__(self, message: str, seconds: float) -> None:
        """Refuse for some seconds."""
        super().__init__(message)
        self.retry_seconds = seconds


class UploadsOpen(GarmentqError):
    """The key has reached its number of simultaneous uploads; wait until one has ended."""

    code = "key.uploads_open"


class DownloadsOpen(GarmentqError):
    """The key has reached its number of simultaneous downloads; wait until one has ended."""

    code = "key.downloads_open"


class DownloadsFull(Unavailable):
    """The service has reached its number of simultaneous downloads; retry when Retry-After says."""

    code = "service.downloads_full"


class StreamsFull(GarmentqError):
    """The key has reached its number of open event streams; close one."""

    code = "request.streams_full"


class LimitedOpen(GarmentqError):
    """The key has reached its limit of patterns and scans checked at a time; wait until one is done."""

    code = "key.limited_open"


class LimitedFull(GarmentqError):
    """The service has reached its limit of patterns and scans checked at a time; wait as long as Retry-After says."""

    code = "service.limited_full"

    def __init__(self, message: str | None = None) -> None:
        """Refuse for some seconds."""
        super().__init__(message)
        self.retry_seconds = 5.0


class Meter:
    """Count requests, uploads, downloads, event streams and limited processes by key."""

    def __init__(self, limits: ApiLimits, now: Callable[[], float] = time.monotonic) -> None:
        """Begin without counts.

        Args:
            limits: Limits of a key.
            now: A monotonic clock [s].
        """
        self._limits = limits
        self._now = now
        self._lock = threading.Lock()
        self._left: dict[str, tuple[float, float]] = {}
        self._open: dict[tuple[str, str], int] = {}
        self._wrong: dict[str, tuple[float, float]] = {}
        self._known: set[int] = set()

    def take(self, key: str) -> None:
        """Count one request: a bucket of `burst` that fills by `requests_per_second`.

        Raises:
            TooManyRequests: if the bucket is empty.
        """
        if key:
            self._draw(key, self._limits.requests_per_second, self._limits.burst)

    def count_test(self, key: str) -> None:
        """Count one test message to a webhook, also of the local user.

        Raises:
            TooManyRequests: if the key exceeds the rate of `TRIAL_SECONDS`.
        """
        self._draw(f"trial {key}", 1.0 / TRIAL_SECONDS, TRIAL_BURST_COUNT)

    def _draw(self, bucket: str, rate: float, burst: int) -> None:
        now = self._now()
        with self._lock:
            left, then = self._left.get(bucket, (float(burst), now))
            left = min(float(burst), left + rate * (now - then))
            self._left[bucket] = (left - 1.0 if left >= 1.0 else left, now)
        if left < 1.0:
            raise TooManyRequests(
                f"the key sends more than {rate:g} requests a second; wait as long as Retry-After says.",
                (1.0 - left) / rate,
            )

    def check_address(self, address: str, token: str | None) -> None:
        """Refuse an address that tried many wrong keys, except for a key that was right before.

        A key cannot be found by trying, and other clients of the same proxy are not refused.

        Raises:
            TooManyRequests: if the address must wait.
        """
        with self._lock:
            count, then = self._wrong.get(address, (0.0, 0.0))
            left = count - (self._now() - then) / FORGIVEN_SECONDS
            known = hash(token) in self._known
        if left >= self._limits.wrong_keys and not known:
            raise TooManyRequests("too many wrong keys from this address; wait as long as Retry-After says.", 10.0)

    def note_wrong(self, address: str) -> None:
        """Count a wrong key."""
        with self._lock:
            now = self._now()
            count, then = self._wrong.get(address, (0.0, now))
            if len(self._wrong) >= MAX_TRACKED_ADDRESSES:
                self._wrong.clear()
            self._wrong[address] = (max(0.0, count - (now - then) / FORGIVEN_SECONDS) + 1.0, now)

    def note_key(self, token: str | None) -> None:
        """Record the hash of a right key."""
        with self._lock:
            if len(self._known) >= MAX_TRACKED_ADDRESSES:
                self._known.clear()
            self._known.add(hash(token))

    @contextmanager
    def uploading(self, key: str) -> Iterator[None]:
        """Count one upload for the block.

        Raises:
            UploadsOpen: if the key has reached its limit.
        """
        most = self._limits.uploads if key else None
        if not self._begin("upload", key, most):
            raise UploadsOpen(f"the key has {most} simultaneous uploads, its limit; wait until one has ended.")
        try:
            yield
        finally:
            self._end("upload", key)

    @contextmanager
    def downloading(self, key: str) -> Iterator[None]:
        """Count one download for the block.

        Raises:
            DownloadsOpen: if the key has reached its limit.
            DownloadsFull: if all keys together have reached theirs.
        """
        most = self._limits.downloads if key else None
        if not self._begin("download", key, most):
            raise DownloadsOpen(f"the key has {most} simultaneous downloads, its limit; wait until one has ended.")
        try:
            if not self._begin("any download", "", MAX_PROCESS_DOWNLOADS):
                raise DownloadsFull()
            try:
                yield
            finally:
                self._end("any download", "")
        finally:
            self._end("download", key)

    @contextmanager
    def streaming(self, key: str) -> Iterator[None]:
        """Count one event stream for the block.

        Raises:
            StreamsFull: if the key has reached its limit.
        """
        if not self._begin("stream", key, self._limits.streams):
            raise StreamsFull(f"the key has {self._limits.streams} event streams open, its limit; close one.")
        try:
            yield
        finally:
            self._end("stream", key)

    @contextmanager
    def waiting(self, key: str) -> Iterator[None]:
        """Count one request that waits for a limited process, for the block.

        Raises:
            LimitedOpen: if the key has reached its limit.
        """
        if not self._begin("waiting", key, self._limits.limited_waiting):
            raise LimitedOpen(f"{self._limits.limited_waiting} requests of the key wait for their turn; send fewer.")
        try:
            yield
        finally:
            self._end("waiting", key)

    @contextmanager
    def limited(self, key: str) -> Iterator[None]:
        """Count one limited process for the block.

        Raises:
            LimitedOpen: if the key has reached its limit.
            LimitedFull: if all keys together have reached theirs.
        """
        most = self._limits.limited_per_key if key else None
        if not self._begin("limited", key, most):
            raise LimitedOpen()
        try:
            if not self._begin("limited in all", "", self._limits.limited):
                raise LimitedFull()
            try:
                yield
            finally:
                self._end("limited in all", "")
        finally:
            self._end("limited", key)

    def _begin(self, resource: str, key: str, most: int | None) -> bool:
        with self._lock:
            count = self._open.get((resource, key), 0)
            if most is not None and count >= most:
                return False
            self._open[resource, key] = count + 1
            return True

    def _end(self, resource: str, key: str) -> None:
        with self._lock:
            self._open[resource, key] -= 1
            if not self._open[resource, key]:
                del self._open[resource, key]
