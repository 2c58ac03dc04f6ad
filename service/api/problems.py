"""Errors as problem+json (RFC 9457) with stable codes; never a traceback."""

from __future__ import annotations

import logging
import math
from collections.abc import Sequence
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect

from ...core.run.errors import BadInput, GarmentqError, NotFound, keep_printable
from ...core.run.sandbox import LONGEST_MESSAGE
from ..shown_errors import is_service_error, show_message
from .media_types import BYTES as BYTES_TYPE
from .media_types import MEDIA_TYPES
from .nulls import hide_nulls

log = logging.getLogger(__name__)

MEDIA = "application/problem+json"

STATUSES = {
    "key.missing": 401,
    "key.bad": 401,
    "session.ended": 401,
    "session.link_used": 401,
    "session.csrf": 403,
    "key.scope_missing": 403,
    "key.priority": 403,
    "job.in_use": 409,
    "job.shared": 409,
    "subject.name_taken": 409,
    "subject.job_shared": 409,
    "key.queue_full": 429,
    "key.too_many_requests": 429,
    "key.uploads_open": 429,
    "key.limited_open": 429,
    "key.downloads_open": 429,
    "key.day_bytes": 429,
    "key.revoked": 409,
    "key.day_files": 429,
    "job.kind_unknown": 422,
    "job.not_ended": 409,
    "job.succeeded": 409,
    "request.streams_full": 429,
    "store.full": 507,
}
"""HTTP statuses of codes that their class does not determine."""

RETRY_SECONDS = 10.0
"""Value of Retry-After for 429 and 503 if the error has none [s]: a restart takes some seconds."""

CODES = {404: "request.no_such_page", 405: "request.method_not_allowed"}


class RequestBad(BadInput):
    """The request does not match the description at /docs."""

    code = "request.bad"


def error_status(error: GarmentqError) -> int:
    """Return the HTTP status of an error."""
    if error.code in STATUSES:
        return STATUSES[error.code]
    if isinstance(error, NotFound):
        return 404
    if isinstance(error, BadInput):
        return 422
    return 503 if is_service_error(error) else 500


def make_retry_header(status: int, seconds: float) -> dict[str, str]:
    """Return the Retry-After header, for statuses at which a retry can succeed."""
    return {"retry-after": str(max(1, math.ceil(seconds)))} if status in (429, 503) else {}


def make_problem(
    status: int, code: str, detail: str, retry_seconds: float = RETRY_SECONDS, findings: Sequence[Any] = ()
) -> JSONResponse:
    """Return the response for one problem, with the findings in a pattern if there are any."""
    headers = make_retry_header(status, retry_seconds)
    if status == 401:
        headers["www-authenticate"] = "Bearer"
    clean = keep_printable(detail)[:LONGEST_MESSAGE]
    body: dict[str, Any] = {"type": f"urn:garmentq:{code}", "title": code, "status": status, "code": code}
    body |= {"detail": clean} | ({"findings": list(findings)} if findings else {})
    return JSONResponse(body, status, headers, media_type=MEDIA)


def answer_error(error: GarmentqError) -> JSONResponse:
    """Return the response for one of our errors."""
    seconds, findings = getattr(error, "retry_seconds", RETRY_SECONDS), getattr(error, "findings", ())
    return make_problem(error_status(error), error.code, make_public_message(error), seconds, findings)


def describe_error(error: GarmentqError) -> dict[str, object]:
    """Return status, code and message of a refusal, for an answer that has others beside it."""
    return {"status": error_status(error), "code": error.code, "detail": make_public_message(error)}


def make_public_message(error: GarmentqError) -> str:
    """Return the message of an error for a caller; details of a fault of the service are only logged."""
    if is_service_error(error):
        log.warning("answered %s: %s", error.code, error.message)
    return show_message(error)


def add_handlers(app: FastAPI) -> None:
    """Convert every exception into a problem."""

    def on_ours(request: Request, error: Exception) -> JSONResponse:
        assert isinstance(error, GarmentqError)
        return answer_error(error)

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

    def on_gone(request: Request, error: Exception) -> JSONResponse:
        return make_problem(499, "request.gone", "the client disconnected.")

    def on_fault(request: Request, error: Exception) -> JSONResponse:
        log.error("a request failed", exc_info=error)
        return make_problem(500, "service.fault", "a fault of garmentq; please report it with the log.")

    app.add_exception_handler(GarmentqError, on_ours)
    app.add_exception_handler(RequestValidationError, on_invalid)
    app.add_exception_handler(HTTPException, on_http)
    app.add_exception_handler(ClientDisconnect, on_gone)
    app.add_exception_handler(Exception, on_fault)


