"""The OpenAPI document: what FastAPI makes of the routes, with the messages to webhooks and every refusal typed."""

from __future__ import annotations

from typing import Any

from fastapi import FastAPI
from fastapi.routing import APIRoute

from .answers import Problem
from .messages import EXAMPLE

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
        _put_examples(app, found)
        problem = Problem.model_json_schema(ref_template="#/components/schemas/{model}")
        found["components"]["schemas"] |= {**problem.pop("$defs"), "Problem": problem}
    assert app.openapi_schema is not None
    return app.openapi_schema


def _put_examples(app: FastAPI, found: dict[str, Any]) -> None:
    """Put every route's examples in as they were written: FastAPI leaves out what is null in them."""
    for route in app.routes:
        if isinstance(route, APIRoute) and route.include_in_schema:
            for method in route.methods:
                shown = found["paths"][route.path_format][method.lower()]["responses"]
                for status, answer in route.responses.items():
                    for media, content in answer.get("content", {}).items():
                        if "example" in content:
                            shown[str(status)]["content"][media]["example"] = content["example"]
    for route in found["webhooks"].values():
        route["post"]["requestBody"]["content"]["application/json"]["example"] = EXAMPLE
