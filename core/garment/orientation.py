"""Outer side of panels: mirror panels, and orient them consistently with their seams."""

from __future__ import annotations

from collections import deque
from dataclasses import replace

import numpy as np

from .curves import chord, mirror_edge, panel_area, reverse_edge
from .errors import NotOrientable, Place
from .pattern import EdgeRef, Panel, Pattern, Seam

HALF_TURN_ROTATION = np.diag([-1.0, 1.0, -1.0])
"""Rotation by half a turn about y, which keeps the 3D placement of a panel mirrored in x: `rotation` is multiplied by
it."""

MIN_PARALLEL_CHORD_COSINE = 0.7
"""Cosine between the chords of two placed edges above which both have the same direction (45 degrees): a side seam's
two edges are parallel as placed, a cap and its armhole nearly so."""


def mirror_panel(panel: Panel) -> Panel:
    """Return a panel seen from its other side: x becomes -x, its 3D placement stays, its outward normal is reversed.
    The order of the points stays, so a clockwise loop becomes counter-clockwise and edge numbers remain valid."""
    return replace(
        panel,
        points=panel.points * np.array([-1.0, 1.0]),
        edges=tuple(mirror_edge(edge) for edge in panel.edges),
        rotation=panel.rotation @ HALF_TURN_ROTATION,
        grainline=-panel.grainline,
        mirrored=not panel.mirrored,
    )


def reverse_panel(panel: Panel) -> Panel:
    """Return a panel with its loop reversed: point 0 stays first, edge i becomes edge n - 1 - i."""
    return replace(
        panel,
        points=np.roll(panel.points[::-1], 1, axis=0),
        edges=tuple(reverse_edge(edge) for edge in panel.edges[::-1]),
        notches=tuple((len(panel.edges) - 1 - edge, 1.0 - at) for edge, at in panel.notches),
    )


def flip_panel(panel: Panel) -> Panel:
    """Return a panel with its other side out: mirrored and reversed, so that it stays counter-clockwise."""
    return reverse_panel(mirror_panel(panel))


def place_points(panel: Panel, points: np.ndarray) -> np.ndarray:
    """Return flat points [m], shape [n, 2], placed by a panel in 3D [m], shape [n, 3]."""
    found: np.ndarray = points @ panel.rotation[:, :2].T + panel.translation
    return found


def agree_orientation(pattern: Pattern) -> Pattern:
    """Turn panels so that every seam joins two outward counter-clockwise loops (all `reversed`). The default is the
    loops' normals. A seam marked by the author as of equal direction (`reversed` False), or whose placed ends clearly
    are so, requires one of its panels to be turned. Panels are turned only where all such requirements agree
    (two-colouring of the panels); otherwise those from the placement alone are dropped.

    Raises:
        NotOrientable: where the author's own marks contradict each other.
    """
    marked = [not seam.reversed for seam in pattern.seams]
    placed = [mark or _runs_along(pattern, seam) for mark, seam in zip(marked, pattern.seams, strict=True)]
    colours = _two_colour(pattern, placed)
    if isinstance(colours, int):
        colours = _two_colour(pattern, marked)
    if isinstance(colours, int):
        seam = pattern.seams[colours]
        places = [Place(ref.panel, edge=ref.edge) for ref in (seam.a, seam.b)]
        raise NotOrientable(None, *places, seam=colours)
    groups = _groups(pattern)
    turned = _choose_turns(pattern, colours, groups)
    pattern = replace(pattern, seams=tuple(replace(seam, reversed=True) for seam in pattern.seams))
    for name in turned:
        pattern = _turn_panel(pattern, name)
    return pattern


def _turn_panel(pattern: Pattern, name: str) -> Pattern:
    panel = pattern.panel(name)
    count = len(panel.edges)

    def renumber(ref: EdgeRef) -> EdgeRef:
        return EdgeRef(name, count - 1 - ref.edge) if ref.panel == name else ref

    panels = tuple(flip_panel(other) if other.name == name else other for other in pattern.panels)
    seams = tuple(replace(seam, a=renumber(seam.a), b=renumber(seam.b)) for seam in pattern.seams)
    return replace(pattern, panels=panels, seams=seams)


def _runs_along(pattern: Pattern, seam: Seam) -> bool:
    """Return whether the placed ends of a seam clearly show that both edges have the same direction."""
    if seam.a.panel == seam.b.panel:
        return False
    first, second = pattern.panel(seam.a.panel), pattern.panel(seam.b.panel)
    a = place_points(first, np.stack(chord(first, seam.a.edge)))
    b = place_points(second, np.stack(chord(second, seam.b.edge)))
    one, two = a[1] - a[0], b[1] - b[0]
    parallel = float(one @ two) / max(float(np.linalg.norm(one) * np.linalg.norm(two)), 1e-12)
    along = np.linalg.norm(a - b, axis=1).sum()
    against = np.linalg.norm(a - b[::-1], axis=1).sum()
    return bool(parallel > MIN_PARALLEL_CHORD_COSINE and along < against)


def _links(pattern: Pattern) -> dict[str, list[tuple[str, int]]]:
    links: dict[str, list[tuple[str, int]]] = {panel.name: [] for panel in pattern.panels}
    for index, seam in enumerate(pattern.seams):
        links[seam.a.panel].append((seam.b.panel, index))
        links[seam.b.panel].append((seam.a.panel, index))
    return links


def _two_colour(pattern: Pattern, differ: list[bool]) -> dict[str, bool] | int:
    """Colour panels so that exactly the seams in `differ` join two colours, or return a contradicting seam."""
    links, colours = _links(pattern), {}
    for root in links:
        if root in colours:
            continue
        colours[root], queue = False, deque([root])
        while queue:
            name = queue.popleft()
            for other, index in links[name]:
                colour = colours[name] != differ[index]
                if other not in colours:
                    colours[other] = colour
                    queue.append(other)
                elif colours[other] != colour:
                    return index
    return colours


def _groups(pattern: Pattern) -> list[list[str]]:
    """Return the names of the panels of each connected group."""
    links, seen, groups = _links(pattern), set(), []
    for root in links:
        if root in seen:
            continue
        group, queue = [], deque([root])
        seen.add(root)
        while queue:
            name = queue.popleft()
            group.append(name)
            for other, _ in links[name]:
                if other not in seen:
                    seen.add(other)
                    queue.append(other)
        groups.append(group)
    return groups


def _choose_turns(pattern: Pattern, colours: dict[str, bool], groups: list[list[str]]) -> list[str]:
    """Choose in each group the colour to turn, so that normals point away from the group's middle. A group of one
    colour is turned as a whole only where its normals clearly point inwards (by a tenth of the possible sum), since a
    flat group does not show its outside."""
    turned = []
    for group in groups:
        panels = [pattern.panel(name) for name in group]
        areas = np.array([abs(panel_area(panel)) for panel in panels])
        middles = np.array([place_points(panel, panel.points).mean(axis=0) for panel in panels])
        offsets = middles - (areas[:, None] * middles).sum(axis=0) / areas.sum()
        signs = np.array([-1.0 if colours[name] else 1.0 for name in group])
        normals = signs[:, None] * np.array([panel.rotation[:, 2] for panel in panels])
        outwards = float((areas * np.einsum("ij,ij->i", normals, offsets)).sum())
        could = float((areas * np.linalg.norm(offsets, axis=1)).sum())
        turn_others = outwards < -0.1 * could
        turned += [name for name in group if colours[name] != turn_others]
    return turned
