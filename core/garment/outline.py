"""Draw panels: outlines of lines and cubics in the wearer's front plane, mirrored, placed and sewn by label."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from .curves import edge_length, place_on_chord, relative_to_chord, split_edge, unit_length, unit_points
from .pattern import Edge, EdgeRef, Panel, Pattern, Seam

PLACEMENT_DEPTH = 0.25
"""Distance of front and back panels from the body's middle plane [m]: adult bodies are less than twice as deep."""

VENT_LABEL = "vent"
"""Word of the labels of open edges that are the sides of a vent."""

PLACKET_CONTOUR = "placket"
"""Beginning of the names of the open contours of slits in sleeves."""

Point = tuple[float, float]


def is_vent_side(edge: Edge) -> bool:
    """Check whether an open edge is the side of a vent."""
    return VENT_LABEL in edge.label.split(".")


def is_slit_side(edge: Edge) -> bool:
    """Check whether an open edge is the side of a vent, or of a slit in a sleeve."""
    return is_vent_side(edge) or edge.contour.startswith(PLACKET_CONTOUR)


@dataclass(frozen=True)
class Stroke:
    """Describe one edge from the end of the last one.

    Attributes:
        end: Where it ends [m].
        handles: Handles in the draft's axes [m]; none for a line, two for a cubic.
        label: Edges of two panels with the same label are sewn.
        contour: Its open contour, or an empty text.
        notch: Fraction of the edge's length at its notch, or None.
    """

    end: Point
    handles: tuple[Point, ...] = ()
    label: str = ""
    contour: str = ""
    notch: float | None = None


@dataclass(frozen=True)
class Outline:
    """Describe a counter-clockwise outline: a start, and strokes; the last one closes it when it ends at the start."""

    start: Point
    strokes: tuple[Stroke, ...]


def draw_monotone_spline(points: list[Point], labels: list[str]) -> list[Stroke]:
    """Draw a smooth line through points as cubics with the slopes of a monotone spline (Fritsch and Carlson). The ends
    are straight; handles are at a third of the height, so that the curve is x as a function of y."""
    xs, ys = np.array(points).T
    secants = np.diff(xs) / np.diff(ys)
    slopes = np.concatenate([secants[:1], np.zeros(len(points) - 2), secants[-1:]])
    for i, (before, after) in enumerate(pairwise(secants), start=1):
        if before * after > 0:
            slopes[i] = 2 * before * after / (before + after)
    strokes = []
    for i, label in enumerate(labels):
        third = (ys[i + 1] - ys[i]) / 3
        first = (float(xs[i] + slopes[i] * third), float(ys[i] + third))
        second = (float(xs[i + 1] - slopes[i + 1] * third), float(ys[i + 1] - third))
        strokes.append(Stroke(points[i + 1], (first, second), label=label))
    return strokes


def unfold(outline: Outline, closing: str, dip: float = 0.0) -> Outline:
    """Mirror a left half that ends at the middle and close it with one edge on the contour `closing`."""
    other = mirror(outline)
    start, end = outline.start, (-outline.start[0], outline.start[1])
    handles: tuple[Point, ...] = ()
    if dip:
        # A parabola's middle is halfway to its handle; as a cubic its handles are at 2/3 of that.
        low = end[1] - dip * 4 / 3
        handles = ((end[0] / 3, low), (start[0] / 3, low))
    return Outline(start, (*outline.strokes, *other.strokes, Stroke(start, handles, contour=closing)))


def unfold_closed(outline: Outline) -> Outline:
    """Mirror a left half that begins and ends at the middle."""
    return Outline(outline.start, (*outline.strokes, *mirror(outline).strokes))


