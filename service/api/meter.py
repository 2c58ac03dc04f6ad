"""What each key has asked for lately, as far as this process knows."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from ...core.run.errors import GarmentqError, Unavailable
from .limits import ApiLimits

FORGIVEN_SECONDS = 10.0
"""After so long one wrong key is forgiven [s]."""

TRIAL_SECONDS, TRIAL_BURST_COUNT = 10.0, 5
"""Interval at which a key may send trial messages to a webhook in the long run [s], and the number that it may send at
once. A person who sets one up tries some times a minute; a search for hosts by it gets nowhere."""

MAX_PROCESS_DOWNLOADS = 256
"""Largest number of downloads of this process at a time, for all keys together: each holds an open file beside its
connection, and a process may have 1024 of both."""

MAX_TRACKED_ADDRESSES = 10_000
"""Addresses and keys that are remembered, so that nobody fills the memory."""


class TooManyRequests(GarmentqError):
    """The key asks more often than it may; wait as long as Retry-After says."""

    code = "key.too_many_requests"

    def __init__(self, message: str, seconds: float) -> None:
        """Refuse for some seconds."""
        super().__init__(message)
        self.retry_seconds = seconds


class UploadsOpen(GarmentqError):
    """The key has as many uploads under way as it may; wait until one has ended."""

    code = "key.uploads_open"


class DownloadsOpen(GarmentqError):
    """The key has as many downloads under way as it may; wait until one has ended."""

    code = "key.downloads_open"


class DownloadsFull(Unavailable):
    """The service sends as many files as it may at a time; ask again when Retry-After says."""

    code = "service.downloads_full"


class StreamsFull(GarmentqError):
    """The key has as many event streams open as it may; close one."""

    code = "request.streams_full"


class LimitedOpen(GarmentqError):
    """The key has as many patterns and scans looked at as it may; wait until one is done."""

    code = "key.limited_open"


class LimitedFull(GarmentqError):
    """The service looks at as many patterns and scans as it may at a time; wait as long as Retry-After says."""

    code = "service.limited_full"

    def __init__(self, message: str | None = None) -> None:
        """Refuse for some seconds."""
        super().__init__(message)
        self.retry_seconds = 5.0


class Meter:
    """Count requests, uploads, downloads, event streams and limited processes by key."""

    def __init__(self, limits: ApiLimits, now: Callable[[], float] = time.monotonic) -> None:
        """Begin with every key at rest.

        Args:
            limits: What a key may do.
            now: A clock that only goes forward [s].
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
            TooManyRequests: where the bucket is empty.
        """
        if key:
            self._draw(key, self._limits.requests_per_second, self._limits.burst)

    def take_trial(self, key: str) -> None:
        """Count one message that is sent to a webhook for trial, the local user's too.

        Raises:
            TooManyRequests: where the key tries more often than by `TRIAL_SECONDS`.
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
                f"the key asks more than {rate:g} times a second; wait as long as Retry-After says.",
                (1.0 - left) / rate,
            )

    def check_address(self, address: str, token: str | None) -> None:
        """Refuse an address that tried many wrong keys, but for a key that was right a while ago.

        So nobody looks for a key by trying, and nobody shuts others out who come by the same proxy.

        Raises:
            TooManyRequests: where it must wait.
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
        """Note a right key; its hash only."""
        with self._lock:
            if len(self._known) >= MAX_TRACKED_ADDRESSES:
                self._known.clear()
            self._known.add(hash(token))

    @contextmanager
    def uploading(self, key: str) -> Iterator[None]:
        """Count one upload for the block.

        Raises:
            UploadsOpen: where the key has as many under way as it may.
        """
        most = self._limits.uploads if key else None
        if not self._begin("upload", key, most):
            raise UploadsOpen(f"the key has {most} uploads under way, as many as it may; wait until one has ended.")
        try:
            yield
        finally:
            self._end("upload", key)

    @contextmanager
    def downloading(self, key: str) -> Iterator[None]:
        """Count one download for the block.

        Raises:
            DownloadsOpen: where the key has as many under way as it may.
            DownloadsFull: where all keys together have.
        """
        most = self._limits.downloads if key else None
        if not self._begin("download", key, most):
            raise DownloadsOpen(f"the key has {most} downloads under way, as many as it may; wait until one has ended.")
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
            StreamsFull: where the key has as many open as it may.
        """
        if not self._begin("stream", key, self._limits.streams):
            raise StreamsFull(f"the key has {self._limits.streams} event streams open, as many as it may; close one.")
        try:
            yield
        finally:
            self._end("stream", key)

    @contextmanager
    def waiting(self, key: str) -> Iterator[None]:
        """Count one request that waits for its turn at a limited process, for the block.

        Raises:
            LimitedOpen: where the key has as many waiting as it may.
        """
        if not self._begin("waiting", key, self._limits.limited_waiting):
            raise LimitedOpen(f"{self._limits.limited_waiting} requests of the key wait for their turn; ask less.")
        try:
            yield
        finally:
            self._end("waiting", key)

    @contextmanager
    def limited(self, key: str) -> Iterator[None]:
        """Count one limited process for the block.

        Raises:
            LimitedOpen: where the key has as many as it may.
            LimitedFull: where all keys together have.
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

    def _begin(self, what: str, key: str, most: int | None) -> bool:
        with self._lock:
            held = self._open.get((what, key), 0)
            if most is not None and held >= most:
                return False
            self._open[what, key] = held + 1
            return True

    def _end(self, what: str, key: str) -> None:
        with self._lock:
            self._open[what, key] -= 1
            if not self._open[what, key]:
                del self._open[what, key]
