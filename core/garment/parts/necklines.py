"""Draft necklines: half of one from the side neck point to the middle of a front or a back. Their lines follow W.
Aldrich, Metric Pattern Cutting for Women's Wear, and H. Joseph-Armstrong, Patternmaking for Fashion Design: a round one
leaves the shoulder at a right angle and is level in the middle, a V is nearly straight, a square one falls along the
grain, a boat follows the shoulder far out and dips little. Depths are chosen so that each passes the head."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..outline import Point, Stroke, stroke_points
from .cut import Neckline

FRONT_DEPTH = {
    Neckline.CREW: 0.10,
    Neckline.SCOOP: 0.14,
    Neckline.V: 0.17,
    Neckline.SQUARE: 0.13,
    Neckline.BOAT: 0.04,
}
"""Depth of a front neckline below the side neck point [m]: a V ends at the height of the armpits, a boat at the pit of
the neck; a crew neck of 10 cm passes the head where the cloth does not stretch."""

BACK_DEPTH = {
    Neckline.CREW: 0.025,
    Neckline.SCOOP: 0.08,
    Neckline.V: 0.12,
    Neckline.SQUARE: 0.07,
    Neckline.BOAT: 0.02,
}
"""The same of a back neckline [m]; 2.5 cm is the height of the nape below the side neck point."""

BOAT_SHARE = 0.5
"""Share of the shoulder seam that a boat neckline leaves bare."""

SQUARE_SLANT = 0.1
"""Share of its half width by which a square neckline narrows to its corner, so that it does not gape."""


@dataclass(frozen=True)
class NecklineCut:
    """Describe the cut of a neckline at one face of a garment: its kind, the depth of its middle below the side neck
    point [m], and the height of a V's side over its chord [chords], negative towards the middle."""

    kind: Neckline
    depth: float
    bow: float = 0.0

    @classmethod
    def at_front(cls, kind: Neckline, depth: float | None = None) -> NecklineCut:
        """Return a front neckline, by default of its usual depth."""
        return cls(kind, FRONT_DEPTH[kind] if depth is None else depth)

    @classmethod
    def at_back(cls, kind: Neckline, depth: float | None = None) -> NecklineCut:
        """Return a back neckline, by default of its usual depth."""
        return cls(kind, BACK_DEPTH[kind] if depth is None else depth)


def side_neck(kinds: tuple[Neckline, Neckline], neck: Point, tip: Point) -> Point:
    """Return the side neck point of front and back, on the shoulder's line.

    Args:
        kinds: Of the front and of the back: if one is a boat, both begin far out.
        neck: The side neck point of other necklines [m].
        tip: The shoulder's tip [m].
    """
    if Neckline.BOAT not in kinds:
        return neck
    return (neck[0] + BOAT_SHARE * (tip[0] - neck[0]), neck[1] + BOAT_SHARE * (tip[1] - neck[1]))


def draw_neckline(cut: NecklineCut, neck: Point) -> list[Stroke]:
    """Draw half a neckline from the side neck point to the middle, x = 0."""
    low = neck[1] - cut.depth
    middle = (0.0, low)
    if cut.kind is Neckline.V:
        return [Stroke(middle, _parabola_handles(neck, middle, cut.bow), contour="neck")]
    if cut.kind is Neckline.SQUARE:
        corner = ((1.0 - SQUARE_SLANT) * neck[0], low)
        return [Stroke(corner, contour="neck"), Stroke(middle, contour="neck")]
    handles = ((neck[0] - 0.1 * neck[0], neck[1] - 0.55 * cut.depth), (0.55 * neck[0], low))
    return [Stroke(middle, handles, contour="neck")]


def _parabola_handles(start: Point, end: Point, bow: float) -> tuple[Point, Point]:
    """Return the handles of a cubic that is a parabola of height `bow` chords over its chord; a line if that is 0."""
    (x, y), (u, v) = start, end
    along, left = (u - x, v - y), (-(v - y), u - x)
    lift = 4.0 / 3.0 * bow
    first, second = (
        (x + share * along[0] + lift * left[0], y + share * along[1] + lift * left[1]) for share in (1 / 3, 2 / 3)
    )
    return (first, second)


def neckline_points(cut: NecklineCut, half_width: float, segments: int = 32) -> np.ndarray:
    """Return points of half a neckline, from (half_width, 0) to (0, -depth), uniform on each stroke [m]."""
    start: Point = (half_width, 0.0)
    lines = []
    for stroke in draw_neckline(cut, start):
        lines.append(stroke_points(start, stroke, segments))
        start = stroke.end
    return np.concatenate(lines)


def corner_turn(cut: NecklineCut, half_width: float) -> float:
    """Return the turn of a whole neckline at its middle [rad]: 0 where it is level there, positive in a V."""
    ends = neckline_points(cut, half_width)[-2:]
    across, down = np.abs(ends[1] - ends[0])
    return float(2 * np.arctan2(down, across))