def refuse(status: int, code: str, message: str) -> HTTPException:
    """Return a refusal that no outer layer changes."""
    return HTTPException(status, {"code": code, "message": message})  # type: ignore[arg-type]


REASONS = {
    400: "The body or a header cannot be read.",
    401: "No key, or an unknown one.",
    403: "The key lacks the scope, or the request comes from a page of another origin.",
    404: "Unknown, or another key's.",
    408: "The client stopped sending.",
    409: "The job is in another state.",
    413: "The body is too large.",
    415: "The body is a form instead of the file itself.",
    416: "The file has no such range.",
    422: "Bad input.",
    429: "The key exceeds a limit; wait as long as Retry-After says.",
    431: "The head of the request is too large.",
    500: "A fault of garmentq.",
    503: "Database or store is unavailable, the service is busy, or timed out; Retry-After says when to retry.",
    507: "There is no room for the file.",
}
"""Description of each refusal."""

EXAMPLE_CODES = {
    400: "request.refused", 401: "key.missing", 403: "key.scope_missing", 404: "job.unknown", 408: "request.too_slow",
    409: "job.not_ended", 413: "request.too_large", 415: "upload.not_raw", 416: "request.range", 422: "request.bad",
    429: "key.too_many_requests", 431: "request.head_too_large", 500: "service.fault",
    503: "service.database_unreachable", 507: "store.full",
}  # fmt: skip
"""An example code of each refusal."""

COMMON_REFUSAL_STATUSES = (400, 403, 431, 500, 503)
"""HTTP statuses of refusals that any route may give: for an invalid head, another origin, a fault, or a timeout."""

API_REFUSAL_STATUSES = (*COMMON_REFUSAL_STATUSES, 401, 404, 413, 422, 429)
"""HTTP statuses of refusals that any route under /v1 may give: each reads a key, a query and the database."""

PROBLEM = {"$ref": "#/components/schemas/Problem"}
"""Reference to the schema that `description.describe` adds."""

BYTES = {"type": "string", "format": "binary"}
"""Schema of a file, in a request or a response."""


def show_answer(
    value: object, status: int = 200, model: type | None = None, refusals: tuple[int, ...] = ()
) -> dict[int | str, dict[str, Any]]:
    """Describe a route's responses in OpenAPI: the successful one by example and schema, and every refusal.

    A route that reads a body adds 408: its client may stop sending.
    """
    good: dict[str, Any] = {"description": "Answer.", "content": {"application/json": {"example": hide_nulls(value)}}}
    if model is not None:
        good["model"] = model
    return {status: good, **show_refusals(*API_REFUSAL_STATUSES, *refusals)}


def show_list(name: str, items: Sequence[object]) -> dict[str, object]:
    """Return the response of a list that is returned at once, in the form of one that has pages."""
    return {name: items, "total": len(items), "next": None}


def show_bytes(description: str, media: str = BYTES_TYPE) -> dict[str, Any]:
    """Describe a response that is a file, in OpenAPI."""
    return {"description": description, "content": {media: {"schema": BYTES, "example": "(bytes)"}}}


def show_file(description: str) -> dict[str, Any]:
    """Describe a response that is a file of one of the types that results have, in OpenAPI."""
    types = [BYTES_TYPE, *sorted({one.partition(";")[0] for one in MEDIA_TYPES.values()})]
    return {"description": description, "content": {one: show_bytes("", one)["content"][one] for one in types}}


def show_refusals(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """Describe refusals in OpenAPI."""
    return {
        status: {
            "description": REASONS[status],
            "content": {MEDIA: {"schema": PROBLEM, "example": _show_problem(status)}},
        }
        for status in sorted(set(statuses))
    }


def _show_problem(status: int) -> dict[str, Any]:
    code = EXAMPLE_CODES[status]
    return {
        "type": f"urn:garmentq:{code}", "title": code, "status": status, "code": code, "detail": REASONS[status],
    }  # fmt: skip
