"""`/fabrics`: the library of fabrics, each with a swatch that shows how it bends."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from fastapi import Response

from ...core.cloth.settings import STANDARD_GRAVITY
from ..api.access import AppStateDependency
from ..materials import is_shipped, list_materials
from .actions import draw_action, draw_frame
from .markup import Html, html, join
from .page_route import make_router
from .session import VisitorOf
from .shell import draw_shell

if TYPE_CHECKING:
    from ...core.cloth.fabric import Fabric

router = make_router()

STRIP_LENGTH = 0.10
"""Length of the strip that a swatch shows hanging over an edge [m]."""


@router.get("/fabrics")
def show_fabrics(rooms: AppStateDependency, visitor: VisitorOf) -> Response:
    """Return the page of fabrics; who administers the service imports and deletes them."""
    may_change = visitor.caller.sees_all
    rows = join(_draw_row(one, not is_shipped(one.name), may_change) for one in list_materials(rooms.database))
    content = html(PAGE, rows=rows, form=html(FORM) if may_change else Html(), frame=draw_frame())
    return draw_shell("Fabrics", content, visitor, ["actions.js"], "/fabrics")


def find_bending_length(fabric: Fabric) -> float:
    """Return the length [m] over which a fabric's bending stiffness bears its weight: (k / (w g))^(1/3)."""
    return float((fabric.k / (fabric.density * -STANDARD_GRAVITY[1])) ** (1 / 3))


def find_droop(fabric: Fabric) -> float:
    """Return the angle below the horizontal [rad] at which a strip's end hangs, by Peirce's cantilever.

    c = l (cos(a / 2) / (8 tan a))^(1/3) for the bending length c and the strip's length l.
    """
    share = (find_bending_length(fabric) / STRIP_LENGTH) ** 3
    low, high = 1e-4, math.pi / 2 - 1e-4
    for _ in range(40):
        angle = 0.5 * (low + high)
        if math.cos(angle / 2) / (8 * math.tan(angle)) > share:
            low = angle
        else:
            high = angle
    return low


def _draw_row(fabric: Fabric, is_imported: bool, may_change: bool) -> Html:
    angle = find_droop(fabric)
    x, y = 20 + 60 * math.cos(angle), 14 + 60 * math.sin(angle)
    width = min(6.0, max(1.2, 4e3 * fabric.thickness))
    swatch = html(SWATCH, x=f"{x:.1f}", y=f"{y:.1f}", at=f"{20 + 57 * math.cos(angle):.1f}", width=f"{width:.1f}")
    question = f"Delete the fabric {fabric.title or fabric.name}? Jobs that use it keep its numbers."
    delete = draw_action("Delete…", "DELETE", f"/v1/materials/{fabric.name}", question)
    sources = join(html("<li>{}: {}</li>", name, text) for name, text in fabric.sources)
    title = (fabric.title or fabric.name).replace("g/m2", "g/m²")
    return html(
        ROW, swatch=swatch, name=title, id=fabric.name, mass=f"{1e3 * fabric.density:.0f}",
        thickness=f"{1e3 * fabric.thickness:.2f}", bending=f"{1e2 * find_bending_length(fabric):.1f}",
        weft=f"{fabric.H00:.0f}", warp=f"{fabric.H11:.0f}", shear=f"{fabric.H22:.0f}",
        friction=f"{fabric.friction:.2f}", sources=sources, source="imported" if is_imported else "shipped",
        delete=delete if is_imported and may_change else Html(),
    )  # fmt: skip


PAGE = """<h1>Fabrics</h1><p class="soft">A swatch shows how a strip of 10 cm hangs over an edge.</p>{form}
<div class="wide" tabindex="0" role="region" aria-label="Fabrics"><table class="library"><thead><tr>
<th scope="col"><span class="hushed">Swatch</span></th><th scope="col">Fabric</th>
<th scope="col" class="number">g/m²</th>
<th scope="col" class="number">Thickness [mm]</th><th scope="col" class="number">Bending length [cm]</th>
<th scope="col" class="number">Weft, warp, shear [N/m]</th><th scope="col" class="number">Friction</th>
<th scope="col">Source</th><th scope="col"><span class="hushed">Actions</span></th></tr></thead>
<tbody>{rows}</tbody></table></div>{frame}"""

ROW = """<tr><td>{swatch}</td><th scope="row">{name}<br><code class="soft">{id}</code></th>
<td class="number" data-head="g/m²">{mass}</td><td class="number" data-head="Thickness [mm]">{thickness}</td>
<td class="number" data-head="Bending length [cm]">{bending}</td>
<td class="number" data-head="Weft, warp, shear [N/m]">{weft}, {warp}, {shear}</td>
<td class="number" data-head="Friction">{friction}</td>
<td><details><summary>{source}</summary><ul>{sources}</ul></details></td>
<td>{delete}</td></tr>"""

SWATCH = """<svg class="swatch" viewBox="0 0 84 78" aria-hidden="true"><path class="edge" d="M2 18h18v56"/>
<path class="cloth" stroke-width="{width}" d="M2 14H20Q{at} 14 {x} {y}"/></svg>"""

FORM = """<form class="card row" data-fabrics><label>Import fabrics
<input type="file" accept=".json" required></label><button type="submit">Import</button>
<span class="soft">JSON in SI units, one fabric or a list of them; an imported one of the same name is replaced.</span>
</form>"""
