"""Errors as problem+json (RFC 9457) with our stable codes; never a traceback."""

from __future__ import annotations

import logging
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from starlette.exceptions import HTTPException

from ...core.errors import BadInput, GarmentqError, NotFound

log = logging.getLogger(__name__)

MEDIA = "application/problem+json"

STATUSES = {
    "key.missing": 401,
    "key.bad": 401,
    "key.scope_missing": 403,
    "key.queue_full": 429,
    "job.not_ended": 409,
    "request.streams_full": 429,
    "store.full": 507,
}
"""Statuses of codes whose class does not tell."""

RETRY_SECONDS = "10"
"""When to ask again after 429 or 503: a job takes a minute or two, a restart some seconds."""

CODES = {404: "request.no_such_page", 405: "request.method_not_allowed"}


class RequestBad(BadInput):
    """The request does not fit the description at /docs."""

    code = "request.bad"


def error_status(error: GarmentqError) -> int:
    """Give the HTTP status of an error."""
    if error.code in STATUSES:
        return STATUSES[error.code]
    if isinstance(error, NotFound):
        return 404
    if isinstance(error, BadInput):
        return 422
    return 503 if error.code.startswith(("service.", "store.")) else 500


def make_problem(status: int, code: str, detail: str) -> JSONResponse:
    """Answer with one problem."""
    headers = {"retry-after": RETRY_SECONDS} if status in (429, 503) else {}
    if status == 401:
        headers["www-authenticate"] = "Bearer"
    clean = "".join(letter if letter.isprintable() else "?" for letter in detail)[:2000]
    body = {"type": f"urn:garmentq:{code}", "title": code, "status": status, "code": code, "detail": clean}
    return JSONResponse(body, status, headers, media_type=MEDIA)


def add_handlers(app: FastAPI) -> None:
    """Turn every exception into a problem."""

    def on_ours(request: Request, error: Exception) -> JSONResponse:
        assert isinstance(error, GarmentqError)
        return make_problem(error_status(error), error.code, error.message)

    def on_invalid(request: Request, error: Exception) -> JSONResponse:
        assert isinstance(error, RequestValidationError)
        parts = [f"{'.'.join(str(p) for p in e['loc'])}: {e['msg']}" for e in error.errors()[:5]]
        return make_problem(422, RequestBad.code, "; ".join(parts))

    def on_http(request: Request, error: Exception) -> JSONResponse:
        assert isinstance(error, HTTPException)
        detail: Any = error.detail
        if isinstance(detail, dict):
            return make_problem(error.status_code, detail["code"], detail["message"])
        answer = make_problem(error.status_code, CODES.get(error.status_code, "request.refused"), str(detail))
        answer.headers.update(error.headers or {})
        return answer

    def on_fault(request: Request, error: Exception) -> JSONResponse:
        log.error("a request failed", exc_info=error)
        return make_problem(500, "service.fault", "a fault of garmentq; please report it with the log.")

    app.add_exception_handler(GarmentqError, on_ours)
    app.add_exception_handler(RequestValidationError, on_invalid)
    app.add_exception_handler(HTTPException, on_http)
    app.add_exception_handler(Exception, on_fault)


def refuse(status: int, code: str, message: str) -> HTTPException:
    """Give a refusal that no layer above rewrites."""
    return HTTPException(status, {"code": code, "message": message})  # type: ignore[arg-type]


def show_answer(value: object, status: int = 200, description: str = "Answer.") -> dict[int | str, dict[str, Any]]:
    """Describe an answer by an example, for the OpenAPI page."""
    problem = {"type": "urn:garmentq:job.unknown", "title": "job.unknown", "status": 404, "code": "job.unknown"}
    text = {"detail": "there is no job 'nosuch'; `garmentq status` lists them all."}
    refusal = {"description": "Refused; `code` is stable.", "content": {MEDIA: {"example": problem | text}}}
    content = {"application/json": {"example": value}}
    return {status: {"description": description, "content": content}, "default": refusal}
