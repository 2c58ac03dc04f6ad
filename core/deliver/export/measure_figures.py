"""Draw how measures are taken: lines on a body seen from three sides, and lines on the panels of a garment."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from html import escape

import numpy as np

from ...body.body_tape import BodyMeasure, MeasuredFigure
from ...garment.pattern import Pattern
from ...garment.pieces.finished_points import FinishedMeasure
from ...garment.pieces.flatten import flatten_outline
from ...garment.pieces.shelf_packing import pack_on_shelves
from .picture import ColouredMesh, aim_camera, png_base64, render_meshes
from .views import SKIN_COLOUR

FIGURE_HEIGHT_PX = 900
"""Height of a body's picture [pixel]: a page's."""

FIGURE_WIDTH_PX = 560
"""Width of each of its views [pixel]: arms at 45 degrees have room."""

LIST_WIDTH_PX = 560
"""Width of the list of measures beside a figure [pixel]."""

LIST_LINE_PX = 22
"""Distance of the lines of the list [pixel]."""

MARK_SIZE_PX = 13
"""Size of a measure's number in a figure [pixel]."""

PANEL_GAP = 0.04
"""Free space between the panels of a garment's figure [m]."""

PANEL_SHEET_WIDTH = 1.6
"""Width of the sheet on which the panels of a garment's figure lie [m]."""

SIDES = (("front", 0.0), ("back", np.pi), ("side", -np.pi / 2.0))
"""The views of a body, and the turn of the body in each [rad]."""

BEHIND = ("neck_width", "back_width", "waist_back_width", "hip_back_width", "back_waist_length", "seat_span")
"""Measures that are taken behind the body."""

IN_PROFILE = ("back_waist_length", "front_waist_length")
"""Measures that the side view shows, too."""

FIGURE_STYLE = (
    "text{font:14px sans-serif;fill:#1d1d1f}.head{font-weight:bold}.line{fill:none;stroke:#b3261e;stroke-width:2.2}"
    ".mark{font-size:13px;font-weight:bold;fill:#b3261e;paint-order:stroke;"
    "stroke:#fff;stroke-width:4px}.panel{fill:#f4f1ea;stroke:#1d1d1f;stroke-width:1}"
)


@dataclass(frozen=True)
class _Row:
    """Describe a line of the list beside a figure."""

    name: str
    value: str
    how: str


def body_figure_svg(figure: MeasuredFigure) -> str:
    """Return an SVG of a body from the front, the back and the side with the numbered lines of its measures, and their
    list."""
    body = figure.standing
    parts: list[str] = []
    scale: float | None = None
    marks: list[tuple[float, float]] = []
    for column, (title, turn) in enumerate(SIDES):
        camera = aim_camera(body.vertices, _turn(turn), FIGURE_WIDTH_PX, FIGURE_HEIGHT_PX)
        scale = camera.pixels_per_metre if scale is None else scale
        camera = replace(camera, pixels_per_metre=scale)
        picture = png_base64(render_meshes([ColouredMesh(body.vertices, body.faces, SKIN_COLOUR)], camera))
        left = column * FIGURE_WIDTH_PX
        parts.append(
            f'<image x="{left}" y="0" width="{FIGURE_WIDTH_PX}" height="{FIGURE_HEIGHT_PX}" '
            f'href="data:image/png;base64,{picture}"/>'
            f'<text class="head" x="{left + 12}" y="24">{title}</text>'
        )
        for number, one in enumerate(figure.measures, 1):
            for line in one.lines if title in _views_of(one.name) else ():
                seen = line @ camera.rotation.T
                x = left + FIGURE_WIDTH_PX / 2.0 + (seen[:, 0] - camera.centre[0]) * scale
                y = FIGURE_HEIGHT_PX / 2.0 - (seen[:, 1] - camera.centre[1]) * scale
                parts.append(_drawn(np.stack([x, y], axis=1), number, marks))
    rows = [_Row(one.name, _body_value(one), one.how) for one in figure.measures]
    return _document(parts, rows, len(SIDES) * FIGURE_WIDTH_PX, FIGURE_HEIGHT_PX)


