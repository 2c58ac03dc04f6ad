"""Insert a dart into a panel, find a pattern's darts, and close one."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..pattern import Edge, EdgeRef, Pattern, Seam
from ..seams import find_sewn_partners
from .edge_division import divide, forget_edges

MIN_FOUND_DART_LENGTH = 1e-3
"""Smallest length of a dart from its mouth to its apex [m]. Below it two collinear edges that are sewn to each other
are a pleat, whose fold is on its mouth."""

DART_LABEL = "dart"
"""Label of both edges of an inserted dart."""


@dataclass(frozen=True)
class Dart:
    """Describe a dart: two consecutive edges of one panel that are sewn to each other; `first` ends at the apex."""

    panel: str
    first: int

    def ends(self, pattern: Pattern) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the start of its mouth, its apex and the end of its mouth [m], shape [2] each."""
        points = pattern.panel(self.panel).points
        first, apex, last = (points[(self.first + k) % len(points)] for k in range(3))
        return first, apex, last

    def width(self, pattern: Pattern) -> float:
        """Return its intake: the width of its mouth [m]."""
        first, _, last = self.ends(pattern)
        return float(np.linalg.norm(last - first))

    def length(self, pattern: Pattern) -> float:
        """Return the distance of its apex from the middle of its mouth [m]."""
        first, apex, last = self.ends(pattern)
        return float(np.linalg.norm(apex - 0.5 * (first + last)))

    def angle(self, pattern: Pattern) -> float:
        """Return its angle at the apex [rad]."""
        return 2.0 * float(np.arctan2(0.5 * self.width(pattern), self.length(pattern)))


def find_darts(pattern: Pattern) -> tuple[Dart, ...]:
    """Find the darts of a pattern that begin at a panel's outline, in the order of its panels."""
    found = []
    for seam in pattern.seams:
        for one, other in ((seam.a, seam.b), (seam.b, seam.a)):
            count = len(pattern.panel(one.panel).points)
            dart = Dart(one.panel, one.edge)
            if (
                one.panel == other.panel
                and other.edge == (one.edge + 1) % count
                and dart.length(pattern) > MIN_FOUND_DART_LENGTH
            ):
                found.append(dart)
    order = [panel.name for panel in pattern.panels]
    return tuple(sorted(found, key=lambda dart: (order.index(dart.panel), dart.first)))


def insert_dart(pattern: Pattern, edge: EdgeRef, at: float, apex: np.ndarray) -> tuple[Pattern, Dart]:
    """Return a pattern with a dart of width 0; moving the ends of its mouth apart opens it.

    Args:
        pattern: The pattern.
        edge: The edge that its mouth is on.
        at: Fraction of the edge's length; 0: the mouth is at the control point where the edge begins, and nothing is
            divided. Elsewhere the edge sewn to it is divided too, so that each part keeps its seam.
        apex: In the panel's axes [m], shape [2].

    Returns:
        The pattern, and the dart.
    """
    number = edge.edge
    if at > 0.0:
        partner = find_sewn_partners(pattern).get(edge)
        number += 2 if partner is not None and partner.panel == edge.panel and partner.edge < edge.edge else 1
        pattern = divide(pattern, {edge: at})
    panels = []
    for panel in pattern.panels:
        if panel.name != edge.panel:
            panels.append(panel)
            continue
        mouth = panel.points[number]
        points = np.concatenate([panel.points[: number + 1], [apex, mouth], panel.points[number + 1 :]])
        sides = (Edge("line", label=DART_LABEL), Edge("line", label=DART_LABEL))
        edges = (*panel.edges[:number], *sides, *panel.edges[number:])
        notches = tuple((i + 2 if i >= number else i, share) for i, share in panel.notches)
        panels.append(replace(panel, points=points, edges=edges, notches=notches))

    def renumber(ref: EdgeRef) -> EdgeRef:
        moved = ref.panel == edge.panel and ref.edge >= number
        return EdgeRef(ref.panel, ref.edge + 2) if moved else ref

    seams = [replace(seam, a=renumber(seam.a), b=renumber(seam.b)) for seam in pattern.seams]
    seams.append(Seam(EdgeRef(edge.panel, number), EdgeRef(edge.panel, number + 1)))
    cut = replace(pattern, panels=tuple(panels), seams=tuple(seams))
    return forget_edges(cut, {edge.panel}), Dart(edge.panel, number)


def close_dart(pattern: Pattern, dart: Dart) -> Pattern:
    """Return a pattern without a dart: the ends of its mouth become one point at its middle, and its apex is removed.
    The control point at the mouth stays, so that the edges on either side of it keep their seams.

    Args:
        pattern: The pattern.
        dart: Of the pattern, as `find_darts` gives it.
    """
    panel = pattern.panel(dart.panel)
    count = len(panel.points)
    first, _, last = dart.ends(pattern)
    removed = {(dart.first + 1) % count, (dart.first + 2) % count}
    kept = [i for i in range(count) if i not in removed]
    points = panel.points.copy()
    points[dart.first] = 0.5 * (first + last)
    # The edge after the mouth now begins at its middle; both edges of the dart are removed.
    order = [i if i != dart.first else (dart.first + 2) % count for i in kept]
    numbers = {old: new for new, old in enumerate(order)}
    notches = tuple(sorted((numbers[i], share) for i, share in panel.notches if i in numbers))
    closed = replace(panel, points=points[kept], edges=tuple(panel.edges[i] for i in order), notches=notches)

    def renumber(ref: EdgeRef) -> EdgeRef:
        return EdgeRef(ref.panel, numbers[ref.edge]) if ref.panel == panel.name else ref

    sides = {EdgeRef(panel.name, dart.first), EdgeRef(panel.name, (dart.first + 1) % count)}
    seams = tuple(
        replace(seam, a=renumber(seam.a), b=renumber(seam.b)) for seam in pattern.seams if {seam.a, seam.b} != sides
    )
    panels = tuple(closed if each is panel else each for each in pattern.panels)
    return forget_edges(replace(pattern, panels=panels, seams=seams), {panel.name})
