"""One HTTP connection to a service: safe retries, waits that the service requests, errors by their codes."""

from __future__ import annotations

import time
import weakref
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx

from ..core.run.errors import BadInput, GarmentqError, NotFound
from .settings import hide_password
from .store import STORE_BLOCK_SIZE

SERVICE_HTTP_TIMEOUT = httpx.Timeout(150.0, connect=5.0)
"""Time limits of a response and of a connection [s]. The service answers within 120 s or reports a timeout; a
connection takes milliseconds."""

RETRYABLE_CODES = (
    "key.too_many_requests", "key.uploads_open", "key.downloads_open", "key.limited_open", "service.limited_full",
)  # fmt: skip
"""Refusals that end by themselves within seconds: the client waits as long as Retry-After says, and retries."""

PATIENCE_SECONDS = 60.0
"""Longest total wait for one request [s]."""

MAX_REQUEST_TRIES = 3
"""Largest number of times that a request is sent if the connection breaks; every retried request is safe to repeat."""


class ServiceUnreachable(GarmentqError):
    """The service does not respond; check GARMENTQ_URL, or start it by `garmentq serve`."""

    code = "service.unreachable"


class Connection:
    """Send requests to a service by HTTP. Every refusal is a `GarmentqError` with the service's code."""

    def __init__(self, url: str, key: str) -> None:
        """Prepare a connection; nothing is sent before the first request.

        Args:
            url: Address of the service, `http://host:port`.
            key: Token of an API key, or empty.

        Raises:
            ServiceUnreachable: if the address is invalid.
        """
        headers = {"authorization": f"Bearer {key}"} if key else {}
        try:
            self._http = httpx.Client(base_url=url.rstrip("/"), headers=headers, timeout=SERVICE_HTTP_TIMEOUT)
        except (httpx.InvalidURL, ValueError) as error:
            raise ServiceUnreachable(f"GARMENTQ_URL is not an address: {error}.") from error
        weakref.finalize(self, self._http.close)  # closes the socket after an error too

    @property
    def address(self) -> str:
        """Return the address of the service without its password."""
        return hide_password(str(self._http.base_url))

    def close(self) -> None:
        """Close the connection."""
        self._http.close()

    def request(self, method: str, url: str, tries: int = MAX_REQUEST_TRIES, **options: Any) -> Any:
        """Return the JSON value of a response."""
        answer = self.send(method, url, tries, **options)
        try:
            return answer.json()
        except ValueError:
            raise ServiceUnreachable(f"the server at {self.address} is not a garmentq service.") from None

    def send(self, method: str, url: str, tries: int = MAX_REQUEST_TRIES, **options: Any) -> httpx.Response:
        """Return a response; wait and retry if the service says that the key sends too many requests."""
        deadline = time.monotonic() + PATIENCE_SECONDS
        while True:
            answer = self._send_now(method, url, tries, **options)
            if answer.status_code < 400:
                return answer
            error, pause = _make_error(answer), _read_retry_after(answer)
            if error.code not in RETRYABLE_CODES or time.monotonic() + pause > deadline:
                raise error
            time.sleep(pause)

    @contextmanager
    def stream(self, url: str, headers: dict[str, str] | None = None) -> Iterator[httpx.Response]:
        """Open a response that is read block by block; raise `httpx.TransportError` if it breaks off."""
        with self._http.stream("GET", url, headers=headers) as answer:
            if answer.status_code >= 400:
                answer.read()
                raise _make_error(answer)
            yield answer

    @contextmanager
    def reach(self) -> Iterator[None]:
        """Convert a broken connection within the block into `ServiceUnreachable`."""
        try:
            yield
        except (httpx.TransportError, httpx.InvalidURL) as error:
            raise ServiceUnreachable(
                f"the service at {self.address} does not respond ({type(error).__name__}); "
                "check GARMENTQ_URL, or start it by `garmentq serve`."
            ) from error

    def _send_now(
        self, method: str, url: str, tries: int, content: bytes | Path | None = None, **options: Any
    ) -> httpx.Response:
        """Send a request at once; stream a file, and retry a broken connection, `tries` attempts in all."""
        with self.reach():
            while True:
                try:
                    if not isinstance(content, Path):
                        return self._http.request(method, url, content=content, **options)
                    with content.open("rb") as stream:
                        blocks = iter(lambda: stream.read(STORE_BLOCK_SIZE), b"")
                        return self._http.request(method, url, content=blocks, **options)
                except httpx.ConnectError:
                    raise
                except httpx.TransportError:
                    tries -= 1
                    if tries <= 0:
                        raise
                    time.sleep(0.2)


def _read_retry_after(answer: httpx.Response) -> float:
    """Read how long to wait [s]; one second if the service does not say."""
    text = answer.headers.get("retry-after", "")
    return float(text) if text.isascii() and text.isdigit() else 1.0


def _make_error(answer: httpx.Response) -> GarmentqError:
    """Return the service's error, of the class that its status determines, with the service's code."""
    try:
        found = answer.json()
        code, message = str(found["code"]), str(found["detail"])
    except (ValueError, KeyError, TypeError):
        return ServiceUnreachable(f"the server at {answer.url.host} is not a garmentq service ({answer.status_code}).")
    return make_refusal(answer.status_code, code, message)


def make_refusal(status: int, code: str, message: str) -> GarmentqError:
    """Return an error of the class that a status determines, with the service's code."""
    kinds: dict[int, type[GarmentqError]] = {404: NotFound, 400: BadInput, 408: BadInput, 409: BadInput}
    kinds |= {413: BadInput, 415: BadInput, 422: BadInput}
    error = kinds.get(status, GarmentqError)(message)
    error.code = code
    return error
