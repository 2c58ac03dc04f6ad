"""The application: rooms, routes, guard."""

from __future__ import annotations

from typing import Any

from fastapi import Depends, FastAPI

from ... import __version__
from ..database import open_database
from ..settings import ServiceSettings
from ..stores import open_store
from . import batches, events, health, jobs, keys, materials, questions, results, templates, uploads
from .access import Rooms, refuse_unknown
from .answers import Problem
from .guard import Guard
from .limits import ApiLimits
from .meter import Meter
from .problems import add_handlers

DESCRIPTION = """From the 3D scan of a garment to a sewing pattern, a simulation mesh and a detailed mesh.

Upload a scan, ask for a job with its hash, follow the job's events, download its files. Errors are problem+json with a
stable `code`."""


def make_app(settings: ServiceSettings, limits: ApiLimits | None = None, is_open: bool = True) -> FastAPI:
    """Make the application of a home.

    Args:
        settings: Which home.
        limits: What a request may cost.
        is_open: Let the local user in without a key while there are no keys; only for a loopback address.

    Raises:
        DatabaseUnreachable: where the database cannot be opened.
    """
    limits = limits or ApiLimits()
    app = FastAPI(title="garmentq", version=__version__, description=DESCRIPTION, redoc_url=None)
    meter = Meter(limits)
    app.state.rooms = Rooms(settings, open_database(settings), open_store(settings), limits, is_open, meter)
    for module in (uploads, batches, jobs, events, results, questions, templates, materials, keys):
        app.include_router(module.router, prefix="/v1", dependencies=[Depends(refuse_unknown)])
    app.include_router(health.router)
    add_handlers(app)
    app.add_middleware(Guard, limits=limits, is_open=is_open)
    app.openapi = lambda: describe(app)  # type: ignore[method-assign]
    return app


def describe(app: FastAPI) -> dict[str, Any]:
    """Return the OpenAPI document, with the schema that every refusal refers to."""
    if not app.openapi_schema:
        found = FastAPI.openapi(app)
        found["components"]["schemas"]["Problem"] = Problem.model_json_schema()
    assert app.openapi_schema is not None
    return app.openapi_schema
