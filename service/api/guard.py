"""What stands before every route: time limits, body limits, and who may talk to a service without keys."""

from __future__ import annotations

import asyncio
import ipaddress
from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any
from urllib.parse import urlsplit

from .limits import ApiLimits
from .problems import make_problem, refuse

Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]

UPLOADS = ("/v1/scans", "/v1/bodies", "/v1/labels", "/v1/patterns")
TEMPLATES = "/v1/templates/"


class Guard:
    """Bound every request, and answer a problem where it goes beyond."""

    def __init__(self, app: Any, limits: ApiLimits, is_open: bool) -> None:
        """Stand before an ASGI application.

        Args:
            app: The application.
            limits: What a request may cost.
            is_open: The service listens on this machine only and may work without keys: then a page in a browser
                must not reach it, neither from another origin nor by a name that was bound to 127.0.0.1.
        """
        self.app = app
        self.limits = limits
        self.is_open = is_open

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        """Handle one request."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        if self.is_open and not _is_near(scope):
            answer = make_problem(403, "request.foreign_origin", "call this service by 127.0.0.1, from no other page.")
            await answer(scope, receive, send)
            return
        await self._bounded(scope, receive, send)

    async def _bounded(self, scope: Message, receive: Receive, send: Send) -> None:
        is_upload = scope["path"] in UPLOADS and scope["method"] == "POST"
        begun = asyncio.Event()

        async def note(message: Message) -> None:
            begun.set()
            if message["type"] == "http.response.start":
                message.setdefault("headers", []).extend(
                    [(b"x-content-type-options", b"nosniff"), (b"cache-control", b"no-store")]
                )
            await send(message)

        most = self.limits.upload_bytes if is_upload else self._body_bytes(scope)
        seconds = self.limits.upload_seconds if is_upload else self.limits.answer_seconds
        task = asyncio.create_task(self.app(scope, self._counted(receive, most), note))
        waiter = asyncio.create_task(begun.wait())
        try:
            await asyncio.wait({task, waiter}, timeout=seconds, return_when=asyncio.FIRST_COMPLETED)
            if not begun.is_set() and not task.done():
                task.cancel()
                answer = make_problem(503, "request.timeout", f"no answer within {seconds:g} s; try again later.")
                await answer(scope, receive, send)
                await asyncio.wait({task})
                return
            await task
        finally:
            waiter.cancel()
            task.cancel()

    def _body_bytes(self, scope: Message) -> int:
        return self.limits.template_bytes if scope["path"].startswith(TEMPLATES) else self.limits.body_bytes

    def _counted(self, receive: Receive, most: int) -> Receive:
        """Count what a client sends, and give up on one that falls silent in the middle of it."""
        total, is_whole = 0, False

        async def counted() -> Message:
            nonlocal total, is_whole
            if is_whole:
                return await receive()  # waits for the client to go away
            try:
                message = await asyncio.wait_for(receive(), self.limits.chunk_seconds)
            except TimeoutError:
                raise refuse(408, "request.too_slow", "nothing came for a while; send the file again.") from None
            total += len(message.get("body", b""))
            is_whole = not message.get("more_body", False)
            if total > most:
                raise refuse(413, "request.too_large", f"the body is larger than {most} bytes; send a smaller file.")
            return message

        return counted


def is_loopback(host: str) -> bool:
    """Return whether an address means this machine only."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return False


def _is_near(scope: Message) -> bool:
    headers = {name: value.decode("latin-1") for name, value in scope["headers"]}
    for url in ("//" + headers.get(b"host", ""), headers.get(b"origin", "//localhost")):
        try:
            host = urlsplit(url).hostname
        except ValueError:
            return False
        if not is_loopback(host or ""):
            return False
    return True
