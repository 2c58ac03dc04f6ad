"""Middleware before every route: authentication, limits of time and size, security headers, audit log."""

from __future__ import annotations

import asyncio
import ipaddress
import logging
import time
import uuid
from collections.abc import Awaitable, Callable, Collection, MutableMapping
from functools import partial
from typing import Any
from urllib.parse import unquote_to_bytes, urlsplit

from starlette.concurrency import run_in_threadpool

from ...core.run.errors import GarmentqError, Unavailable
from ...core.run.text import TextBad, has_unstorable_text
from ..audit import is_recorded, record_access
from ..keys import Caller, authenticate_token
from ..logs import REQUEST
from ..sessions import authenticate_session, check_csrf
from .limits import ApiLimits
from .problems import answer_error, make_problem, refuse

log = logging.getLogger(__name__)

Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]

UPLOAD_PATHS = ("/v1/scans", "/v1/bodies", "/v1/labels", "/v1/patterns", "/v1/motions")
DOCUMENT_PATHS = ("/v1/templates/", "/v1/patterns/check", "/v1/patterns/edit", "/v1/jobs/batch")
"""Beginnings of the paths that accept a whole pattern, or many orders."""
GUARDED_PATHS = ("/v1/", "/metrics")
"""Beginnings of the paths that require a key, before any byte of a body is read."""

HEAD_BYTES = 32 * 1024
"""Largest head of a request [bytes]; a browser's with all its cookies is below 8 KiB."""

ADMITTED_SECONDS = 5.0
"""Validity of a caller's authentication during a request [s]: after it, the key or session is read again (one row of
the database) before more bytes are passed on."""

CALLER = "garmentq.caller"
"""Key of the ASGI scope under which the caller is stored."""

IS_HEAD = "garmentq.is_head"
"""Key of the ASGI scope that marks a HEAD request, whose response has no body."""

CSRF_HEADER = b"x-csrf-token"
"""Header that a page sends with each change, beside its session's cookie."""

SAFE_METHODS = ("GET", "HEAD")
"""Methods that change nothing."""

HEADERS = (
    (b"x-content-type-options", b"nosniff"),
    (b"content-security-policy", b"default-src 'none'; frame-ancestors 'none'"),
    (b"referrer-policy", b"no-referrer"),
)
"""Default headers of every response; a route may override them."""