def halve(outline: Outline, seam: Stroke) -> Outline:
    """Return the left half of an outline that is symmetric about x = 0, closed along the middle.

    Args:
        outline: From `unfold` or `unfold_closed`.
        seam: Names the edge in the middle; its end is not used.
    """
    count = len(outline.strokes)
    left = outline.strokes[: count // 2]
    if count % 2 == 0:
        return Outline(outline.start, (*left, replace(seam, end=outline.start)))
    before, after = cut_stroke(outline.strokes[-2].end, outline.strokes[-1], 0.5, ("", ""))
    return Outline(outline.start, (*left, replace(seam, end=(0.0, before.end[1])), after))


def arc_handles(start: Point, end: Point, turn: float) -> tuple[Point, Point]:
    """Return the handles of the cubic nearest to a circular arc: 4/3 tan(turn / 4) radii from its ends.

    Args:
        start: Where the arc begins [m].
        end: Where it ends [m].
        turn: Its angle [rad], positive to the left; up to a quarter turn the cubic is within 0.03 % of the radius.
    """
    a, b = np.array(start), np.array(end)
    chord = b - a
    half = turn / 2
    reach = 2.0 / 3.0 * math.tan(turn / 4) / math.sin(half)  # in chords, as the radius is chord / (2 sin half)

    def along(angle: float) -> np.ndarray:
        return np.array(
            [
                math.cos(angle) * chord[0] - math.sin(angle) * chord[1],
                math.sin(angle) * chord[0] + math.cos(angle) * chord[1],
            ]
        )

    return (to_point(a + reach * along(-half)), to_point(b - reach * along(half)))


def to_point(array: np.ndarray) -> Point:
    """Return a point [m] as plain numbers."""
    return (float(array[0]), float(array[1]))


def mirror(outline: Outline, swap: bool = True) -> Outline:
    """Return an outline mirrored at x = 0 and reversed, so that it stays counter-clockwise. With `swap`, left and right
    are exchanged in labels and contours: the other half of a garment. Without, it is the same part of the wearer seen
    from behind."""
    ends = [outline.start, *(s.end for s in outline.strokes)]
    strokes = []
    for i in range(len(outline.strokes) - 1, -1, -1):
        s = outline.strokes[i]
        strokes.append(
            Stroke(
                _flip(ends[i]),
                tuple(_flip(h) for h in s.handles[::-1]),
                swap_side_label(s.label) if swap else s.label,
                swap_side_label(s.contour) if swap else s.contour,
                None if s.notch is None else 1.0 - s.notch,
            )
        )
    return Outline(_flip(ends[-1]), tuple(strokes))


def reverse_strokes(outline: Outline) -> tuple[Stroke, ...]:
    """Return the strokes of a line from its end to its start."""
    starts = [outline.start, *(stroke.end for stroke in outline.strokes[:-1])]
    return tuple(
        replace(s, end=start, handles=s.handles[::-1], notch=None if s.notch is None else 1.0 - s.notch)
        for start, s in zip(starts[::-1], outline.strokes[::-1], strict=True)
    )


def swap_side_label(text: str) -> str:
    """Return a label with left and right exchanged."""
    swapped = {"left": "right", "right": "left"}
    return ".".join(swapped.get(word, word) for word in text.split("."))


def _flip(point: Point) -> Point:
    return (-point[0], point[1])


def place_panel(
    name: str, outline: Outline, height: float, grain: float = 0.0, label: str = "body", across: float = 0.0
) -> Panel:
    """Place a drawn outline in front of or behind the body, moved by `across` to the wearer's left [m]. A panel with
    `back` in its name is behind, turned about y. The draft is made in world x, so a back panel, seen from outside, is
    its mirror image; the turn restores it."""
    behind = "back" in name
    drawn = mirror(outline, swap=False) if behind else outline
    starts = [drawn.start, *(s.end for s in drawn.strokes[:-1])]
    edges = tuple(_edge(start, stroke) for start, stroke in zip(starts, drawn.strokes, strict=True))
    notches = tuple((i, s.notch) for i, s in enumerate(drawn.strokes) if s.notch is not None)
    turn = np.diag([-1.0, 1.0, -1.0]) if behind else np.eye(3)
    place = np.array([across, height, -PLACEMENT_DEPTH if behind else PLACEMENT_DEPTH])
    return Panel(name, np.array(starts), edges, turn, place, grain, label, notches=notches)


def _edge(start: Point, stroke: Stroke) -> Edge:
    if not stroke.handles:
        return Edge("line", label=stroke.label, contour=stroke.contour)
    handles = relative_to_chord(np.array(stroke.handles), np.array(start), np.array(stroke.end))
    return Edge("cubic", handles, stroke.label, stroke.contour)


def cut_stroke(start: Point, stroke: Stroke, share: float, names: tuple[str, str]) -> tuple[Stroke, Stroke]:
    """Cut a stroke that begins at `start` [m] at a share of its length; both parts draw the same curve. `names` are the
    labels of the two parts; both keep the open contour, and a notch is dropped."""
    edge, a, b = _edge(start, stroke), np.array(start), np.array(stroke.end)
    cut, *parts = split_edge(edge, share)
    middle = place_on_chord(cut[None], a, b)[0]
    handles = [
        tuple(to_point(h) for h in place_on_chord(part.handles, *ends)) if part.kind != "line" else ()
        for part, ends in zip(parts, ((a, middle), (middle, b)), strict=True)
    ]
    return (
        Stroke(to_point(middle), handles[0], names[0], stroke.contour),
        Stroke(stroke.end, handles[1], names[1], stroke.contour),
    )


def stroke_points(start: Point, stroke: Stroke, segments: int) -> np.ndarray:
    """Return points of a stroke that begins at `start` [m], uniform in arc length, shape [segments + 1, 2]."""
    unit = unit_points(_edge(start, stroke), segments)
    return place_on_chord(unit, np.array(start), np.array(stroke.end))


def labelled_length(outline: Outline, label: str) -> float:
    """Return the length of the strokes whose label begins with a text [m]."""
    total, start = 0.0, outline.start
    for stroke in outline.strokes:
        if stroke.label.startswith(label):
            total += math.dist(start, stroke.end) * unit_length(_edge(start, stroke))
        start = stroke.end
    return total


MIN_NOTCHED_SEAM_LENGTH = 0.12
"""Length of a seam above which it gets a notch at half its length where nothing sets one [m]: a longer piece cannot be
held at once in sewing."""


MIN_GATHER_SHARE = 0.03
"""Difference between the lengths of a seam's sides above which it is gathered [share of one side], as for files."""


def sew_by_label(name: str, category: str, panels: list[Panel]) -> Pattern:
    """Sew every two edges of no contour that share a label, and notch both sides of long seams at half their length."""
    sides: dict[str, list[EdgeRef]] = {}
    for panel in panels:
        for i, edge in enumerate(panel.edges):
            if edge.label and not edge.contour:
                sides.setdefault(edge.label, []).append(EdgeRef(panel.name, i))
    edges = {panel.name: panel for panel in panels}
    lengths = [[edge_length(edges[ref.panel], ref.edge) for ref in pair] for pair in sides.values()]
    seams = tuple(
        Seam(a, b, gathered=abs(one / other - 1.0) > MIN_GATHER_SHARE)
        for (a, b), (one, other) in zip(sides.values(), lengths, strict=True)
    )
    return Pattern(name, tuple(_notched(panel) for panel in panels), seams, category)


def _notched(panel: Panel) -> Panel:
    marked = {edge for edge, _ in panel.notches}
    lengths = [edge_length(panel, i) for i in range(len(panel.edges))]
    more = tuple(
        (i, 0.5)
        for i, edge in enumerate(panel.edges)
        if edge.label and not edge.contour and i not in marked and lengths[i] > MIN_NOTCHED_SEAM_LENGTH
    )
    return replace(panel, notches=tuple(sorted((*panel.notches, *more))))
