"""The report of a garment on another body: both wearers, verdicts and numbers, in one HTML file."""

from __future__ import annotations

import base64
from html import escape

import numpy as np

from ...reuse.wear.dressing import DressedGarment
from ...reuse.wear.ease import Ease
from ...reuse.wear.worn import WornGarment
from .judged_page import Heading, gates_html, head_html, manifest_html, numbers_html
from .page import page_html
from .person import composite_on_white
from .picture import Camera, ColouredMesh, aim_camera, png_base64, render_meshes, rotate_view
from .views import CLOTH_COLOUR, DRAPE_COLOUR, SKIN_COLOUR, error_colours

WEARER_VIEW_WIDTH_PX, WEARER_VIEW_HEIGHT_PX = 300, 480
"""Size of one of the pictures [pixel]: three views of two wearers are a page wide."""

MAX_SHOWN_STRAIN, MAX_SHOWN_PRESSURE = 0.1, 1000.0
"""Upper ends of the colour scales of strain (share of the cloth's length) and of pressure [Pa]: cloth stretched by a
tenth is tight, and a tight waistband presses by 1 kPa."""

WEARER_VIEW_ANGLES = (0.0, 0.5 * np.pi, np.pi)
"""Angles about the vertical from which a wearer is drawn: front, right side, back."""


def draw_wearers(dressed: DressedGarment) -> bytes:
    """Return a PNG with the rows first wearer, new one, strain and pressure; in columns front, side and back."""
    strain, pressure = dressed.strain / MAX_SHOWN_STRAIN, dressed.pressure / MAX_SHOWN_PRESSURE
    rows = [draw_wearer(dressed.before, CLOTH_COLOUR), draw_wearer(dressed.worn, DRAPE_COLOUR, dressed.inner)]
    rows += [draw_wearer(dressed.worn, error_colours(np.clip(share, 0.0, 1.0))) for share in (strain, pressure)]
    return base64.b64decode(png_base64(np.concatenate(rows, axis=0)))


def draw_wearer(worn: WornGarment, colour: np.ndarray, inner: WornGarment | None = None) -> np.ndarray:
    """Draw a wearer in a garment from all sides, uint8, shape [height, 3 width, 4 or 3].

    Args:
        worn: The garment.
        colour: Its colour, one or one of each node.
        inner: The garment below it, in the colour of scanned cloth, or None.
    """
    body = worn.body
    surfaces = [
        ColouredMesh(body.vertices, body.faces, SKIN_COLOUR),
        ColouredMesh(worn.garment.nodes, worn.garment.faces, colour),
    ]
    if inner is not None:
        surfaces.append(ColouredMesh(inner.garment.nodes, inner.garment.faces, CLOTH_COLOUR))
    return np.concatenate(
        [composite_on_white(render_meshes(surfaces, aim_at(worn, turn))) for turn in WEARER_VIEW_ANGLES], axis=1
    )


def aim_at(worn: WornGarment, turn: float) -> Camera:
    """Return a camera that shows a wearer whole, turned by an angle about the vertical [rad]."""
    points = np.concatenate([worn.body.vertices, worn.garment.nodes])
    return aim_camera(points, rotate_view(worn.body.heading, turn), WEARER_VIEW_WIDTH_PX, WEARER_VIEW_HEIGHT_PX)


def report_dressed(dressed: DressedGarment, picture: bytes) -> str:
    """Return the whole report as the text of one HTML file; every name that comes from a file is escaped.

    Args:
        dressed: The garment on the other body.
        picture: PNG of both wearers from `draw_wearers`.
    """
    return page_html(
        f"{dressed.worn.category} on {dressed.worn.body.source}",
        [
            _header(dressed),
            _pictures(picture),
            gates_html(dressed.report.gates),
            ease_html(dressed.ease),
            numbers_html(dressed.report.metrics),
            manifest_html(dressed.report.manifest),
        ],
    )


def _header(dressed: DressedGarment) -> str:
    worn = dressed.worn
    facts = {
        "Category": worn.category,
        "Template": worn.template,
        "Fabric": worn.fabric.title or worn.fabric.name,
        "First wearer": dressed.before.body.source,
        "Wearer": worn.body.source,
        "CPU time": f"{dressed.report.cpu_seconds:.0f} s",
    }
    if dressed.inner is not None:
        facts["Worn over"] = dressed.inner.pattern.name or dressed.inner.category
    heading = Heading("worn again", worn.pattern.name or worn.category, facts)
    return head_html(heading, dressed.report.gates, dressed.report.warnings)


def _pictures(picture: bytes) -> str:
    data = base64.b64encode(picture).decode("ascii")
    return (
        "<section><h2>Wearers</h2><p class='hint'>From above: the wearer that the garment was recovered from; the new "
        "one; the cloth's strain, dark from 10 %; its pressure on the body, dark from 1 kPa.</p>"
        f'<img alt="both wearers, front, side and back" src="data:image/png;base64,{data}"></section>'
    )


def ease_html(ease: tuple[Ease, ...]) -> str:
    """Return the table of both girths and the ease at each place; empty where there is none."""
    rows = "".join(
        f"<tr><td>{escape(one.place.replace('_', ' '))}</td><td class=num>{1e3 * one.garment:.0f}</td>"
        f"<td class=num>{1e3 * one.body:.0f}</td><td class=num>{1e3 * one.value:+.0f}</td></tr>"
        for one in ease
    )
    head = "<tr><th>Girth [mm]</th><th class=num>Garment</th><th class=num>Body</th><th class=num>Ease</th></tr>"
    return f"<section><h2>Ease</h2><table>{head}{rows}</table></section>" if rows else ""
