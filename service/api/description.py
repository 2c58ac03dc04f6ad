"""The OpenAPI document: what FastAPI makes of the routes, with the messages to webhooks and every refusal typed."""

from __future__ import annotations

from typing import Any

from fastapi import FastAPI
from fastapi.routing import APIRoute

from .answers import Problem

SERVERS = [{"url": "/", "description": "The service that serves this document."}]
"""Where the routes are; relative, for a service does not know the names that it is reached by."""


def name_operation(route: APIRoute) -> str:
    """Return the id of a route: its name, a verb and a noun; a test holds that each is there once."""
    return route.name


def describe(app: FastAPI) -> dict[str, Any]:
    """Return the OpenAPI document, with the schemas that every refusal refers to."""
    if not app.openapi_schema:
        found = FastAPI.openapi(app)
        found["servers"] = SERVERS
        problem = Problem.model_json_schema(ref_template="#/components/schemas/{model}")
        found["components"]["schemas"] |= {**problem.pop("$defs"), "Problem": problem}
    assert app.openapi_schema is not None
    return app.openapi_schema
