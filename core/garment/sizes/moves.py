"""Move a pattern's control points and handles: by what a draft changes, or by a field of moves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..curves import place_on_chord, relative_to_chord
from ..pattern import Edge, Panel, Pattern

Move = Callable[[np.ndarray], np.ndarray]
"""Moves [m] of flat points [m], both of shape [n, 2]."""


def move_panel(panel: Panel, move: Move) -> Panel:
    """Return a panel whose control points and handles are moved, so that its curves keep their tangents where the
    moves keep directions; arcs follow their control points."""
    points = panel.points + move(panel.points)
    edges, count = [], len(panel.points)
    for i, edge in enumerate(panel.edges):
        if edge.kind in ("quadratic", "cubic"):
            ends = [panel.points[i], panel.points[(i + 1) % count]]
            handles = place_on_chord(edge.handles, *ends)
            moved = relative_to_chord(handles + move(handles), points[i], points[(i + 1) % count])
            edge = replace(edge, handles=moved)
        edges.append(edge)
    return replace(panel, points=points, edges=tuple(edges))


def move_panel_by_drafts(panel: Panel, old: Panel, new: Panel, stature: float) -> Panel:
    """Return a panel moved by what its draft changes: control points, placement, and handles of edges that are curves
    of one kind in pattern and draft.

    Args:
        panel: The panel.
        old, new: Its drafts for the wearer's measures and for the size's.
        stature: Height of the size relative to the wearer's [1]; the placement follows it alone, since lengths that
            grow with girths do not lift a garment.
    """
    shift = new.translation - old.translation
    shift[1] = (stature - 1.0) * old.translation[1]
    return replace(
        panel,
        points=panel.points + new.points - old.points,
        translation=panel.translation + shift,
        edges=tuple(_move_handles(*edges) for edges in zip(panel.edges, old.edges, new.edges, strict=True)),
    )


def match_drafts(pattern: Pattern, draft: Pattern) -> bool:
    """Check whether the control points of a pattern and a draft correspond."""
    return [(panel.name, len(panel.points)) for panel in draft.panels] == [
        (panel.name, len(panel.points)) for panel in pattern.panels
    ]


def _move_handles(edge: Edge, old: Edge, new: Edge) -> Edge:
    if edge.kind == old.kind == new.kind and edge.kind in ("quadratic", "cubic"):
        return replace(edge, handles=edge.handles + new.handles - old.handles)
    return edge
