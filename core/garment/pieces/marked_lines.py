"""Lines that are marked on a piece: centre front and back, and the levels of bust, waist and hips."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..panel_parts import Side, find_arm_panels, find_side
from ..pattern import EdgeRef, Pattern
from .doubled import is_lined
from .flatten import flatten_edge, flatten_outline
from .piece import MarkedLine, Piece
from .seam_names import name_seam

CENTRE_NAMES: Mapping[Side, str] = {Side.FRONT: "CF", Side.BACK: "CB"}
"""Names of the middle of a piece by its side of the wearer."""

CENTRE_SEAM_NAMES: Mapping[str, str] = {
    "centre front seam": "CF", "front zip": "CF", "front buttons": "CF", "centre back seam": "CB",
    "skirt centre front seam": "CF", "skirt centre back seam": "CB",
}  # fmt: skip
"""Names of the middle by the seam that lies there."""

MIN_LEVEL_LENGTH = 0.03
"""Smallest length of a level's line within a piece [m]: a shorter one shows no direction."""


@dataclass(frozen=True)
class PanelLevel:
    """Describe where a level of the body lies on a panel: `bust`, `waist` or `hip`, the panel, and a point of the level
    in the panel's own axes [m], shape [2]."""

    name: str
    panel: str
    point: np.ndarray


def mark_lines(pattern: Pattern, piece: Piece, axis: float | None, levels: Sequence[PanelLevel]) -> Piece:
    """Return a piece with its marked lines.

    Args:
        pattern: Its pattern.
        piece: The piece; sleeves, bands and collars get no lines.
        axis: The x of its middle where it is symmetric to an upright line [m], or None.
        levels: Levels of the body on the pattern's panels.
    """
    names = [place.panel for place in piece.places]
    if not names or is_lined(pattern, names) or not find_arm_panels(pattern).keys().isdisjoint(names):
        return piece
    outline, lines = flatten_outline(piece.net)[0], []
    side = CENTRE_NAMES.get(find_side(pattern.panel(names[0])))
    if axis is not None and side is not None:
        ys = _crossings(outline[:, ::-1], axis)
        if len(ys) >= 2:
            lines.append(MarkedLine(side, np.array([[axis, ys[0]], [axis, ys[-1]]])))
    lines += _mark_centre_seams(pattern, piece)
    places = {place.panel: place for place in piece.places if np.linalg.det(place.rotation) > 0.0}
    for name in dict.fromkeys(level.name for level in levels):
        heights = [
            float((places[level.panel].rotation @ level.point + places[level.panel].translation)[1])
            for level in levels
            if level.name == name and level.panel in places
        ]
        xs = _crossings(outline, float(np.mean(heights))) if heights else []
        if len(xs) >= 2 and xs[-1] - xs[0] > MIN_LEVEL_LENGTH:
            y = float(np.mean(heights))
            lines.append(MarkedLine(name, np.array([[xs[0], y], [xs[-1], y]])))
    return replace(piece, lines=tuple(lines))


def _crossings(outline: np.ndarray, height: float) -> list[float]:
    """Return where a closed line crosses a level, in order [m]."""
    ends = np.roll(outline, -1, axis=0)
    hit = (outline[:, 1] <= height) != (ends[:, 1] <= height)
    start, end = outline[hit], ends[hit]
    share = (height - start[:, 1]) / (end[:, 1] - start[:, 1])
    return sorted(float(x) for x in start[:, 0] + share * (end[:, 0] - start[:, 0]))


def _mark_centre_seams(pattern: Pattern, piece: Piece) -> list[MarkedLine]:
    """Return the edges of a piece that are sewn or closed at the middle of the wearer."""
    by_edge: dict[EdgeRef, str] = {}
    for seam in pattern.seams:
        name = CENTRE_SEAM_NAMES.get(name_seam(pattern, seam).name)
        if name is not None:
            by_edge |= {seam.a: name, seam.b: name}
    return [
        MarkedLine(by_edge[edge.source], flatten_edge(piece.net, i))
        for i, edge in enumerate(piece.edges)
        if edge.source in by_edge
    ]
