"""`/v1/jobs/batch`: many orders in one request, each with a result of its own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from functools import partial
from typing import Annotated, Any

from fastapi import APIRouter, Header, Request
from starlette.concurrency import run_in_threadpool

from ...core.run.errors import GarmentqError
from ..keys import Caller
from ..shown_errors import is_service_error
from ..submission import SubmissionResult
from .access import AppState, AppStateDependency, Submitter
from .answers import Ordered
from .jobs import ASKED, calls_limited, create_one
from .problems import RequestBad, describe_error, show_answer
from .schemas import DerivedIn, JobIn, OrdersIn

router = APIRouter(prefix="/jobs", tags=["jobs"])

MAX_BATCH_TOKEN_LENGTH = 120
"""Largest length of the Idempotency-Key of a batch [letters]; each order's own has the order's number after it."""

REFUSED = {"status": 404, "code": "upload.unknown", "detail": "This key has not uploaded such a file; upload it first."}
EXAMPLE = {"results": [{"job": ASKED | {"understood": None}, "error": None}, {"job": None, "error": REFUSED}]}

BatchToken = Annotated[
    str | None,
    Header(max_length=MAX_BATCH_TOKEN_LENGTH, pattern=r"^[!-~]+$", description="Makes a repeated request safe."),
]


@router.post(
    "/batch", name="create_jobs", summary="Create many jobs.", responses=show_answer(EXAMPLE, 200, Ordered, (408, 507))
)
async def create_all(
    payload: OrdersIn,
    request: Request,
    rooms: AppStateDependency,
    caller: Submitter,
    idempotency_key: BatchToken = None,
) -> Any:
    """Queue up to 100 jobs, each as by itself: the results are in the order of the orders, a job or a refusal.

    An order that is refused does not keep the others from being queued. A request that is repeated with the same
    Idempotency-Key returns the jobs that it made, and queues the rest.
    """
    orders = dict(enumerate(payload.orders))
    read_before = {number: order for number, order in orders.items() if calls_limited(rooms, order)}
    others = {number: order for number, order in orders.items() if number not in read_before}
    results = await run_in_threadpool(_create_all, rooms, caller, others, idempotency_key)
    for number, order in read_before.items():
        results[number] = await _create_limited(request, rooms, caller, order, _number_token(idempotency_key, number))
    return {"results": [results[number] for number in orders]}


def _create_all(
    rooms: AppState, caller: Caller, orders: Mapping[int, JobIn | DerivedIn], token: str | None
) -> dict[int, dict[str, Any]]:
    """Create the jobs of orders by their numbers, and return the results."""
    results = {}
    for number, order in orders.items():
        try:
            caller.check_priority(order.priority)
            results[number] = _show(create_one(rooms, caller, order, _number_token(token, number)))
        except GarmentqError as error:
            results[number] = _refuse(error)
    return results


async def _create_limited(
    request: Request, rooms: AppState, caller: Caller, order: JobIn | DerivedIn, token: str | None
) -> dict[str, Any]:
    """Create the job of an order whose document is checked before, in a limited process, and return the result."""
    try:
        caller.check_priority(order.priority)
        if isinstance(order, JobIn):
            raise RequestBad("a batch reads no files before it queues them; leave 'check' out.")
        return _show(await rooms.limited.run(request, caller.key, partial(create_one, rooms, caller, order, token)))
    except GarmentqError as error:
        return _refuse(error)


def _number_token(token: str | None, number: int) -> str | None:
    """Return the Idempotency-Key of one order."""
    return None if token is None else f"{token}#{number}"


def _show(done: SubmissionResult) -> dict[str, Any]:
    return {"job": asdict(done), "error": None}


def _refuse(error: GarmentqError) -> dict[str, Any]:
    """Return the result of an order that was refused; a fault of the service ends the request."""
    if is_service_error(error):
        raise error
    return {"job": None, "error": describe_error(error)}
