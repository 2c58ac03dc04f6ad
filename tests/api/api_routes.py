"""Every route of the API and every page, as the application itself knows them."""

from __future__ import annotations

from collections.abc import Iterator

from garmentq.service.api.app import make_app
from garmentq.service.pages import routes


def list_routes(settings) -> Iterator[tuple[str, str, list[dict]]]:
    """Yield method, path and parameters of each route that the OpenAPI document tells of."""
    app = make_app(settings)
    app.state.rooms.database.dispose()
    for path, methods in app.openapi()["paths"].items():
        for method, told in methods.items():
            yield method.upper(), path, [one for one in told.get("parameters", []) if one["in"] in ("path", "query")]


def list_pages() -> Iterator[tuple[str, list[str]]]:
    """Yield path and names of the query parameters of each page that is asked for by GET, but static files."""
    waiting = list(routes.router.routes)
    while waiting:
        one = waiting.pop(0)
        if router := getattr(one, "original_router", None):
            waiting += router.routes
        elif "GET" in one.methods and not one.path.startswith("/static"):
            parts = [one.dependant]
            names = []
            while parts:
                part = parts.pop()
                names += [field.alias for field in part.query_params]
                parts += part.dependencies
            yield one.path, sorted(names)
