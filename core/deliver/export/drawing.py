"""Draw a pattern for the report: to scale, seams in matching colours, open edges thick."""

from __future__ import annotations

from html import escape

import numpy as np

from ...garment.curves import edge_points
from ...garment.pattern import EdgeRef, Pattern
from ...garment.pieces.shelf_packing import pack_on_shelves
from ...geometry.curves import polyline_length, resample_polyline

DRAWING_SCALE_DENOMINATOR = 10
"""Ratio of true size to that in the report's drawing: at 1:10 a dress's pieces fit the width of a page."""

REPORT_SHEET_WIDTH = 1.75
"""Width of the sheet [m]: 175 mm on paper at 1:10, the width inside an A4 page's margins."""

REPORT_PIECE_GAP = 0.06
"""Space between pieces [m], for their labels."""

PALETTE = ("#2f6f9f", "#c2571a", "#3d8b4f", "#8f4b9b", "#b8860b", "#c0395b", "#2a8c8c", "#6b5b3e", "#5566cc", "#7a9a01")
"""Colours of the seams, different in lightness as well as hue, in addition to the number beside each."""

REPORT_CURVE_SEGMENT_COUNT = 24
"""Number of straight segments of a curved edge in the report."""

MIN_LABELLED_EDGE_LENGTH = 0.06
"""Shortest edge that is labelled with its length [m]; on a shorter one the number would be longer than the edge."""

MIN_LABELLED_PANEL_WIDTH = 0.10
"""Smallest width of a panel that is labelled with its size [m]; a narrower one is labelled with its name alone."""


def pattern_drawing(pattern: Pattern) -> str:
    """Return an inline SVG of the pattern at 1:10; both sides of a seam have one colour and one number."""
    outlines = [[edge_points(p, i, _segments(e.kind)) for i, e in enumerate(p.edges)] for p in pattern.panels]
    low = np.array([np.concatenate(lines).min(axis=0) for lines in outlines])
    sizes = np.array([np.concatenate(lines).max(axis=0) for lines in outlines]) - low
    corners = pack_on_shelves(sizes, REPORT_PIECE_GAP, REPORT_SHEET_WIDTH) + REPORT_PIECE_GAP / 2
    width = max(REPORT_SHEET_WIDTH, float((corners[:, 0] + sizes[:, 0]).max()) + REPORT_PIECE_GAP / 2)
    corners[:, 1] += REPORT_PIECE_GAP  # room for the scale bar below the lowest shelf
    height = float((corners[:, 1] + sizes[:, 1]).max()) + REPORT_PIECE_GAP
    sides = {side: n for n, seam in enumerate(pattern.seams) for side in (seam.a, seam.b)}
    parts = []
    for panel, lines, origin, place, size in zip(pattern.panels, outlines, low, corners, sizes, strict=True):
        drawn = [_to_page(line - origin + place, height) for line in lines]
        parts.append(f'<path class="cloth" d="{_path(np.concatenate([line[:-1] for line in drawn]))} Z"/>')
        for index, line in enumerate(drawn):
            parts.append(_edge(line, sides.get(EdgeRef(panel.name, index))))
        middle = _to_page(_polygon_centroid(np.concatenate([line[:-1] for line in lines])) - origin + place, height)
        parts.append(_name(panel.name, middle, size))
    parts.append(_scale_bar(height * 1e3))
    sheet = (
        f'width="{width * 1e3 / DRAWING_SCALE_DENOMINATOR:.1f}mm" '
        f'height="{height * 1e3 / DRAWING_SCALE_DENOMINATOR:.1f}mm"'
    )
    box = f'viewBox="0 0 {width * 1e3:.0f} {height * 1e3:.0f}"'
    return f'<svg xmlns="http://www.w3.org/2000/svg" class="pattern" {sheet} {box}>{"".join(parts)}</svg>'


def _segments(kind: str) -> int:
    return 1 if kind == "line" else REPORT_CURVE_SEGMENT_COUNT


def _to_page(points: np.ndarray, height: float) -> np.ndarray:
    """Convert metres with y up to millimetres with y down."""
    return (points * [1.0, -1.0] + [0.0, height]) * 1e3


def _path(points: np.ndarray) -> str:
    return "M " + " L ".join(f"{x:.1f} {y:.1f}" for x, y in points)


def _polygon_centroid(outline: np.ndarray) -> np.ndarray:
    """Return the centroid of a polygon, shape [2]."""
    following = np.roll(outline, -1, axis=0)
    cross = outline[:, 0] * following[:, 1] - following[:, 0] * outline[:, 1]
    return np.asarray(((outline + following) * cross[:, None]).sum(axis=0) / (3.0 * cross.sum()))


def _edge(line: np.ndarray, seam: int | None) -> str:
    """Draw one edge: an open one thick and dark, a seam in its colour with its number beside its middle."""
    if seam is None:
        return f'<path class="open" d="{_path(line)}"/>' + _length(line, "#1d2733")
    colour = PALETTE[seam % len(PALETTE)]
    half = len(line) // 2
    before, after = line[half - 1], line[half]
    at = 0.5 * (before + after) if len(line) == 2 else line[half]
    along = (after - before) / max(float(np.linalg.norm(after - before)), 1e-9)
    label = at + 16.0 * np.array([-along[1], along[0]]) * -1.0  # 16 mm to the inner side
    return (
        f'<path class="seam" stroke="{colour}" d="{_path(line)}"/>'
        f'<text class="seam-number" fill="{colour}" x="{label[0]:.1f}" y="{label[1]:.1f}">{seam + 1}</text>'
    ) + _length(line, colour)


def _name(name: str, middle: np.ndarray, size: np.ndarray) -> str:
    """Draw a panel's name, and its width and height [cm] below where there is room."""
    x, y = middle
    if size.min() < MIN_LABELLED_PANEL_WIDTH:
        return f'<text class="name small" x="{x:.1f}" y="{y:.1f}">{escape(name)}</text>'
    text = f'<text class="name" x="{x:.1f}" y="{y:.1f}">{escape(name)}</text>'
    width, height = 100.0 * size
    return text + f'<text class="size" x="{x:.1f}" y="{y + 26.0:.1f}">{width:.1f} × {height:.1f} cm</text>'


def _length(line: np.ndarray, colour: str) -> str:
    """Draw an edge's length [cm] outside it, along it; not on short edges."""
    length = polyline_length(line)
    if length < 1e3 * MIN_LABELLED_EDGE_LENGTH:
        return ""
    at, ahead = resample_polyline(line, 21)[[5, 6]]  # a quarter along, where no seam's number is
    along = (ahead - at) / max(float(np.linalg.norm(ahead - at)), 1e-9)
    place = at + 13.0 * np.array([-along[1], along[0]])
    angle = float(np.degrees(np.arctan2(along[1], along[0])))
    angle = angle - 180.0 if angle > 90.0 else angle + 180.0 if angle < -90.0 else angle
    x, y = place
    turn = f'transform="rotate({angle:.1f} {x:.1f} {y:.1f})"'
    return f'<text class="length" fill="{colour}" x="{x:.1f}" y="{y:.1f}" {turn}>{length / 10.0:.1f}</text>'


def _scale_bar(bottom: float) -> str:
    """Draw 20 cm in the lower left corner [mm]."""
    y = bottom - 14.0
    return (
        f'<path class="bar" d="M 14 {y - 8:.1f} V {y:.1f} H 214 V {y - 8:.1f} M 114 {y:.1f} v -5"/>'
        f'<text class="bar-text" x="222" y="{y + 4:.1f}">20 cm</text>'
    )
