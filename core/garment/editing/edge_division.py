"""Add control points to edges and remove them; no outline changes its length by more than 1e-6 m."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ..curves import chord, edge_length, place_on_chord, relative_to_chord, split_edge, unit_circle, unit_length
from ..errors import Place
from ..pattern import Edge, EdgeRef, Panel, Pattern, Seam
from ..seams import find_sewn_partners
from .errors import EditBad
from .partners import Corner, check_number, find_panel, mirror_corners, mirror_edges

MIN_SPLIT_SHARE = 1e-3
"""Share of an edge's length at its ends where it is not cut: a piece of less than 1 mm of a metre is no edge."""

MERGED_CURVE_TOLERANCE = 1e-7
"""Largest distance [m] at which two edges count as parts of one curve."""


def split_edges(pattern: Pattern, panel: str, edge: int, at: float, keep_symmetry: bool = True) -> Pattern:
    """Return a pattern with one more control point on an edge; the outline stays the same curve. The edge that is sewn
    to it is cut at the same place, so that each half keeps its seam, and so are mirror images.

    Args:
        pattern: The pattern.
        panel: Name of the panel.
        edge: Number of the edge.
        at: Fraction of its length.
        keep_symmetry: Cut mirror images too.

    Raises:
        EditBad: where there is no such edge, or the cut is at its end.
    """
    check_number(find_panel(pattern, panel), edge)
    if not MIN_SPLIT_SHARE <= at <= 1.0 - MIN_SPLIT_SHARE:
        raise EditBad(
            f"an edge is split at a fraction from {MIN_SPLIT_SHARE} to {1 - MIN_SPLIT_SHARE}.", Place(panel, edge=edge)
        )
    cuts = {EdgeRef(panel, edge): at}
    if keep_symmetry:
        cuts |= dict.fromkeys(mirror_edges(pattern).get(EdgeRef(panel, edge), set()), 1.0 - at)
    return divide(pattern, cuts)


def divide(pattern: Pattern, cuts: Mapping[EdgeRef, float]) -> Pattern:
    """Return a pattern with some edges, and those sewn to them, cut in two at fractions of their lengths."""
    sewn = find_sewn_partners(pattern)
    cuts = {sewn[ref]: 1.0 - at for ref, at in cuts.items() if ref in sewn} | dict(cuts)
    numbers: dict[EdgeRef, list[int]] = {}
    panels = []
    for panel in pattern.panels:
        points: list[np.ndarray] = []
        edges: list[Edge] = []
        for i, edge in enumerate(panel.edges):
            ref, at = EdgeRef(panel.name, i), cuts.get(EdgeRef(panel.name, i))
            numbers[ref] = [len(edges)] if at is None else [len(edges), len(edges) + 1]
            points.append(panel.points[i])
            if at is None:
                edges.append(edge)
                continue
            cut, *parts = split_edge(edge, at)
            points.append(place_on_chord(cut[None], *chord(panel, i))[0])
            edges += parts
        notches = tuple(_shift_notch(panel, notch, numbers, cuts) for notch in panel.notches)
        panels.append(replace(panel, points=np.array(points), edges=tuple(edges), notches=notches))
    seams = []
    for seam in pattern.seams:
        pairs = zip(numbers[seam.a], numbers[seam.b][::-1], strict=True)
        seams += [replace(seam, a=EdgeRef(seam.a.panel, i), b=EdgeRef(seam.b.panel, j)) for i, j in pairs]
    return forget_edges(replace(pattern, panels=tuple(panels), seams=tuple(seams)), {ref.panel for ref in cuts})


def _shift_notch(
    panel: Panel, notch: tuple[int, float], numbers: Mapping[EdgeRef, list[int]], cuts: Mapping[EdgeRef, float]
) -> tuple[int, float]:
    """Return a notch on the part of its edge that has it now."""
    ref = EdgeRef(panel.name, notch[0])
    at = cuts.get(ref)
    if at is None:
        return numbers[ref][0], notch[1]
    return (numbers[ref][0], notch[1] / at) if notch[1] <= at else (numbers[ref][1], (notch[1] - at) / (1.0 - at))


