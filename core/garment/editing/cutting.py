"""Cut a panel in two along a straight line; the cut is sewn."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..curves import chord, edge_points, panel_area, place_on_chord, split_edge
from ..errors import Place
from ..pattern import Edge, EdgeRef, Panel, Pattern, Seam
from .edge_division import MIN_SPLIT_SHARE, divide, forget_edges
from .errors import EditBad
from .partners import find_panel

CROSSING_SAMPLE_COUNT = 64
"""Number of equal parts of an edge, each searched for a crossing."""

CUT_LINE_TOLERANCE = 1e-9
"""Distance from the line [m] below which a corner is on it; otherwise rounding, which differs between processors, would
decide its side."""

CROSSING_BISECTION_ITERATIONS = 50
"""Number of bisections of a part of an edge, after which the crossing is known to rounding."""


def cut_panel(pattern: Pattern, panel: str, line: np.ndarray) -> Pattern:
    """Return a pattern with a panel cut in two along a line, and both pieces sewn to each other there. The pieces keep
    the panel's axes, placement and grain. The larger one keeps its name; the other gets it with the next free number.
    Edges sewn to an edge that the line meets are divided there too.

    Args:
        pattern: The pattern.
        panel: Name of the panel.
        line: Two points in the panel's axes [m], outside of it or on its outline, shape [2, 2].

    Raises:
        EditBad: where the line does not cross the outline exactly twice.
    """
    found, line = find_panel(pattern, panel), np.asarray(line, float)
    cuts, corners = _find_crossings(found, line)
    if len(cuts) + len(corners) != 2:
        message = (
            f"the line meets the outline of panel '{panel}' {len(cuts) + len(corners)} times; it must cross twice."
        )
        raise EditBad(message, Place(panel))
    divided = divide(pattern, {EdgeRef(panel, edge): at for edge, at in cuts})
    before = sorted(edge for edge, _ in cuts)
    ends = [corner + sum(1 for edge in before if edge < corner) for corner in corners]
    ends += [edge + 1 + k for k, edge in enumerate(before)]
    first, last = sorted(ends)
    if last - first < 2 or len(divided.panel(panel).points) - last + first < 2:
        raise EditBad(f"the line runs along an edge of panel '{panel}'; it must cross the panel.", Place(panel))
    return _separate(divided, divided.panel(panel), first, last)


def _find_crossings(panel: Panel, line: np.ndarray) -> tuple[list[tuple[int, float]], list[int]]:
    """Return where a line segment crosses a panel's outline: edges with fractions of their lengths, and corners."""
    along = line[1] - line[0]
    size = float(np.linalg.norm(along))
    if size == 0.0:
        raise EditBad("a line is given by two different points.", Place(panel.name))
    normal = np.array([-along[1], along[0]]) / size

    def side(points: np.ndarray) -> np.ndarray:
        found = np.asarray((points - line[0]) @ normal)
        return np.where(np.abs(found) < CUT_LINE_TOLERANCE, 0.0, found)

    def is_between(point: np.ndarray) -> bool:
        return -1e-6 <= float((point - line[0]) @ along) / size <= size + 1e-6

    cuts: list[tuple[int, float]] = []
    corners: set[int] = set()
    for number in range(len(panel.edges)):
        fractions = np.linspace(0.0, 1.0, CROSSING_SAMPLE_COUNT + 1)
        values = side(edge_points(panel, number, CROSSING_SAMPLE_COUNT))
        for k in np.flatnonzero(np.sign(values[:-1]) * np.sign(values[1:]) <= 0.0):
            if values[k] == values[k + 1] == 0.0:
                continue
            at = _refine(panel, number, side, float(fractions[k]), float(fractions[k + 1]))
            point = _point_at(panel, number, at)
            if not is_between(point):
                continue
            if at < MIN_SPLIT_SHARE or at > 1.0 - MIN_SPLIT_SHARE:
                corners.add((number + round(at)) % len(panel.points))
            elif not any(edge == number and abs(at - known) < MIN_SPLIT_SHARE for edge, known in cuts):
                cuts.append((number, at))
    return cuts, sorted(corners)


def _refine(panel: Panel, edge: int, side: Callable[[np.ndarray], np.ndarray], low: float, high: float) -> float:
    """Return the fraction of an edge's length, between two others, at which it crosses the line."""
    below = float(side(_point_at(panel, edge, low)))
    for _ in range(CROSSING_BISECTION_ITERATIONS):
        half = (low + high) / 2.0
        value = float(side(_point_at(panel, edge, half)))
        if below * value <= 0.0:
            high = half
        else:
            low, below = half, value
    return (low + high) / 2.0


def _point_at(panel: Panel, edge: int, at: float) -> np.ndarray:
    """Return the point at a fraction of an edge's length [m], shape [2]."""
    start, end = chord(panel, edge)
    if at <= 0.0 or at >= 1.0:
        return start if at <= 0.0 else end
    return np.asarray(place_on_chord(split_edge(panel.edges[edge], at)[0][None], start, end)[0])


def _separate(pattern: Pattern, panel: Panel, first: int, last: int) -> Pattern:
    """Return a pattern with a panel separated between two of its control points."""
    count = len(panel.points)
    loops = [list(range(first, last)), [*range(last, count), *range(first)]]
    ends = [last, first]
    pieces = [_piece(panel, loop, end) for loop, end in zip(loops, ends, strict=True)]
    large = int(panel_area(pieces[1]) > panel_area(pieces[0]))
    names = ["", ""]
    names[large], names[1 - large] = panel.name, _free_name(pattern, panel.name)
    numbers = {
        EdgeRef(panel.name, edge): EdgeRef(name, at)
        for name, loop in zip(names, loops, strict=True)
        for at, edge in enumerate(loop)
    }
    panels: list[Panel] = []
    for one in pattern.panels:
        named = [replace(piece, name=name) for piece, name in zip(pieces, names, strict=True)]
        panels += [named[large], named[1 - large]] if one.name == panel.name else [one]
    seams = [replace(seam, a=numbers.get(seam.a, seam.a), b=numbers.get(seam.b, seam.b)) for seam in pattern.seams]
    seams.append(Seam(EdgeRef(names[0], len(loops[0])), EdgeRef(names[1], len(loops[1]))))
    cut = replace(pattern, panels=tuple(panels), seams=tuple(seams))
    return reorder(forget_edges(cut, {panel.name}))


def _piece(panel: Panel, loop: list[int], end: int) -> Panel:
    """Return the piece of a panel from its first control point along some edges, closed by a line from the last one."""
    points = np.concatenate([panel.points[loop], panel.points[[end]]])
    edges = (*(panel.edges[edge] for edge in loop), Edge())
    places = {edge: at for at, edge in enumerate(loop)}
    notches = tuple((places[edge], at) for edge, at in panel.notches if edge in places)
    return replace(panel, points=points, edges=edges, notches=notches)


def _free_name(pattern: Pattern, name: str) -> str:
    """Return a panel's name with a number that no other panel has."""
    known, number = {panel.name for panel in pattern.panels}, 2
    while f"{name}_{number}" in known:
        number += 1
    return f"{name}_{number}"


def reorder(pattern: Pattern) -> Pattern:
    """Return a pattern whose `panel_order` lists its present panels."""
    stored = pattern.extra.get("pattern", {})
    if "panel_order" not in stored:
        return pattern
    order = [panel.name for panel in pattern.panels]
    return replace(pattern, extra={**pattern.extra, "pattern": {**stored, "panel_order": order}})
