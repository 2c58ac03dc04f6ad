"""Write all garments of a person on a body: a folder for each, and one report."""

from __future__ import annotations

import base64
from html import escape
from pathlib import Path

import numpy as np

from ...reuse.wear.outfit import DressedOutfit
from .dressed import write_garment
from .dressed_report import WEARER_VIEW_ANGLES, aim_at, ease_html
from .judged_page import Heading, gates_html, head_html, manifest_html, numbers_html
from .page import page_html
from .person import composite_on_white
from .picture import ColouredMesh, png_base64, render_meshes
from .result import write_body, write_json
from .views import CLOTH_COLOUR, DRAPE_COLOUR, REDRAPE_COLOUR, SCAN_COLOUR, SKIN_COLOUR

OUTFIT_COLOURS = (CLOTH_COLOUR, DRAPE_COLOUR, REDRAPE_COLOUR, SCAN_COLOUR)
"""Colours of the garments from the innermost to the outermost: blue, green, sand, grey."""


def write_outfit(outfit: DressedOutfit, folder: Path) -> list[Path]:
    """Write meshes, patterns, numbers and report of all garments of a person on a body.

    Args:
        outfit: The garments.
        folder: Folder, created if missing; files of the same names are replaced.

    Returns:
        The files: in a folder for each garment, by its word, those of `write_garment`; body.ply, body_joints.json,
            metrics.json, manifest.json, picture.png, report.html.
    """
    folder.mkdir(parents=True, exist_ok=True)
    files = [file for word, one in outfit.garments.items() for file in write_garment(one, folder / word)]
    files += write_body(outfit.body, folder)
    files.append(write_json(outfit.report.metrics, folder / "metrics.json"))
    files.append(write_json(outfit.report.manifest, folder / "manifest.json"))
    picture, report = folder / "picture.png", folder / "report.html"
    picture.write_bytes(draw_outfit(outfit))
    report.write_text(report_outfit(outfit, picture.read_bytes()), encoding="utf-8")
    return [*files, picture, report]


def draw_outfit(outfit: DressedOutfit) -> bytes:
    """Return a PNG of the wearer in all garments: front, side and back."""
    body, worn = outfit.body, [one.worn for one in outfit.garments.values()]
    surfaces = [ColouredMesh(body.vertices, body.faces, SKIN_COLOUR)]
    for place, one in enumerate(worn):
        surfaces.append(ColouredMesh(one.garment.nodes, one.garment.faces, OUTFIT_COLOURS[place % len(OUTFIT_COLOURS)]))
    views = [composite_on_white(render_meshes(surfaces, aim_at(worn[0], turn))) for turn in WEARER_VIEW_ANGLES]
    return base64.b64decode(png_base64(np.concatenate(views, axis=1)))


def report_outfit(outfit: DressedOutfit, picture: bytes) -> str:
    """Return the whole report as the text of one HTML file; every name that comes from a file is escaped.

    Args:
        outfit: The garments on the body.
        picture: PNG of them from `draw_outfit`.
    """
    words = list(outfit.garments)
    seconds = f"{outfit.report.cpu_seconds:.0f} s"
    facts = {"Garments": ", ".join(words), "Wearer": outfit.body.source, "CPU time": seconds}
    for word, one in outfit.garments.items():
        facts[word.capitalize()] = f"{one.worn.template}, {one.worn.fabric.title or one.worn.fabric.name}"
    heading = Heading("worn again", f"{' under '.join(words)}", facts)
    data = base64.b64encode(picture).decode("ascii")
    shown = (
        "<section><h2>Wearer</h2><p class='hint'>The innermost garment blue, the next ones green and sand.</p>"
        f'<img alt="all garments, front, side and back" src="data:image/png;base64,{data}"></section>'
    )
    tables = [f"<h2>{escape(word)}</h2>{ease_html(one.ease)}" for word, one in outfit.garments.items() if one.ease]
    return page_html(
        f"{', '.join(words)} on {outfit.body.source}",
        [
            head_html(heading, outfit.report.gates, outfit.report.warnings),
            shown,
            gates_html(outfit.report.gates),
            *tables,
            numbers_html(outfit.report.metrics),
            manifest_html(outfit.report.manifest),
        ],
    )
