"""`/healthz`, `/readyz` and `/metrics`, for monitoring."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any

from fastapi import APIRouter
from fastapi.responses import JSONResponse, PlainTextResponse, Response

from ... import __version__
from ...core.run.errors import GarmentqError
from ..health import find_troubles, hide_worker_names, read_queue
from ..metrics import prometheus_text
from ..shown_errors import show_message
from .access import AppState, AppStateDependency, Watcher
from .answers import Health, Readiness
from .problems import API_REFUSAL_STATUSES, COMMON_REFUSAL_STATUSES, make_problem, show_answer, show_refusals

log = logging.getLogger(__name__)

router = APIRouter(tags=["health"])

READY: dict[str, Any] = {
    "model": Readiness, "description": "Answer.",
    "content": {"application/json": {"example": {"database": "ok", "store": "ok", "troubles": []}}},
}  # fmt: skip
HEALTHY: dict[int | str, dict[str, Any]] = {
    200: show_answer({"status": "ok", "version": __version__}, 200, Health)[200],
}


@router.get(
    "/healthz", summary="Check that the process runs.", responses={**HEALTHY, **show_refusals(*COMMON_REFUSAL_STATUSES)}
)
async def show_health() -> Any:
    """Answer without reading database or store."""
    return {"status": "ok", "version": __version__}


@router.get(
    "/readyz", summary="Check that database and store can be used.",
    responses={200: READY, **show_refusals(*COMMON_REFUSAL_STATUSES)},
)  # fmt: skip
async def show_readiness(rooms: AppStateDependency) -> Response:
    """Answer 503 if database or store is unavailable: then no job can be accepted. Nothing is written.

    `troubles` lists what keeps jobs from running; jobs are accepted nevertheless.
    """
    return await rooms.lanes.watching.run(_look, rooms)


def _look(rooms: AppState) -> Response:
    found: dict[str, str] = {}
    troubles: list[str] = []
    faults: list[str] = []
    checks: dict[str, Callable[[], list[str] | None]] = {
        "database": lambda: find_troubles(hide_worker_names(read_queue(rooms.database))),
        "store": lambda: rooms.store.check(rooms.settings.free_bytes),
    }
    for name, check in checks.items():
        try:
            troubles += check() or []
            found[name] = "ok"
        except GarmentqError as error:
            log.warning("not ready: %s: %s", error.code, error.message)
            found[name] = error.code
            faults.append(f"{name} {error.code}: {show_message(error)}")
    if set(found.values()) == {"ok"}:
        return JSONResponse(found | {"troubles": troubles})
    return make_problem(503, "service.not_ready", " ".join(faults))


@router.get(
    "/metrics", summary="Return the Prometheus metrics.", response_class=PlainTextResponse,
    responses={
        200: {"description": "Metrics.", "content": {"text/plain": {"example": 'garmentq_jobs{state="queued"} 3'}}},
        **show_refusals(*API_REFUSAL_STATUSES),
    },
)  # fmt: skip
def show_metrics(rooms: AppStateDependency, caller: Watcher) -> Response:
    """Return metrics of all keys' jobs, of this process's answers and of the store; requires the scope `metrics`."""
    parts = [prometheus_text(rooms.database), rooms.times.format_metrics(), rooms.store_size.format_metrics()]
    return PlainTextResponse("".join(parts), media_type="text/plain; version=0.0.4")
