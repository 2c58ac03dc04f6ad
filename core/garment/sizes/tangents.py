"""Keep the directions of curves at named points as they grow, so that lines that cross a seam stay smooth there."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ..curves import place_on_chord, relative_to_chord
from ..pattern import EdgeRef, Panel, Pattern
from .bodice_points import find_bodice_points, find_trunk_panels, is_armhole
from .leg_points import find_leg_points

MIN_STRETCHED_SPAN = 0.01
"""Smallest extent of an edge along an axis by which its handles are stretched [m]; below, its chord's length counts."""

MIN_HANDLE_LENGTH = 1e-9
"""Length below which a handle has no direction [m]."""


def keep_tangents(pattern: Pattern, moved: Pattern) -> Pattern:
    """Return a moved pattern whose armholes, necklines and curves at the crotch leave both ends in the directions that
    they have in the pattern; their handles are as long as if they were stretched with their ends along x and y."""
    panels = {panel.name: panel for panel in moved.panels}
    for ref in dict.fromkeys(_list_named_curves(pattern)):
        before, after = pattern.panel(ref.panel), panels[ref.panel]
        if before.edges[ref.edge].kind == after.edges[ref.edge].kind == "cubic":
            edges = list(after.edges)
            edges[ref.edge] = replace(edges[ref.edge], handles=_find_handles(before, after, ref.edge))
            panels[ref.panel] = replace(after, edges=tuple(edges))
    return replace(moved, panels=tuple(panels[panel.name] for panel in moved.panels))


def _list_named_curves(pattern: Pattern) -> Iterator[EdgeRef]:
    """Yield the edges of armholes and necklines, and those that end at a crotch point."""
    for name in find_trunk_panels(pattern):
        edges = (EdgeRef(name, i) for i in range(len(pattern.panel(name).edges)))
        yield from (ref for ref in edges if is_armhole(pattern, ref))
    for face in find_bodice_points(pattern):
        yield from face.neckline
    for leg in find_leg_points(pattern):
        name, i = leg.fork
        yield EdgeRef(name, i)
        yield EdgeRef(name, (i - 1) % len(pattern.panel(name).points))


def _find_handles(before: Panel, after: Panel, edge: int) -> np.ndarray:
    """Return the relative handles of a cubic edge of a moved panel, shape [2, 2]."""
    following = (edge + 1) % len(before.points)
    old, new = before.points[[edge, following]], after.points[[edge, following]]
    spans = np.stack([old[1] - old[0], new[1] - new[0]])
    longer = np.full(2, np.linalg.norm(spans[1]) / np.linalg.norm(spans[0]))
    wide = np.abs(spans).min(axis=0) > MIN_STRETCHED_SPAN
    longer[wide] = np.abs(spans[1] / spans[0])[wide]
    handles = place_on_chord(before.edges[edge].handles, *old) - old
    lengths = np.linalg.norm(handles * longer, axis=1) / np.maximum(np.linalg.norm(handles, axis=1), MIN_HANDLE_LENGTH)
    return relative_to_chord(new + lengths[:, None] * handles, *new)
