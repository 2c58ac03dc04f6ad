"""`/docs`: the description of every route as one page without scripts, so that no other server is contacted."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from html import escape
from typing import Any

STYLE = """
:root{color-scheme:light dark;--page:#f7f8fa;--card:#fff;--sunk:#eef0f4;--line:#d4d9e1;--text:#1b2230;--accent:#2459a6}
@media(prefers-color-scheme:dark){:root{--page:#12161d;--card:#1b212b;--sunk:#242c38;--line:#39434f;--text:#e7ebf1;
--accent:#8ab4f2}}
body{font:15px/1.5 system-ui,sans-serif;margin:0;color:var(--text);background:var(--page)}
header{display:flex;flex-wrap:wrap;gap:.25rem 1rem;padding:.75rem 1rem;background:var(--card);
border-bottom:1px solid var(--line)}header a:first-child{font-weight:700;color:inherit;text-decoration:none}
main{max-width:60rem;margin:1rem auto;padding:0 1rem}a{color:var(--accent)}
:focus-visible{outline:3px solid var(--accent);outline-offset:2px}
h2::first-letter{text-transform:uppercase}
h2{margin-top:2.5rem;border-bottom:1px solid var(--line)}summary{cursor:pointer;padding:.4rem 0;overflow-wrap:anywhere}
code,pre{font:14px/1.4 ui-monospace,monospace}pre{background:var(--sunk);padding:.7rem;overflow:auto}
table{border-collapse:collapse;width:100%}td,th{border-top:1px solid var(--line);padding:.3rem .6rem;text-align:left;
vertical-align:top;overflow-wrap:anywhere}b{display:inline-block;min-width:4.5rem}
"""
DIGEST = base64.b64encode(hashlib.sha256(STYLE.encode()).digest()).decode()
POLICY = f"default-src 'none'; style-src 'sha256-{DIGEST}'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
"""The page's Content-Security-Policy: its own style and nothing else; no script runs in it, whatever a text
contains."""

CODE = re.compile("`([^`]+)`")

METHODS = ("get", "post", "put", "patch", "delete")


def draw_page(described: dict[str, Any]) -> str:
    """Return the page of an OpenAPI document."""
    info = described["info"]
    groups: dict[str, list[str]] = {}
    for path, routes in (described["paths"] | described.get("webhooks", {})).items():
        for method in METHODS:
            if method in routes:
                group = (routes[method].get("tags") or ["other"])[0]
                groups.setdefault(group, []).append(_draw_route(method, path, routes[method]))
    schemas = described.get("components", {}).get("schemas", {})
    parts = [
        '<!doctype html><html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width">',
        f"<title>{escape(info['title'])}</title><style>{STYLE}</style></head><body>",
        '<header><a href="/">garmentq</a><a href="/">Back to the gallery</a></header><main>',
        f"<h1>{escape(info['title'])} {escape(info['version'])}</h1>",
        *(f"<p>{_draw_text(text)}</p>" for text in info.get("description", "").split("\n\n")),
        "<p>A request carries <code>Authorization: Bearer TOKEN</code>: an API key, or on a service of this machine ",
        "without keys the content of <code>api.token</code> in its home. For programs: ",
        '<a href="/openapi.json">openapi.json</a>.</p>',
    ]
    for group, routes in groups.items():
        parts += [f"<h2>{escape(group)}</h2>", *routes]
    parts.append("<h2>Schemas</h2>")
    parts += [
        f'<details id="{escape(name)}"><summary>{escape(name)}</summary>{_draw_json(schema)}</details>'
        for name, schema in sorted(schemas.items())
    ]
    return "\n".join([*parts, "</main></body></html>"])


def _draw_route(method: str, path: str, route: dict[str, Any]) -> str:
    parts = [
        f"<details><summary><b>{method.upper()}</b><code>{escape(path)}</code> {escape(route.get('summary', ''))}",
        f"</summary><p>{_draw_text(route.get('description', ''))}</p>",
    ]
    if route.get("parameters"):
        rows = [_draw_parameter(one) for one in route["parameters"]]
        parts.append(f"<table><tr><th>parameter</th><th>in</th><th></th></tr>{''.join(rows)}</table>")
    for media, body in route.get("requestBody", {}).get("content", {}).items():
        parts.append(f"<p>Body, <code>{escape(media)}</code>:</p>{_draw_json(body.get('schema', {}))}")
    for status, answer in sorted(route.get("responses", {}).items()):
        parts.append(f"<p>{escape(status)}: {escape(answer.get('description', ''))}</p>")
        for media, body in answer.get("content", {}).items() if status < "300" else ():
            parts.append(f"<p><code>{escape(media)}</code></p>")
            parts += [_draw_json(body["example"])] if "example" in body else []
    return "".join([*parts, "</details>"])


def _draw_text(text: str) -> str:
    """Return a text with its words in backquotes as code."""
    return CODE.sub(r"<code>\1</code>", escape(text))


def _draw_parameter(one: dict[str, Any]) -> str:
    text = one.get("description") or json.dumps(one.get("schema", {}))
    needed = " (required)" if one.get("required") else ""
    cells = f"<code>{escape(one['name'])}</code>{needed}", escape(one["in"]), _draw_text(text)
    return f"<tr>{''.join(f'<td>{cell}</td>' for cell in cells)}</tr>"


def _draw_json(value: object) -> str:
    return f"<pre>{escape(json.dumps(value, indent=1, ensure_ascii=False))}</pre>"
