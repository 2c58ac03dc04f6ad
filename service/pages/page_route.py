"""Routes of pages: errors are answered as pages, and visitors without a session are redirected to sign in."""

from __future__ import annotations

import json
from collections.abc import Callable, Coroutine
from typing import Any
from urllib.parse import quote

from fastapi import APIRouter, FastAPI, Request, Response
from fastapi.exceptions import RequestValidationError
from fastapi.responses import RedirectResponse
from fastapi.routing import APIRoute
from starlette.exceptions import HTTPException

from ...core.run.errors import GarmentqError
from ..api.problems import RETRY_SECONDS, RequestBad, error_status, make_public_message, make_retry_header
from .control_words import speak_of_controls
from .markup import html
from .session import SignInNeeded, recognise_visitor
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
                return draw_error(request, RequestBad(ADDRESS_BAD))
            except GarmentqError as error:
                return draw_error(request, error)

        return answer


def make_router() -> APIRouter:
    """Return a router of pages."""
    return APIRouter(route_class=PageRoute, include_in_schema=False)


def draw_error(request: Request, error: GarmentqError) -> Response:
    """Return the page with an error and the next step, with the navigation of the visitor."""
    answer = draw_problem(request, error_status(error), error.code, make_public_message(error))
    answer.headers.update(make_retry_header(answer.status_code, getattr(error, "retry_seconds", RETRY_SECONDS)))
    return answer


def draw_problem(request: Request, status: int, code: str, message: str) -> Response:
    """Return the page with a problem in words of a page."""
    title = TITLES.get(status, FAULT_TITLE if status >= 500 else REFUSED_TITLE)
    said = MESSAGES.get(code) or speak_of_controls(message)
    content = html(PROBLEM, title=title, message=said[:1].upper() + said[1:], code=code)
    return draw_shell(title, content, recognise_visitor(request), status=status)


def add_error_pages(app: FastAPI) -> None:
    """Answer what a browser opens by an address of any route with a page if it fails; programs get problems as JSON."""
    for kind in (GarmentqError, RequestValidationError, HTTPException):
        app.add_exception_handler(kind, _make_handler(app.exception_handlers[kind]))


def _make_handler(answer_json: Any) -> Any:
    def answer(request: Request, error: Exception) -> Response:
        found: Response = answer_json(request, error)
        if request.method not in ("GET", "HEAD") or "text/html" not in request.headers.get("accept", ""):
            return found
        problem = json.loads(bytes(found.body))
        page = draw_problem(request, found.status_code, problem["code"], problem["detail"])
        page.headers.update(make_retry_header(found.status_code, getattr(error, "retry_seconds", RETRY_SECONDS)))
        return page

    return answer


ADDRESS_BAD = "the address is invalid; go back to the page that linked to it."

MESSAGES = {
    "job.unknown": "There is no such job: it was deleted, or it belongs to another key.",
    "result.missing": "There is no such result: its job has not ended, or made no such file.",
    "request.no_such_page": "There is no page at this address.",
    "key.scope_missing": "Your key may not do this; ask the operator for one that may.",
}
"""Sentences of problems that a page says in its own words, by code."""

TITLES = {401: "Sign in", 403: "Not allowed", 404: "Not found", 429: "Too many requests"}
FAULT_TITLE, REFUSED_TITLE = "The service has a problem", "This did not work"

PROBLEM = """<section class="signin"><h1>{title}</h1><p class="error" role="alert">{message}</p>
<p class="row"><a class="button" href="/">Gallery</a> <code class="soft">{code}</code></p></section>"""
