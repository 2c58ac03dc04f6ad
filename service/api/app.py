"""The FastAPI application: state, routes, guard."""

from __future__ import annotations

import os
import re
from collections.abc import Collection
from contextlib import suppress

from fastapi import Depends, FastAPI
from fastapi.middleware.cors import CORSMiddleware
from fastapi.responses import HTMLResponse

from ... import __version__
from ...core.run.errors import Unavailable
from ..database import open_database
from ..local_token import make_local_token
from ..pages import routes as pages
from ..pages.page_route import add_error_pages
from ..settings import ServiceSettingBad, ServiceSettings
from ..store_size import StoreSize
from ..stores import open_store
from . import (
    batches,
    events,
    health,
    inspection,
    jobs,
    keys,
    labels,
    match,
    materials,
    messages,
    order_batch,
    patterns,
    persons,
    questions,
    renaming,
    results,
    shares,
    subjects,
    tagged,
    templates,
    uploads,
    webhooks,
)
from .access import AppState, refuse_text, refuse_unknown
from .description import describe, name_operation
from .guard import Guard
from .limited_calls import LimitedCalls
from .limits import ApiLimits
from .meter import Meter
from .page import POLICY, draw_page
from .problems import add_handlers
from .proxies import ProxyHeaders, read_proxies
from .request_times import RequestTimer, RequestTimes
from .threads import ThreadPools

DESCRIPTION = """From the 3D scan of a garment to a sewing pattern, a simulation mesh and a detailed mesh.

Upload a scan, create a job with its hash, follow the job's events, download its files. Errors are problem+json with a
stable `code`."""


def make_app(
    settings: ServiceSettings, limits: ApiLimits | None = None, is_open: bool = True, hosts: Collection[str] = ()
) -> FastAPI:
    """Return the application of a home.

    Args:
        settings: Settings of the home.
        limits: Limits of requests.
        is_open: True if it listens on a loopback address. Without `hosts`, the home's token then authenticates the
            local user while no keys exist.
        hosts: Host names under which a proxy on this machine calls it.

    Raises:
        DatabaseUnreachable: if the database cannot be opened.
        ServiceSettingBad: if the environment names an invalid origin or proxy.
    """
    limits = limits or ApiLimits()
    app = FastAPI(
        title="garmentq", version=__version__, description=DESCRIPTION, docs_url=None, redoc_url=None,
        generate_unique_id_function=name_operation,
    )  # fmt: skip
    meter, store = Meter(limits), open_store(settings)
    if not settings.is_store_remote:  # a bucket is made by `garmentq db upgrade`
        with suppress(Unavailable):  # `/readyz` reports an unavailable store
            store.prepare()
    token = make_local_token(settings.home) if is_open and not hosts else ""
    calls, lanes = LimitedCalls(limits, meter), ThreadPools()
    database, times = open_database(settings), RequestTimes()
    size = StoreSize(database, settings)
    app.state.rooms = AppState(settings, database, store, limits, token, meter, calls, lanes, times, size)
    libraries = (match, patterns, templates, materials, keys, persons, webhooks, shares, subjects, tagged)
    for module in (
        uploads,
        inspection,
        batches,
        order_batch,
        jobs,
        renaming,
        labels,
        events,
        results,
        questions,
        *libraries,
    ):
        app.include_router(module.router, prefix="/v1", dependencies=[Depends(refuse_unknown), Depends(refuse_text)])
    app.include_router(health.router)
    app.webhooks.include_router(messages.router)
    app.include_router(pages.router)
    add_handlers(app)
    add_error_pages(app)
    app.add_middleware(Guard, limits=limits, is_open=is_open, hosts=hosts)
    app.add_middleware(ProxyHeaders, proxies=read_proxies())
    app.add_route("/docs", lambda request: show_page(app), include_in_schema=False)
    if origins := read_origins():
        app.add_middleware(
            CORSMiddleware,
            allow_origins=origins,
            allow_methods=["GET", "POST", "PUT", "PATCH", "DELETE"],
            allow_headers=["authorization", "content-type", "idempotency-key", "x-content-sha256", "last-event-id"],
            expose_headers=["etag", "location", "retry-after", "x-request-id"],
        )
    app.add_middleware(RequestTimer, times=times)
    app.openapi = lambda: describe(app)  # type: ignore[method-assign]
    return app


def read_origins() -> list[str]:
    """Return the origins of pages that may use the service: GARMENTQ_API_ORIGINS, separated by commas; none by default.

    Raises:
        ServiceSettingBad: if one is not an origin; `*` is not.
    """
    chosen = [one.strip() for one in os.environ.get("GARMENTQ_API_ORIGINS", "").split(",") if one.strip()]
    for one in chosen:
        if not re.fullmatch(r"https?://[A-Za-z0-9.-]+(:\d{1,5})?", one):
            raise ServiceSettingBad(
                f"GARMENTQ_API_ORIGINS names '{one[:80]}'; write https://HOST or https://HOST:PORT."
            )
    return chosen


def show_page(app: FastAPI) -> HTMLResponse:
    """Return the page that describes every route."""
    return HTMLResponse(draw_page(app.openapi()), headers={"content-security-policy": POLICY})
