"""Routes of pages: errors are answered as pages, and visitors without a session are redirected to sign in."""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from typing import Any
from urllib.parse import quote

from fastapi import APIRouter, Request, Response
from fastapi.exceptions import RequestValidationError
from fastapi.responses import RedirectResponse
from fastapi.routing import APIRoute

from ...core.run.errors import GarmentqError
from ..api.problems import RETRY_SECONDS, RequestBad, error_status, make_public_message, make_retry_header
from .markup import html
from .session import SignInNeeded
from .shell import draw_shell


class PageRoute(APIRoute):
    """Answer every request with a page, also after an error."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """Return the handler of a request."""
        inner = super().get_route_handler()

        async def answer(request: Request) -> Response:
            try:
                return await inner(request)
            except SignInNeeded:
                target = request.url.path + (f"?{request.url.query}" if request.url.query else "")
                return RedirectResponse(f"/signin?next={quote(target, safe='')}", 303)
            except RequestValidationError:
                return draw_error(RequestBad("the address is invalid; go back to the page that linked to it."))
            except GarmentqError as error:
                return draw_error(error)

        return answer


def make_router() -> APIRouter:
    """Return a router of pages."""
    return APIRouter(route_class=PageRoute, include_in_schema=False)


def draw_error(error: GarmentqError) -> Response:
    """Return the page with an error and the next step."""
    content = html('<h1>This did not work</h1><p class="error" role="alert">{}</p><p><code>{}</code></p>'
                   '<p><a href="/">All jobs</a></p>', make_public_message(error), error.code)  # fmt: skip
    answer = draw_shell("Error", content, status=error_status(error))
    answer.headers.update(make_retry_header(answer.status_code, getattr(error, "retry_seconds", RETRY_SECONDS)))
    return answer