class Guard:
    """Enforce authentication and limits for every request, and answer a problem if they are violated."""

    def __init__(self, app: Any, limits: ApiLimits, is_open: bool, hosts: Collection[str] = ()) -> None:
        """Wrap an ASGI application.

        Args:
            app: The application.
            limits: Limits of requests.
            is_open: True if the service listens on a loopback address and may work without keys: then it refuses pages
                of other origins, and host names that were bound to 127.0.0.1.
            hosts: Host names beside those of this machine under which a proxy calls such a service.
        """
        self.app = app
        self.limits = limits
        self.is_open = is_open
        self.hosts = hosts
        self._records: set[asyncio.Task[None]] = set()

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        """Handle one request."""
        if scope["type"] != "http":
            await self.app(scope, partial(self._finish, receive), send)
            return
        request = uuid.uuid4().hex[:16]
        token = REQUEST.set(request)
        status = 500

        async def tell(message: Message) -> None:
            nonlocal status
            if message["type"] == "http.response.start":
                status = message["status"]
                headers = message.setdefault("headers", [])
                known = {name.lower() for name, _ in headers}
                headers += [one for one in (*HEADERS, (b"cache-control", b"no-store")) if one[0] not in known]
                headers.append((b"x-request-id", request.encode()))
            await send(message)

        try:
            answer = _refuse_form(scope) or self._refuse_foreign(scope) or await self._admit(scope)
            if answer is not None:
                await answer(scope, receive, tell)
                return
            await self._bounded(_as_get(scope), receive, tell)
        finally:
            self._record_later(scope, status, request)
            REQUEST.reset(token)

    async def _admit(self, scope: Message) -> Any:
        """Authenticate and count the caller; return the refusal, or None if the request may continue."""
        if not scope["path"].startswith(GUARDED_PATHS):
            return None
        rooms, address = scope["app"].state.rooms, _address(scope)
        admission = rooms.lanes.admission
        try:
            token, session = _find_token(scope), find_session(scope)
            if token is None and session is not None:
                scope[CALLER] = await admission.run(_find_caller, scope)
                if scope["method"] not in SAFE_METHODS:
                    check_csrf(session, find_header(scope, CSRF_HEADER))
            else:
                rooms.meter.check_address(address, token)
                scope[CALLER] = await admission.run(_find_caller, scope)
                rooms.meter.note_key(token)
            rooms.meter.take(scope[CALLER].key)
        except GarmentqError as error:
            if error.code == "key.bad":
                rooms.meter.note_wrong(address)
            return answer_error(error)
        return None

    def _refuse_foreign(self, scope: Message) -> Any:
        """Return the refusal of a request from a page of another origin, or None."""
        if self.is_open and not _is_local_origin(scope, self.hosts):
            return make_problem(403, "request.foreign_origin", "call it at 127.0.0.1; other origins are refused.")
        return None

    def _record_later(self, scope: Message, status: int, request: str) -> None:
        """Write the audit log in the background, so that the client's next request need not wait for it."""
        if scope.get(CALLER) is not None and is_recorded(scope["method"], scope["path"], status):
            task = asyncio.create_task(self._record(scope, status, request))
            self._records.add(task)
            task.add_done_callback(self._records.discard)

    async def _finish(self, receive: Receive) -> Message:
        """Return the next message; before a shutdown, wait until the audit log is written."""
        message = await receive()
        if message["type"] == "lifespan.shutdown":
            await asyncio.gather(*self._records)
        return message

    async def _record(self, scope: Message, status: int, request: str) -> None:
        caller: Caller = scope[CALLER]
        done = f"{scope['method']} {status}"
        try:
            database = scope["app"].state.rooms.database
            await run_in_threadpool(
                record_access, database, caller.key, done, scope["path"], (_address(scope), request)
            )
        except GarmentqError as error:
            log.error("not in the audit log: %s %s by key '%s': %s", done, scope["path"], caller.key, error)

    async def _bounded(self, scope: Message, receive: Receive, send: Send) -> None:
        is_upload = scope["path"] in UPLOAD_PATHS and scope["method"] == "POST"
        has_started, standing, is_good, is_over = asyncio.Event(), AccessCheck(scope), False, False

        async def note(message: Message) -> None:
            nonlocal is_good, is_over
            has_started.set()
            if message["type"] == "http.response.start":
                is_good = message["status"] < 400
            elif is_good and await standing.find_end() is not None:
                is_over = True
                task.cancel()  # the connection is closed, so that a cut response does not look complete
                return
            await send(message)

        most = self.limits.upload_bytes if is_upload else self._body_bytes(scope)
        seconds = self.limits.upload_seconds if is_upload else self.limits.answer_seconds
        sending = self.limits.upload_seconds if is_upload else self.limits.body_seconds
        task = asyncio.create_task(self.app(scope, self._counted(receive, (most, sending), standing), note))
        waiter = asyncio.create_task(has_started.wait())
        try:
            await asyncio.wait({task, waiter}, timeout=seconds, return_when=asyncio.FIRST_COMPLETED)
            if not has_started.is_set() and not task.done():
                task.cancel()
                answer = make_problem(503, "request.timeout", f"no answer within {seconds:g} s; try again later.")
                await answer(scope, receive, send)
                await asyncio.wait({task})
                return
            try:
                await task
            except asyncio.CancelledError:
                if not is_over:
                    raise
        finally:
            waiter.cancel()
            task.cancel()

    def _body_bytes(self, scope: Message) -> int:
        return self.limits.template_bytes if scope["path"].startswith(DOCUMENT_PATHS) else self.limits.body_bytes

    def _counted(self, receive: Receive, bounds: tuple[int, float], standing: AccessCheck) -> Receive:
        """Count the bytes that a client sends, and raise if it pauses for too long or sends too slowly."""
        most, seconds = bounds
        total, is_whole, until = 0, False, time.monotonic() + seconds

        async def counted() -> Message:
            nonlocal total, is_whole
            if is_whole:
                return await receive()  # waits until the client disconnects
            try:
                message = await asyncio.wait_for(receive(), min(self.limits.chunk_seconds, until - time.monotonic()))
            except TimeoutError:
                raise refuse(408, "request.too_slow", "the body did not come in time; send it again.") from None
            if (ended := await standing.find_end()) is not None:
                raise ended
            total += len(message.get("body", b""))
            is_whole = not message.get("more_body", False)
            if total > most:
                raise refuse(413, "request.too_large", f"the body is larger than {most} bytes; send a smaller file.")
            return message

        return counted


