"""The OpenAPI document: FastAPI's document of the routes, with webhook messages and the schema of every refusal."""

from __future__ import annotations

from typing import Any

from fastapi import FastAPI
from fastapi.routing import APIRoute

from .answers import Problem
from .nulls import show_nulls

SERVERS = [{"url": "/", "description": "The service that serves this document."}]
"""Where the routes are; relative, because a service does not know the names under which it is reached."""


def name_operation(route: APIRoute) -> str:
    """Return the id of a route: its name, a verb and a noun; a test checks that each id is unique."""
    return route.name


def describe(app: FastAPI) -> dict[str, Any]:
    """Return the OpenAPI document, with the schemas that every refusal refers to."""
    if not app.openapi_schema:
        found = show_nulls(FastAPI.openapi(app)) | {"servers": SERVERS}
        problem = Problem.model_json_schema(ref_template="#/components/schemas/{model}")
        found["components"]["schemas"] |= {**problem.pop("$defs"), "Problem": problem}
        app.openapi_schema = found
    return app.openapi_schema
