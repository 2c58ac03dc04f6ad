"""Write a pattern as SVG at true scale: 1 user unit is 1 mm, curves are real curves, ids are panel and edge names."""

from __future__ import annotations

import re
from collections.abc import Callable
from html import escape
from pathlib import Path

import numpy as np

from ...garment.curves import edge_points, panel_outline
from ...garment.meshing import points_in_polygon
from ...garment.pattern import Panel, Pattern
from ...garment.pieces.shelf_packing import pack_on_shelves
from ...garment.svg_path import edge_path

PATTERN_SVG_SHEET_WIDTH = 1.4
"""Width of the sheet [m]: the usable width of common cloth."""

PATTERN_SVG_PIECE_GAP = 0.03
"""Free space between pieces [m]: room for seam allowances on both."""

SVG_NOTCH_LENGTH_MM = 6.0
"""Length of a notch [mm], as cut in practice."""

STYLE = """
.cloth { fill: #f4f1ea; stroke: none; }
.edge { fill: none; stroke: #1d1d1f; stroke-width: 0.6; }
.grain, .notch, .bar { fill: none; stroke: #1d1d1f; stroke-width: 0.4; }
text { font-family: sans-serif; fill: #1d1d1f; text-anchor: middle; }
text { paint-order: stroke; stroke: #f4f1ea; stroke-width: 3; }
.name { font-size: 12px; }
.note { font-size: 7px; }
"""


def write_svg(pattern: Pattern, path: str | Path) -> Path:
    """Write the pattern's pieces, arranged without overlap, and return the file's path. Each piece is seen from the
    cloth's outside. A panel's group has the panel's name as id; its edges have the ids `PANEL.INDEX`, and the author's
    label as `data-label`. Characters that are not allowed in ids become `_`."""
    path = Path(path)
    path.write_text(pattern_svg(pattern), encoding="utf-8")
    return path


def pattern_svg(pattern: Pattern) -> str:
    """Return the SVG text of `write_svg`."""
    outlines = [panel_outline(panel, 32) for panel in pattern.panels]
    low = np.array([outline.min(axis=0) for outline in outlines])
    sizes = np.array([outline.max(axis=0) for outline in outlines]) - low
    corners = pack_on_shelves(sizes, PATTERN_SVG_PIECE_GAP, PATTERN_SVG_SHEET_WIDTH) + PATTERN_SVG_PIECE_GAP
    corners[:, 1] += PATTERN_SVG_PIECE_GAP  # the scale bar is below the lowest shelf
    width = max(float((corners[:, 0] + sizes[:, 0]).max()) + PATTERN_SVG_PIECE_GAP, 0.2)
    height = float((corners[:, 1] + sizes[:, 1]).max()) + PATTERN_SVG_PIECE_GAP
    ids = _unique_ids([panel.name for panel in pattern.panels])
    parts = [
        _panel_group(panel, name, outline, corner - origin, height)
        for panel, name, outline, corner, origin in zip(pattern.panels, ids, outlines, corners, low, strict=True)
    ]
    size = (
        f'width="{width * 1e3:.3f}mm" height="{height * 1e3:.3f}mm" viewBox="0 0 {width * 1e3:.3f} {height * 1e3:.3f}"'
    )
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<svg xmlns="http://www.w3.org/2000/svg" {size}>\n'
        f"<title>{escape(_printable(pattern.name))}</title>\n<style>{STYLE}</style>\n"
        + "\n".join(parts)
        + f"\n{_scale_bar(height * 1e3)}\n</svg>\n"
    )