def merge_edges(pattern: Pattern, panel: str, vertex: int, keep_symmetry: bool = True) -> Pattern:
    """Return a pattern without a control point: its two edges become one of the same length. Parts of one curve become
    that curve; others become the cubic of the same ends, end directions and length. Both edges are sewn to neighbours
    on one other panel, whose common point is removed too, or neither is sewn.

    Args:
        pattern: The pattern.
        panel: Name of the panel.
        vertex: Number of the control point.
        keep_symmetry: Remove mirror images too.

    Raises:
        EditBad: where there is no such point, or a seam or an opening ends there.
    """
    check_number(find_panel(pattern, panel), vertex)
    corners = {(panel, vertex)}
    if keep_symmetry:
        corners |= {image for image, _ in mirror_corners(pattern).get((panel, vertex), [])}
    while corners:  # each merge renumbers the remaining points of its panels
        name, number = max(corners)
        corners.discard((name, number))
        partner = _find_partner(pattern, name, number)
        lost = {(name, number)} | ({partner} if partner else set())
        pattern = _merge(pattern, lost)
        corners = {_renumber(corner, lost) for corner in corners - lost}
    return pattern


def _renumber(corner: Corner, removed: set[Corner]) -> Corner:
    """Return a control point's number after others are removed."""
    return corner[0], corner[1] - sum(1 for name, number in removed if name == corner[0] and number < corner[1])


def _find_partner(pattern: Pattern, name: str, vertex: int) -> Corner | None:
    """Return the control point that both edges at one are sewn to; None where they are not sewn. Raise `EditBad` where
    a seam or an opening ends at the point."""
    panel, sewn = pattern.panel(name), find_sewn_partners(pattern)
    count, place = len(panel.points), Place(name, vertex=vertex)
    if count <= 3:
        raise EditBad(f"panel '{name}' has {count} vertices; it keeps three.", place)
    before, after = EdgeRef(name, (vertex - 1) % count), EdgeRef(name, vertex)
    if panel.edges[before.edge].contour != panel.edges[after.edge].contour:
        raise EditBad(f"an opening ends at vertex {vertex} of panel '{name}'; it stays.", place)
    one, other = sewn.get(before), sewn.get(after)
    if one is None and other is None:
        return None
    if one is None or other is None or one.panel != other.panel:
        raise EditBad(f"a seam ends at vertex {vertex} of panel '{name}'; it stays.", place)
    other_count = len(pattern.panel(one.panel).points)
    if (other.edge + 1) % other_count != one.edge or {one, other} & {before, after} or other_count <= 3:
        raise EditBad(f"a seam ends at vertex {vertex} of panel '{name}'; it stays.", place)
    return one.panel, one.edge


def _merge(pattern: Pattern, old: set[Corner]) -> Pattern:
    """Return a pattern without some control points, at most one per panel, or two that are not neighbours."""
    numbers: dict[EdgeRef, int] = {}
    panels = []
    for panel in pattern.panels:
        lost = {number for name, number in old if name == panel.name}
        count = len(panel.points)
        kept = [i for i in range(count) if i not in lost]
        edges, notches = [], []
        for new, i in enumerate(kept):
            second = (i + 1) % count
            parts = [i, second] if second in lost else [i]
            edges.append(_join_edges(panel, i) if len(parts) == 2 else panel.edges[i])
            lengths = [edge_length(panel, part) for part in parts]
            for at, part in enumerate(parts):
                numbers[EdgeRef(panel.name, part)] = new
                start = sum(lengths[:at])
                notches += [(new, (start + f * lengths[at]) / sum(lengths)) for n, f in panel.notches if n == part]
        panels.append(replace(panel, points=panel.points[kept], edges=tuple(edges), notches=tuple(sorted(notches))))
    seams: dict[tuple[EdgeRef, EdgeRef], Seam] = {}
    for seam in pattern.seams:
        a, b = (EdgeRef(ref.panel, numbers[ref]) for ref in (seam.a, seam.b))
        if (b, a) not in seams:
            known = seams.get((a, b))
            seams[a, b] = replace(seam, a=a, b=b, gathered=seam.gathered or (known is not None and known.gathered))
    return forget_edges(replace(pattern, panels=tuple(panels), seams=tuple(seams.values())), {name for name, _ in old})