class AccessCheck:
    """Check during a request whether its caller is still authorised."""

    def __init__(self, scope: Message) -> None:
        """Begin with a caller who was just authenticated.

        Args:
            scope: The request; without a caller no check is made.
        """
        self._scope = scope
        self._seen = time.monotonic()

    async def find_end(self) -> GarmentqError | None:
        """Return why the caller is no longer authorised, or None; it is checked again after `ADMITTED_SECONDS`.

        While the database is unavailable every caller stays authorised.
        """
        if self._scope.get(CALLER) is None or time.monotonic() - self._seen < ADMITTED_SECONDS:
            return None
        try:
            admission = self._scope["app"].state.rooms.lanes.admission
            await admission.run(_find_caller, self._scope)
        except Unavailable:
            pass
        except GarmentqError as error:
            return error
        self._seen = time.monotonic()
        return None


def is_loopback(host: str) -> bool:
    """Return whether an address is a loopback address."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return False


def _refuse_form(scope: Message) -> Any:
    """Return the refusal of a request by its head alone, or None."""
    names = [name for name, _ in scope["headers"]]
    if sum(len(name) + len(value) for name, value in scope["headers"]) > HEAD_BYTES:
        return make_problem(431, "request.head_too_large", f"the request's head is larger than {HEAD_BYTES} bytes.")
    if b"content-length" in names and b"transfer-encoding" in names:  # two proxies may parse it differently
        return make_problem(400, "request.bad", "give Content-Length or Transfer-Encoding, not both.")
    return None if _is_text(scope) else answer_error(TextBad())


def _is_text(scope: Message) -> bool:
    """Return whether path and query are valid UTF-8 that can be stored; the server decodes invalid bytes to a mark."""
    try:
        parts = (scope.get("raw_path") or scope["path"], scope["query_string"])
        return not has_unstorable_text([unquote_to_bytes(part).decode("utf-8") for part in parts])
    except UnicodeDecodeError:
        return False


def _as_get(scope: Message) -> Message:
    """Return a HEAD request as the GET that it stands for; the server drops the body, as its own scope is unchanged."""
    return {**scope, "method": "GET", IS_HEAD: True} if scope["method"] == "HEAD" else scope


def _address(scope: Message) -> str:
    return str((scope.get("client") or ("",))[0])


def _find_caller(scope: Message) -> Caller:
    """Return the caller, by the key or the session of the request.

    Raises:
        KeyMissing, KeyBad, SessionEnded: if key or session are unknown or no longer valid.
    """
    rooms, token, session = scope["app"].state.rooms, _find_token(scope), find_session(scope)
    if token is None and session is not None:
        return authenticate_session(rooms.database, session, bool(rooms.local_token))
    return authenticate_token(rooms.database, token, rooms.local_token)


def _find_token(scope: Message) -> str | None:
    """Return the token of `Authorization: Bearer TOKEN`, or None."""
    for name, value in scope["headers"]:
        if name == b"authorization":
            kind, _, token = value.decode("latin-1").partition(" ")
            return token.strip() if kind.lower() == "bearer" and token.strip() else None
    return None


def find_header(scope: Message, header_name: bytes) -> str:
    """Return the value of a request's header by its lower-case name; empty if it has none."""
    return next((value.decode("latin-1") for name, value in scope["headers"] if name == header_name), "")


def find_session(scope: Message) -> str | None:
    """Return the session's token in the cookie of a signed-in browser, or None."""
    for one in find_header(scope, b"cookie").split(";"):
        name, _, value = one.strip().partition("=")
        if name == name_cookie(scope["scheme"]) and value:
            return value
    return None


def name_cookie(scheme: str) -> str:
    """Return the name of the session's cookie; a browser accepts the prefix `__Host-` only by https from this host."""
    return "__Host-garmentq" if scheme == "https" else "garmentq"


def _is_local_origin(scope: Message, hosts: Collection[str]) -> bool:
    headers = {name: value.decode("latin-1") for name, value in scope["headers"]}
    if headers.get(b"sec-fetch-site", "same-origin") not in ("same-origin", "none"):
        return False
    for url in ("//" + headers.get(b"host", ""), headers.get(b"origin", "//localhost")):
        try:
            host = urlsplit(url).hostname
        except ValueError:
            return False
        if not is_loopback(host or "") and host not in hosts:
            return False
    return True
