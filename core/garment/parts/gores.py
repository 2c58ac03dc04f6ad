"""Draft skirts of equal gores around the wearer (H. Joseph-Armstrong, Patternmaking for Fashion Design)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ..measures import BodyMeasures
from ..outline import (
    PLACEMENT_DEPTH,
    Outline,
    Point,
    Stroke,
    draw_monotone_spline,
    place_panel,
    reverse_strokes,
    swap_side_label,
)
from ..pattern import Panel
from .cut import Cut
from .upper_edge import UpperEdge

GORED_SKIRT_LENGTH = 0.54
"""Length of a gored skirt from waist to hem [m]: that of an A-line skirt."""

HIP_EASE = 0.05
"""Ease of its girth at the hip [m]: that of an A-line skirt."""

USUAL_SWEEP = 1.7
"""Whole angle of a skirt's gores laid side by side [rad] where no scan shows it: the hem is 1.7 m wide, as that of an
A-line skirt of four panels."""


@dataclass(frozen=True)
class Gore:
    """Describe one of a skirt's `count` equal gores: symmetric, with straight sides where these clear the hip. `side`
    is half its width [m] and the height over the waist [m] at the hem, at the hip and at the waist."""

    count: int
    side: tuple[Point, Point, Point]

    @classmethod
    def of(cls, cut: Cut, quarter: float, m: BodyMeasures) -> Gore:
        """Return a gore of a cut with a quarter of the waist of a given length [m]."""
        count = cut.panels_around
        sweep = USUAL_SWEEP if cut.sweep is None else cut.sweep
        slope, top = math.tan(sweep / count / 2), 2 * quarter / count
        hip_line = m.hip_height - m.waist_height
        hip = max(top - slope * hip_line, (m.hip + HIP_EASE) / count / 2)
        return cls(
            count, ((hip + slope * (GORED_SKIRT_LENGTH + hip_line), -GORED_SKIRT_LENGTH), (hip, hip_line), (top, 0.0))
        )

    def draw_side(self, label: str, sign: float = 1.0) -> list[Stroke]:
        """Draw the side at the left (sign 1) or the right (-1), upwards; its edges are numbered in the label."""
        return draw_monotone_spline([(sign * x, y) for x, y in self.side], [label.format(i) for i in range(2)])


def draw_gores(edge: UpperEdge, gore: Gore) -> list[Panel]:
    """Draw a skirt's gores, each placed in front of its part of the wearer, turned towards it. The first is in front
    beside the right side seam, the others follow towards the left and around. A seam is named by its number from the
    middle of its face."""
    half = gore.count // 2
    places = [("front", n - (half - 1) / 2) for n in range(half)]
    places += [("back", -offset) for _, offset in places]
    return [_draw(edge, gore, number, *place) for number, place in enumerate(places)]


def _draw(edge: UpperEdge, gore: Gore, number: int, face: str, offset: float) -> Panel:
    """Draw one gore: its hem, the side towards the next one, its upper edge, and the side towards the last one.
    `number` counts around the wearer; `offset` is the distance of its middle from the face's [gores], positive to the
    wearer's left."""
    next_one = 0.5 if face == "front" else -0.5
    after, before = (_label_seam(gore.count, face, offset + step) for step in (next_one, -next_one))
    (hem, low), (top, _) = gore.side[0], gore.side[-1]
    start, hem_line = (-hem, low), Stroke((hem, low), contour="hem")
    down = reverse_strokes(Outline(start, tuple(gore.draw_side(before, -1.0))))
    strokes = (hem_line, *gore.draw_side(after), *_draw_top(edge, face, offset, top), *down)
    drawn = place_panel("gore", Outline(start, strokes), edge.height)
    angle = (number + 0.5) * 2.0 * math.pi / gore.count - math.pi / 2
    outward = np.array([math.sin(angle), 0.0, math.cos(angle)])
    turn = np.stack([np.cross((0.0, 1.0, 0.0), outward), (0.0, 1.0, 0.0), outward], axis=1)
    place = PLACEMENT_DEPTH * outward + (0.0, edge.height, 0.0)
    name = face if offset == 0.0 else f"{face}_{math.ceil(abs(offset))}_{_side(offset)}"
    return replace(drawn, name=name, rotation=turn, translation=place)


def _draw_top(edge: UpperEdge, face: str, offset: float, top: float) -> list[Stroke]:
    """Draw a gore's upper edge towards the last one, labelled by its seam; a middle gore's is cut at the middle."""
    if not edge.name:
        return [Stroke((-top, 0.0), contour="waist")]
    labels = edge.labels(face)
    label = labels[int(abs(offset))]
    if offset:
        return [Stroke((-top, 0.0), label=label if offset > 0.0 else swap_side_label(label))]
    first, second = (label, swap_side_label(label)) if face == "front" else (swap_side_label(label), label)
    return [Stroke((0.0, 0.0), label=first), Stroke((-top, 0.0), label=second)]


def _label_seam(count: int, face: str, offset: float) -> str:
    """Return the label of a seam, with a place for the number of its edge, by its distance from the middle in gores."""
    if abs(offset) == count / 4:
        return f"side.{{}}.{_side(offset)}"
    if offset == 0.0:
        return f"centre.{face}.{{}}"
    return f"gore.{face}.{math.ceil(abs(offset))}.{{}}.{_side(offset)}"


def _side(offset: float) -> str:
    """Return the side of the wearer for a distance from the middle."""
    return "left" if offset > 0.0 else "right"
