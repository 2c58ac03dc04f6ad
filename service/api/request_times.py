"""How long requests take and how they end, by class of route: a closed set, however many routes, keys and jobs."""

from __future__ import annotations

import threading
import time
from bisect import bisect_left
from collections import Counter
from collections.abc import Awaitable, Callable, MutableMapping
from enum import StrEnum
from typing import Any

from ..exposition import format_family, format_histogram
from .guard import SAFE_METHODS, UPLOAD_PATHS

Message = MutableMapping[str, Any]

LATENCY_BOUNDS = (0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0, 30.0, 120.0)
"""Upper bounds of the histogram's buckets [s]: a list takes 0.03 s, an answer begins after 120 s at the latest."""

MONITORING_PATHS = ("/healthz", "/readyz", "/metrics")

DOWNLOAD_PARTS = ("/artifacts/", "/exports/", "/result.zip")
"""Parts of the paths from which files are downloaded."""


class RouteClass(StrEnum):
    """Name routes whose times are alike."""

    READ = "read"
    CHANGE = "change"
    UPLOAD = "upload"
    DOWNLOAD = "download"
    STREAM = "stream"
    PAGE = "page"
    MONITORING = "monitoring"


def classify(method: str, path: str) -> RouteClass:
    """Return the class of a request; a path without a route has one, too."""
    if path in MONITORING_PATHS:
        return RouteClass.MONITORING
    if not path.startswith("/v1/"):
        return RouteClass.PAGE
    if method not in SAFE_METHODS:
        return RouteClass.UPLOAD if path in UPLOAD_PATHS else RouteClass.CHANGE
    if path.endswith("/events"):
        return RouteClass.STREAM
    return RouteClass.DOWNLOAD if any(part in path for part in DOWNLOAD_PARTS) else RouteClass.READ


class RequestTimes:
    """Count the requests of this process since its start."""

    def __init__(self) -> None:
        """Begin at zero."""
        self._lock = threading.Lock()
        self._buckets = {route: [0] * (len(LATENCY_BOUNDS) + 1) for route in RouteClass}
        self._seconds = dict.fromkeys(RouteClass, 0.0)
        self._statuses: Counter[tuple[RouteClass, str]] = Counter()

    def note(self, route: RouteClass, status: int, seconds: float) -> None:
        """Count one request whose answer began with a status after some time [s]."""
        with self._lock:
            self._buckets[route][bisect_left(LATENCY_BOUNDS, seconds)] += 1
            self._seconds[route] += seconds
            self._statuses[route, f"{status // 100}xx"] += 1

    def format_metrics(self) -> str:
        """Return the metrics: times until answers begin, and answers by the first figure of their status."""
        with self._lock:
            times = [({"route": route}, list(self._buckets[route]), self._seconds[route]) for route in RouteClass]
            answers = [
                ({"route": route, "status": status}, float(self._statuses[route, status]))
                for route in RouteClass
                for status in ("2xx", "3xx", "4xx", "5xx")
            ]
        return "".join(
            [
                format_histogram("api_request_seconds", "Time until an answer begins.", LATENCY_BOUNDS, times),
                format_family("api_responses_total", "counter", "Answers by class of status.", answers),
            ]
        )


class RequestTimer:
    """Measure every request; a request without an answer counts as a fault of the service, if its client is there."""

    def __init__(self, app: Any, times: RequestTimes) -> None:
        """Wrap an ASGI application.

        Args:
            app: The application.
            times: Counts the requests.
        """
        self.app = app
        self.times = times

    async def __call__(self, scope: Message, receive: Callable[[], Awaitable[Message]], send: Any) -> None:
        """Handle one request."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        begin, route, has_begun = time.monotonic(), classify(scope["method"], scope["path"]), False

        async def note(message: Message) -> None:
            nonlocal has_begun
            if message["type"] == "http.response.start" and not has_begun:
                has_begun = True
                self.times.note(route, message["status"], time.monotonic() - begin)
            await send(message)

        try:
            await self.app(scope, receive, note)
        except Exception:
            if not has_begun:
                self.times.note(route, 500, time.monotonic() - begin)
            raise
