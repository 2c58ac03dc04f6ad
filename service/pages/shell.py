"""The frame of all pages: head, navigation, style and script, and the Content-Security-Policy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from fastapi.responses import HTMLResponse

from ..keys import Caller
from .markup import Html, html, join
from .static_files import find_edition, list_imports

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self'; "
    "font-src 'none'; frame-ancestors 'none'; base-uri 'none'; form-action 'self'"
)
"""A page's Content-Security-Policy: only files of this service, nothing inline, no other host."""

PLACES = (
    ("/", "Gallery"),
    ("/subjects", "Subjects"),
    ("/queue", "Queue"),
    ("/match", "Match"),
    ("/fabrics", "Fabrics"),
    ("/base-patterns", "Base patterns"),
    ("/webhooks", "Webhooks"),
    ("/keys", "Keys"),
    ("/docs", "API"),
)
"""The navigation: address and title of each page that needs no job."""

ADMIN_PLACES = ("/keys",)
"""Addresses in `PLACES` that only the scope `admin` may open."""


@dataclass(frozen=True)
class Visitor:
    """Describe the visitor of a page.

    Attributes:
        caller: The visitor's permissions.
        csrf: Token that the visitor's pages send with each change.
    """

    caller: Caller
    csrf: str

    @property
    def may_submit(self) -> bool:
        """Return whether the visitor may queue and change jobs."""
        return "submit" in self.caller.scopes or self.caller.sees_all


def draw_shell(
    title: str,
    content: Html,
    visitor: Visitor | None = None,
    scripts: Sequence[str] = (),
    place: str = "",
    status: int = 200,
    data: str = "",
) -> HTMLResponse:
    """Return a page.

    Args:
        title: Title of the page; escaped here.
        content: Content of its `<main>`.
        visitor: Visitor of the page; None: without a session, so there is no navigation.
        scripts: Modules that it loads, by their names in `static`.
        place: The address in `PLACES` that it belongs to.
        status: The response's status.
        data: Address of what the scripts read first; empty: nothing.

    Modules, their imports and the data are listed in the head, so that a browser requests all of them at once. The
    referrer policy lets a form send its origin to this service, and nothing to any other.
    """
    links = [
        html('<a href="{}"{}>{}</a>', url, Html(' aria-current="page"' if url == place else ""), name)
        for url, name in PLACES
        if url not in ADMIN_PLACES or (visitor is not None and visitor.caller.sees_all)
    ]
    page = html(
        TEMPLATE,
        title=title,
        edition=find_edition(),
        csrf=html('<meta name="csrf-token" content="{}">', visitor.csrf) if visitor else Html(),
        scripts=_draw_scripts(scripts, data),
        navigation=html(NAVIGATION, links=join(links), csrf=visitor.csrf) if visitor else Html(),
        content=content,
    )
    return HTMLResponse(page, status, {"content-security-policy": POLICY, "referrer-policy": "same-origin"})


def _draw_scripts(scripts: Sequence[str], data: str) -> Html:
    preloads = [html('<link rel="preload" as="fetch" crossorigin="anonymous" href="{}">', data)] if data else []
    imported = dict.fromkeys(module for name in scripts for module in list_imports(name))
    preloads += [html('<link rel="modulepreload" href="/static/{}/{}">', find_edition(), name) for name in imported]
    module = '<script type="module" src="/static/{}/{}"></script>'
    return join([*preloads, *(html(module, find_edition(), name) for name in scripts)])


TEMPLATE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>{title} – garmentq</title>
{csrf}
<link rel="icon" href="/static/{edition}/icon.svg" type="image/svg+xml">
<link rel="stylesheet" href="/static/{edition}/style.css">
<link rel="stylesheet" href="/static/{edition}/gallery.css">
<link rel="stylesheet" href="/static/{edition}/result.css">
{scripts}
</head>
<body>
<a class="skip" href="#main">Skip to content</a>
<header class="top"><a class="brand" href="/">garmentq</a>{navigation}</header>
<main id="main" tabindex="-1">
{content}
</main>
</body>
</html>
"""

NAVIGATION = """<nav aria-label="Pages">{links}</nav>
<form class="signout" method="post" action="/signout"><input type="hidden" name="csrf" value="{csrf}">
<button type="submit">Sign out</button></form>"""
