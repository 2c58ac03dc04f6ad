"""`/base-patterns`: the templates, shipped and imported, each with a drawing of its panels."""

from __future__ import annotations

import tempfile
from functools import lru_cache
from pathlib import Path

from fastapi import Request, Response

from ..api.access import AppStateDependency
from ..catalogue import Template
from ..templates import list_templates, read_template
from .actions import draw_action, draw_frame
from .files_page import PICTURE_CACHE_CONTROL
from .garment_words import title_garment
from .markup import Html, html, join
from .page_route import make_router
from .session import VisitorOf
from .shell import Visitor, draw_shell

router = make_router()

SHIPPED = "shipped"
"""Source of a template that cannot be deleted."""

PIECE_GAP = 0.04
"""Free space between the panels of a drawing [m]."""

CURVE_SEGMENTS = 12
"""Number of lines by which a curved edge is drawn."""

DRAWING_LAYOUTS = 12
"""Number of widths among which the layout of a drawing is chosen."""


@router.get("/base-patterns")
def show_base_patterns(rooms: AppStateDependency, visitor: VisitorOf) -> Response:
    """Return the page of templates; who administers the service imports and deletes them."""
    cards = join(_draw_card(one, visitor) for one in list_templates(rooms.database))
    form = html(FORM) if visitor.caller.sees_all else Html()
    content = html(PAGE, form=form, cards=cards, frame=draw_frame())
    return draw_shell("Base patterns", content, visitor, ["actions.js"], "/base-patterns")


@router.get("/templates/{name}/drawing.svg")
def show_drawing(name: str, request: Request, rooms: AppStateDependency, visitor: VisitorOf) -> Response:
    """Return a drawing of a template's panels at one scale."""
    drawing = draw_panels(read_template(rooms, name))
    return Response(drawing, media_type="image/svg+xml", headers={"cache-control": PICTURE_CACHE_CONTROL})


@lru_cache(maxsize=256)
def draw_panels(document: bytes) -> str:
    """Return the panels of a pattern file as SVG, as square as they can be laid out."""
    import numpy as np

    from ...core.garment.curves import panel_outline
    from ...core.garment.garmentcode import load_pattern
    from ...core.garment.pieces.shelf_packing import pack_on_shelves

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "pattern.json"
        path.write_bytes(document)
        pattern = load_pattern(path)
    outlines = [panel_outline(panel, CURVE_SEGMENTS) for panel in pattern.panels]
    low = np.array([outline.min(axis=0) for outline in outlines])
    sizes = np.array([outline.max(axis=0) for outline in outlines]) - low
    widths = np.linspace(sizes[:, 0].max(), (sizes[:, 0] + PIECE_GAP).sum(), DRAWING_LAYOUTS)
    layouts = [pack_on_shelves(sizes, PIECE_GAP, float(width)) for width in widths]
    places = min(layouts, key=lambda one: float((one + sizes).max(axis=0).max()))
    width, height = (places + sizes).max(axis=0) + 2 * PIECE_GAP
    shapes = []
    for outline, corner, place in zip(outlines, low, places, strict=True):
        points = 1e3 * ((outline - corner + place + PIECE_GAP) * [1.0, -1.0] + [0.0, height])
        shapes.append(html('<polygon points="{}"/>', " ".join(f"{x:.0f},{y:.0f}" for x, y in points)))
    return html(DRAWING, width=f"{1e3 * width:.0f}", height=f"{1e3 * height:.0f}", shapes=join(shapes))


def _draw_card(template: Template, visitor: Visitor) -> Html:
    delete = Html()
    if template.source != SHIPPED and visitor.caller.sees_all:
        question = f"Delete the base pattern {template.name}? Jobs that use it keep their file."
        delete = draw_action("Delete…", "DELETE", f"/v1/templates/{template.name}", question)
    edit = html('<a class="button" href="/templates/{}/edit">Edit</a>', template.name) if visitor.may_submit else Html()
    word = title_garment(template.name) if template.source == SHIPPED else template.name
    return html(CARD, name=template.name, word=word, title=template.title, source=template.source, delete=delete,
                edit=edit)  # fmt: skip


PAGE = """<h1>Base patterns</h1>{form}<ul class="gallery patterns">{cards}</ul>{frame}"""

CARD = """<li class="family"><span class="figure"><img src="/templates/{name}/drawing.svg" alt="" loading="lazy"></span>
<div class="words"><h2>{word}</h2><p>{title}</p><p class="soft"><code>{name}</code> · {source}</p>
<p class="row">{edit}<a class="button" href="/v1/templates/{name}" download="{name}.json">Download</a>{delete}</p></div>
</li>"""

DRAWING = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" fill="#c9d8ec" stroke="#2c3646"
 stroke-width="5" stroke-linejoin="round">{shapes}</svg>"""

FORM = """<form class="card row" data-template><label>Import a pattern file
<input type="file" accept=".json" required></label><label>Name <input name="name" required maxlength="64"
 pattern="[a-z0-9][a-z0-9_.\\-]*" title="lower-case letters, digits, _ . -"></label>
<button type="submit">Import</button>
<span class="soft">GarmentCode or NeuralTailor; an imported one of the same name is replaced.</span></form>"""