def garment_figure_svg(pattern: Pattern, measures: Sequence[FinishedMeasure], is_listed: bool = True) -> str:
    """Return an SVG of a garment's panels with the numbered lines of its finished measures, and their list if asked."""
    outlines = {panel.name: flatten_outline(panel)[0] for panel in pattern.panels}
    lows = np.array([outline.min(axis=0) for outline in outlines.values()])
    sizes = np.array([np.ptp(outline, axis=0) for outline in outlines.values()])
    corners = pack_on_shelves(sizes, PANEL_GAP, PANEL_SHEET_WIDTH) + PANEL_GAP
    extent = (corners + sizes).max(axis=0) + PANEL_GAP
    scale = min(3 * FIGURE_WIDTH_PX / extent[0], FIGURE_HEIGHT_PX / extent[1])
    shifts = dict(zip(outlines, corners - lows, strict=True))

    def place(name: str, points: np.ndarray) -> np.ndarray:
        moved = points + shifts[name]
        return np.stack([scale * moved[:, 0], scale * (extent[1] - moved[:, 1])], axis=1)

    parts: list[str] = []
    marks: list[tuple[float, float]] = []
    for name, outline in outlines.items():
        points = " ".join(f"{x:.1f},{y:.1f}" for x, y in place(name, outline))
        x, y = place(name, outline).mean(axis=0)
        parts.append(f'<polygon class="panel" points="{points}"/><text x="{x:.0f}" y="{y:.0f}">{escape(name)}</text>')
    for number, one in enumerate(measures, 1):
        parts += [_drawn(place(name, line), number, marks) for name, line in one.lines]
    rows = [_Row(str(one.point), f"{100.0 * one.value:.1f} cm", one.how) for one in measures if is_listed]
    return _document(parts, rows, round(scale * float(extent[0])), round(scale * float(extent[1])))


def _turn(angle: float) -> np.ndarray:
    """Return the camera's rotation that looks at a body turned by an angle [rad], shape [3, 3]."""
    return np.array([[np.cos(angle), 0.0, np.sin(angle)], [0.0, 1.0, 0.0], [-np.sin(angle), 0.0, np.cos(angle)]])


def _views_of(name: str) -> tuple[str, ...]:
    """Return the views that show a measure."""
    return ("back" if name in BEHIND else "front", *(("side",) if name in IN_PROFILE else ()))


def _drawn(points: np.ndarray, number: int, marks: list[tuple[float, float]]) -> str:
    """Return a line with its number at the end that is furthest right, below other numbers there."""
    path = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    x, y = (float(value) for value in points[points[:, 0].argmax()])
    while any(abs(x - other) < MARK_SIZE_PX and abs(y - top) < MARK_SIZE_PX for other, top in marks):
        y += MARK_SIZE_PX
    marks.append((x, y))
    return f'<polyline class="line" points="{path}"/><text class="mark" x="{x + 3:.1f}" y="{y + 4:.1f}">{number}</text>'


def _body_value(one: BodyMeasure) -> str:
    if not np.isfinite(one.value):
        return "none"
    return f"{np.degrees(one.value):.1f}°" if one.is_angle else f"{100.0 * one.value:.1f} cm"


def _document(parts: list[str], rows: Sequence[_Row], width: int, height: int) -> str:
    tall = max(height, LIST_LINE_PX * (len(rows) + 2))
    listed = []
    for number, row in enumerate(rows, 1):
        y = LIST_LINE_PX * (number + 1)
        listed.append(
            f'<text class="mark" x="{width + 12}" y="{y}">{number}</text>'
            f'<text class="head" x="{width + 42}" y="{y}">{escape(row.name)}</text>'
            f'<text x="{width + 262}" y="{y}" text-anchor="end">{escape(row.value)}</text>'
            f'<text x="{width + 276}" y="{y}">{escape(row.how)}</text>'
        )
    whole = width + (LIST_WIDTH_PX + 276 if rows else 0)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{whole}" height="{tall}" viewBox="0 0 {whole} {tall}">'
        f'<style>{FIGURE_STYLE}</style><rect width="{whole}" height="{tall}" fill="#fff"/>{"".join(parts)}'
        f"{''.join(listed)}</svg>\n"
    )
