"""Straighten edges, and smooth or sharpen corners."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from ..curves import chord, relative_to_chord
from ..pattern import Edge, EdgeRef, Panel, Pattern
from ..seams import find_sewn_partners
from .errors import EditBad
from .partners import (
    Corner,
    check_number,
    find_panel,
    mirror_corners,
    mirror_edges,
    restore_seam_lengths,
)

STRAIGHT_HANDLE_TOLERANCE = 1e-9
"""Distance of a handle from its chord [chords] below which it is on the chord."""

SMOOTH_HANDLE_SHARE = 1.0 / 3.0
"""Length of the handle of a smooth corner as a share of its chord. A cubic with such handles on its chord has uniform
speed, so that only the direction changes."""


def straighten_edges(
    pattern: Pattern, panel: str, first: int, last: int, keep_symmetry: bool = True, keep_seams: bool = True
) -> Pattern:
    """Return a pattern with the edges between two control points of a panel made lines. Of both paths around the panel
    the one of fewer edges is taken, from `first` to `last` where they are equal. Mirror images are straightened too,
    and edges sewn to them that are the same curve.

    Args:
        pattern: The pattern.
        panel: Name of the panel.
        first, last: Numbers of the control points.
        keep_symmetry: Straighten mirror images too.
        keep_seams: Straighten equal curves that are sewn to them, and make the seams equal.

    Raises:
        EditBad: where there are no such points.
    """
    found = find_panel(pattern, panel)
    check_number(found, first)
    check_number(found, last)
    count = len(found.points)
    if first == last:
        raise EditBad("straighten takes two different vertices.")
    forward_count, backward_count = (last - first) % count, (first - last) % count
    start, steps = (first, forward_count) if forward_count <= backward_count else (last, backward_count)
    chosen = {EdgeRef(panel, (start + k) % count) for k in range(steps)}
    if keep_symmetry:
        images = mirror_edges(pattern)
        chosen |= {image for ref in chosen for image in images.get(ref, set())}
    if keep_seams:
        sewn = find_sewn_partners(pattern)
        chosen |= {sewn[ref] for ref in chosen if ref in sewn and _is_same_curve(pattern, ref, sewn[ref])}
    edges = {ref: replace(_edge(pattern, ref), kind="line", handles=np.zeros((0, 2))) for ref in chosen}
    return restore_seam_lengths(_with_edges(pattern, edges), pattern, set(), keep_symmetry, keep_seams)


def smooth_corner(
    pattern: Pattern, panel: str, vertex: int, keep_symmetry: bool = True, keep_seams: bool = True
) -> Pattern:
    """Return a pattern with a smooth corner: both edges leave it in the direction of Catmull and Rom, p(i+1) - p(i-1).
    Both edges become cubic; their other ends keep their directions.

    Args:
        pattern: The pattern.
        panel: Name of the panel.
        vertex: Number of the control point.
        keep_symmetry: Smooth mirror images too.
        keep_seams: Make the seams equal.

    Raises:
        EditBad: where there is no such point, or its neighbours coincide.
    """
    return _reshape(pattern, (panel, vertex), keep_symmetry, keep_seams, is_smooth=True)


def sharpen_corner(
    pattern: Pattern, panel: str, vertex: int, keep_symmetry: bool = True, keep_seams: bool = True
) -> Pattern:
    """Return a pattern with a sharp corner in place of a smooth one: both edges leave it along their chords. An edge
    without curvature becomes a line, so that this inverts `smooth_corner` between lines.

    Args:
        pattern: The pattern.
        panel: Name of the panel.
        vertex: Number of the control point.
        keep_symmetry: Sharpen mirror images too.
        keep_seams: Make the seams equal.

    Raises:
        EditBad: where there is no such point.
    """
    return _reshape(pattern, (panel, vertex), keep_symmetry, keep_seams, is_smooth=False)


def _reshape(pattern: Pattern, corner: Corner, keep_symmetry: bool, keep_seams: bool, is_smooth: bool) -> Pattern:
    check_number(find_panel(pattern, corner[0]), corner[1])
    corners = {corner}
    if keep_symmetry:
        corners |= {image for image, _ in mirror_corners(pattern).get(corner, [])}
    edited = pattern
    for name, number in sorted(corners):
        edited = _turn_handles(edited, edited.panel(name), number, is_smooth)
    return restore_seam_lengths(edited, pattern, set(), keep_symmetry, keep_seams)


def _turn_handles(pattern: Pattern, panel: Panel, vertex: int, is_smooth: bool) -> Pattern:
    """Return a pattern whose two edges at a control point leave it along a common line, or along their chords."""
    count = len(panel.points)
    before, corner, after = (panel.points[(vertex + k) % count] for k in (-1, 0, 1))
    line = after - before
    size = float(np.linalg.norm(line))
    if is_smooth and size == 0.0:
        raise EditBad(f"the neighbours of vertex {vertex} of panel '{panel.name}' are one point; it has no direction.")
    edges = {}
    for edge, sign in (((vertex - 1) % count, -1.0), (vertex, 1.0)):
        start, end = chord(panel, edge)
        handles = _as_cubic(panel.edges[edge])
        at = 1 if sign < 0 else 0
        if is_smooth:
            handle = corner + sign * line / size * SMOOTH_HANDLE_SHARE * float(np.linalg.norm(end - start))
            handles[at] = relative_to_chord(handle[None], start, end)[0]
        else:
            handles[at] = [1.0 - SMOOTH_HANDLE_SHARE, 0.0] if at else [SMOOTH_HANDLE_SHARE, 0.0]
        edges[EdgeRef(panel.name, edge)] = _edge_from_handles(panel.edges[edge], handles)
    return _with_edges(pattern, edges)


def _as_cubic(edge: Edge) -> np.ndarray:
    """Return the handles of an edge as a cubic, shape [2, 2]; for an arc those of a near cubic with its end
    directions."""
    if edge.kind == "cubic":
        return edge.handles.copy()
    ends = np.array([[0.0, 0.0], [1.0, 0.0]])
    if edge.kind == "quadratic":  # the same curve
        return np.asarray(ends + 2.0 / 3.0 * (edge.handles[0] - ends))
    if edge.kind == "arc":
        height = float(edge.handles[0, 1])
        half = 2.0 * np.arctan2(height, 0.5)  # half of the arc's turn, signed as the height
        reach = (
            4.0 / 3.0 * np.tan(half / 2.0) / (2.0 * np.sin(half))
            if abs(half) > STRAIGHT_HANDLE_TOLERANCE
            else SMOOTH_HANDLE_SHARE
        )
        return np.array(
            [[reach * np.cos(half), reach * np.sin(half)], [1.0 - reach * np.cos(half), reach * np.sin(half)]]
        )
    return np.array([[SMOOTH_HANDLE_SHARE, 0.0], [1.0 - SMOOTH_HANDLE_SHARE, 0.0]])


def _edge_from_handles(edge: Edge, handles: np.ndarray) -> Edge:
    """Return a cubic edge with handles; a line where they are on its chord."""
    if np.all(np.abs(handles[:, 1]) < STRAIGHT_HANDLE_TOLERANCE):
        return replace(edge, kind="line", handles=np.zeros((0, 2)))
    return replace(edge, kind="cubic", handles=handles)


def _is_same_curve(pattern: Pattern, one: EdgeRef, other: EdgeRef) -> bool:
    """Return whether two sewn edges have one shape, so that they coincide when aligned along the seam."""
    a, b = _edge(pattern, one), _edge(pattern, other)
    if a.kind != b.kind:
        return False
    forth = a.handles[::-1] * np.array([-1.0, 1.0]) + np.array([1.0, 0.0])
    mirrored, fitting = forth, forth * np.array([1.0, -1.0])
    return bool(min(np.abs(shape - b.handles).max(initial=0.0) for shape in (mirrored, fitting)) < 1e-2)


def _edge(pattern: Pattern, ref: EdgeRef) -> Edge:
    return pattern.panel(ref.panel).edges[ref.edge]


def _with_edges(pattern: Pattern, edges: dict[EdgeRef, Edge]) -> Pattern:
    """Return a pattern with some edges replaced."""
    panels = []
    for panel in pattern.panels:
        numbers: Iterable[int] = range(len(panel.edges))
        drawn = tuple(edges.get(EdgeRef(panel.name, i), panel.edges[i]) for i in numbers)
        panels.append(replace(panel, edges=drawn))
    return replace(pattern, panels=tuple(panels))