def _join_edges(panel: Panel, first: int) -> Edge:
    """Return one edge from the start of an edge to the end of the next."""
    count = len(panel.points)
    second = (first + 1) % count
    one, other = panel.edges[first], panel.edges[second]
    start, middle = chord(panel, first)
    end = panel.points[(second + 1) % count]
    label = one.label if one.label == other.label else ""
    length = edge_length(panel, first) + edge_length(panel, second)
    along = float(np.linalg.norm(end - start))
    if along < MERGED_CURVE_TOLERANCE:
        place = Place(panel.name, vertex=second)
        raise EditBad(f"without vertex {second} an edge of panel '{panel.name}' would have no length.", place)
    drawn = Edge("line", label=label, contour=one.contour)
    if length <= along * (1.0 + 1e-12):
        return drawn
    for whole in _whole_curves(one, other, (start, middle, end)):
        if abs(unit_length(whole) * along - length) < MERGED_CURVE_TOLERANCE and _is_cut_there(
            whole, one, middle, (start, end)
        ):
            return replace(whole, label=label, contour=one.contour)
    return replace(_fit_cubic(one, other, (start, middle, end), length / along), label=label, contour=one.contour)


def _whole_curves(one: Edge, other: Edge, points: tuple[np.ndarray, np.ndarray, np.ndarray]) -> list[Edge]:
    """Return the curves that two edges may be parts of: by inverting de Casteljau's cut, or the arc through the cut."""
    start, middle, end = points
    if one.kind != other.kind:
        return []
    if one.kind == "arc":
        sweeps = sum(unit_circle(edge)[3] for edge in (one, other))
        return [Edge("arc", np.array([[0.5, -0.5 * np.tan(sweeps / 4.0)]]))]
    if one.kind not in ("quadratic", "cubic"):
        return []
    left, right = place_on_chord(one.handles, start, middle), place_on_chord(other.handles, middle, end)
    reach = [float(np.linalg.norm(left[-1] - middle)), float(np.linalg.norm(right[0] - middle))]
    if sum(reach) == 0.0:
        return []
    at = reach[0] / sum(reach)
    if not 0.0 < at < 1.0:
        return []
    handles = [start + (left[0] - start) / at]
    if one.kind == "cubic":
        handles.append(end - (end - right[-1]) / (1.0 - at))
    return [Edge(one.kind, relative_to_chord(np.array(handles), start, end))]


def _is_cut_there(whole: Edge, one: Edge, middle: np.ndarray, ends: tuple[np.ndarray, np.ndarray]) -> bool:
    """Return whether a curve, cut at the length of its first part, gives the same point."""
    start, end = ends
    size = float(np.linalg.norm(end - start))
    share = unit_length(one) * float(np.linalg.norm(middle - start)) / (unit_length(whole) * size)
    cut = place_on_chord(split_edge(whole, min(max(share, 1e-9), 1.0 - 1e-9))[0][None], start, end)[0]
    return bool(np.linalg.norm(cut - middle) < MERGED_CURVE_TOLERANCE)


def _fit_cubic(one: Edge, other: Edge, points: tuple[np.ndarray, np.ndarray, np.ndarray], length: float) -> Edge:
    """Return the cubic with the first edge's first direction, the second's last, and a length in chords. Both handles
    have the same distance from their ends, which grows with the length and is found by bisection."""
    start, middle, end = points
    first = place_on_chord(_tangent(one, 0), start, middle)[0] - start
    last = place_on_chord(_tangent(other, 1), middle, end)[0] - end
    ends = np.array([[0.0, 0.0], [1.0, 0.0]])
    ways = relative_to_chord(np.stack([start + first, end + last]), start, end) - ends
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)

    def draw(reach: float) -> Edge:
        return Edge("cubic", ends + reach * ways)

    low, high = 0.0, 1.0
    while unit_length(draw(high)) < length and high < 64.0:
        high *= 2.0
    for _ in range(80):
        half = (low + high) / 2.0
        low, high = (half, high) if unit_length(draw(half)) < length else (low, half)
    return draw((low + high) / 2.0)


def _tangent(edge: Edge, at_end: int) -> np.ndarray:
    """Return a relative point on an edge's first or last tangent, shape [1, 2]."""
    if edge.kind == "line":
        return np.array([[0.5, 0.0]])
    if edge.kind == "arc":
        half = 2.0 * np.arctan2(float(edge.handles[0, 1]), 0.5)
        along = 0.1 * np.cos(half)
        return np.array([[1.0 - along if at_end else along, 0.1 * np.sin(half)]])
    return edge.handles[-1:] if at_end else edge.handles[:1]


def forget_edges(pattern: Pattern, names: set[str]) -> Pattern:
    """Return a pattern without the unknown keys that a file had for the edges of some panels, which have changed."""
    known = pattern.extra.get("panels", {})
    rests = {name: {**rest, "edges": {}} if name in names else rest for name, rest in known.items()}
    return replace(pattern, extra={**pattern.extra, "panels": rests}) if known else pattern