def _panel_group(panel: Panel, name: str, outline: np.ndarray, offset: np.ndarray, height: float) -> str:
    def page(points: np.ndarray) -> np.ndarray:
        found: np.ndarray = ((points + offset) * [1.0, -1.0] + [0.0, height]) * 1e3
        return found

    count = len(panel.points)
    commands, edges = [], []
    for index, edge in enumerate(panel.edges):
        start, end = panel.points[index], panel.points[(index + 1) % count]
        along = end - start
        left = np.array([-along[1], along[0]])
        handles = start + edge.handles[:, :1] * along + edge.handles[:, 1:] * left
        drawn = page(np.concatenate([[start], handles, [end]]))
        command = edge_path(edge, drawn)
        commands.append(command)
        note = f' data-label="{escape(_printable(edge.label), quote=True)}"' if edge.label else ""
        note += f' data-contour="{escape(_printable(edge.contour), quote=True)}"' if edge.contour else ""
        edges.append(f'<path class="edge" id="{name}.{index}"{note} d="M {_pair(drawn[0])} {command}"/>')
    cloth = f'<path class="cloth" id="{name}.outline" d="M {_pair(page(panel.points[:1])[0])} {" ".join(commands)} Z"/>'
    notches = [_notch(panel, edge, at, page) for edge, at in panel.notches]
    middle, room = _roomiest_point(outline)
    half = max(room, 0.25 * float(np.ptp(outline[:, 1]))) * 0.8
    grain = np.array([-np.sin(panel.grainline), np.cos(panel.grainline)])
    ends = page(np.stack([middle - half * grain, middle + half * grain]))
    place = page(middle[None])[0]
    texts = f'<text class="name" x="{place[0]:.2f}" y="{place[1]:.2f}">{escape(_printable(panel.name))}</text>'
    if panel.label:
        texts += (
            f'<text class="note" x="{place[0]:.2f}" y="{place[1] + 10:.2f}">{escape(_printable(panel.label))}</text>'
        )
    grainline = f'<path class="grain" id="{name}.grainline" d="{_arrow(ends[0], ends[1])}"/>'
    title = f"<title>{escape(_printable(panel.name))}</title>"
    return f'<g id="{name}">{title}\n{cloth}\n' + "\n".join([*edges, *notches, grainline, texts]) + "\n</g>"


def _notch(panel: Panel, edge: int, at: float, page: Callable[[np.ndarray], np.ndarray]) -> str:
    """Draw a notch: a short line from the edge inwards."""
    points = edge_points(panel, edge, 200)
    place = min(max(round(at * 200), 1), 199)
    along = page(points[place + 1 : place + 2])[0] - page(points[place - 1 : place])[0]
    inwards = np.array([along[1], -along[0]]) / np.linalg.norm(along)  # the cloth is to the left of its edge
    start = page(points[place : place + 1])[0]
    return f'<path class="notch" d="M {_pair(start)} L {_pair(start + SVG_NOTCH_LENGTH_MM * inwards)}"/>'


def _roomiest_point(outline: np.ndarray) -> tuple[np.ndarray, float]:
    """Find the point inside that is furthest from the outline [m], on a grid of 25 x 25, and that distance."""
    low, high = outline.min(axis=0), outline.max(axis=0)
    x, y = (np.linspace(low[k], high[k], 27)[1:-1] for k in (0, 1))
    grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    inside = points_in_polygon(outline, grid)
    grid = grid[inside] if inside.any() else outline.mean(axis=0)[None]
    step = np.roll(outline, -1, axis=0) - outline
    offset = grid[:, None] - outline
    part = np.clip((offset * step).sum(axis=-1) / np.maximum((step**2).sum(axis=-1), 1e-18), 0.0, 1.0)
    distance = np.linalg.norm(offset - part[..., None] * step, axis=-1).min(axis=1)
    best = int(distance.argmax())
    return grid[best], float(distance[best])


def _arrow(start: np.ndarray, end: np.ndarray) -> str:
    """Draw a line with a head at both ends."""
    along = (end - start) / max(float(np.linalg.norm(end - start)), 1e-9)
    side = np.array([-along[1], along[0]])
    heads = [
        f"M {_pair(tip + 4 * back + 2 * side)} L {_pair(tip)} L {_pair(tip + 4 * back - 2 * side)}"
        for tip, back in ((start, along), (end, -along))
    ]
    return f"M {_pair(start)} L {_pair(end)} " + " ".join(heads)


def _scale_bar(bottom: float) -> str:
    y = bottom - 15.0
    return (
        f'<g id="scale-bar"><path class="bar" id="scale-bar.10cm" d="M 30 {y:.2f} L 130 {y:.2f}"/>'
        f'<path class="bar" d="M 30 {y - 3:.2f} V {y + 3:.2f} M 130 {y - 3:.2f} V {y + 3:.2f}"/>'
        f'<text class="note" x="80" y="{y - 3:.2f}">10 cm</text></g>'
    )


def _unique_ids(names: list[str]) -> list[str]:
    """Return unique names that XML allows as ids."""
    ids = ["scale-bar"]
    for name in names:
        base = re.sub(r"[^A-Za-z0-9_-]", "_", name) or "_"
        base = base if re.match(r"[A-Za-z_]", base) else "_" + base
        unique, number = base, 2
        while unique in ids:
            unique, number = f"{base}-{number}", number + 1
        ids.append(unique)
    return ids[1:]


def _printable(text: str) -> str:
    """Drop the control characters that XML forbids."""
    return "".join(c for c in text if c.isprintable())


def _pair(point: np.ndarray) -> str:
    return f"{point[0]:.6f} {point[1]:.6f}"
