"""Write the marker, the layout of the pieces on cloth, at 1:1."""

from __future__ import annotations

from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...garment.pieces.layout import CLOTH_WIDTH, Lay
from ...garment.pieces.naming import say_name
from ...garment.pieces.nesting import nest_on_cloth
from .drawing import keep_ascii
from .errors import SheetTooSmall
from .papers import find_paper

if TYPE_CHECKING:
    from .production import Production

MARKER_TEXT_SIZE_MM = 20.0
"""Height of letters [mm]."""


def write(production: Production, folder: Path) -> list[Path]:
    """Write `marker.svg`, and return it; the cloth is as wide as the chosen roll, or `CLOTH_WIDTH`.

    Raises:
        SheetTooSmall: where a piece is wider than the cloth.
    """
    paper = find_paper(production.options.paper)
    width = paper.width / 1e3 if paper.is_roll else CLOTH_WIDTH
    lay = nest_on_cloth(production.pieces.cut_pieces, width)
    if not lay.copies:
        raise SheetTooSmall(f"a piece is wider than cloth of {1e2 * width:.0f} cm; give --paper roll:WIDTH in mm.")
    path = folder / "marker.svg"
    path.write_text(marker_svg(lay, production.pieces.name), encoding="utf-8", newline="\n")
    return [path]


def marker_svg(lay: Lay, name: str) -> str:
    """Return the SVG text of a lay; 1 user unit is 1 mm, the warp runs upwards."""
    width, height = 1e3 * lay.width, 1e3 * lay.length
    text = f"{keep_ascii(name)}: {lay.length:.2f} m of cloth {1e2 * lay.width:.0f} cm wide, {1e2 * lay.used:.0f} % used"
    parts = [f'<path class="cloth" d="M 0 0 H {width:.1f} V {height:.1f} H 0 Z"/>']
    for copy in lay.copies:
        places = np.asarray(1e3 * copy.outline * [1.0, -1.0] + [0.0, height])
        points = " L ".join(f"{x:.3f} {y:.3f}" for x, y in places)
        x, y = (places.min(axis=0) + places.max(axis=0)) / 2.0
        parts.append(f'<path class="cut" d="M {points} Z"/>')
        name = say_name(copy.name)
        parts.append(
            f'<text x="{x:.1f}" y="{y:.1f}" font-size="{MARKER_TEXT_SIZE_MM:g}">{escape(keep_ascii(name))}</text>'
        )
    style = "path { fill: none; stroke: #000; stroke-width: 0.5; } .cloth { stroke: #888; } "
    style += "text { font-family: sans-serif; text-anchor: middle; }"
    size = f'width="{width:.3f}mm" height="{height:.3f}mm" viewBox="0 0 {width:.3f} {height:.3f}"'
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<svg xmlns="http://www.w3.org/2000/svg" {size}>\n'
        f"<title>{escape(text)}</title>\n<style>{style}</style>\n" + "\n".join(parts) + "\n</svg>\n"
    )
