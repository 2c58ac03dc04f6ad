"""Join two panels along a straight seam into one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..curves import chord, edge_length
from ..errors import Place
from ..node_transfer import align_chords
from ..pattern import EdgeRef, Panel, Pattern
from .cutting import reorder
from .edge_division import forget_edges
from .errors import EditBad

PANEL_JOIN_TOLERANCE = 1e-3
"""Largest difference of the lengths of a seam's sides along which panels are joined [m]: a chalk line's width."""


def join_panels(pattern: Pattern, seam: int) -> Pattern:
    """Return a pattern with the two panels of a straight seam joined into one. The second panel is aligned to the first
    along the seam; the joined one has the first's name, axes, placement and grain. The seam's control points stay, also
    where they are smooth (`merge_edges` removes them).

    Args:
        pattern: The pattern.
        seam: Its number; of two lines.

    Raises:
        EditBad: where there is no such seam, it is curved, gathered or of unequal sides, or the panels have another
            seam with each other.
    """
    if not 0 <= seam < len(pattern.seams):
        raise EditBad(f"there is no seam {seam}; there are {len(pattern.seams)}.")
    found = pattern.seams[seam]
    one, other = pattern.panel(found.a.panel), pattern.panel(found.b.panel)
    places = [Place(ref.panel, edge=ref.edge) for ref in (found.a, found.b)]
    _check_seam(pattern, seam, places)
    moved = _align_to_seam(one, found.a.edge, other, found.b.edge)
    counts = len(one.points), len(other.points)
    first = [(found.a.edge + 1 + k) % counts[0] for k in range(counts[0] - 1)]
    second = [(found.b.edge + 1 + k) % counts[1] for k in range(counts[1] - 1)]
    points = np.concatenate([one.points[[*first, found.a.edge]], moved[second[1:]]])
    numbers = {EdgeRef(one.name, edge): EdgeRef(one.name, at) for at, edge in enumerate(first)}
    numbers |= {EdgeRef(other.name, edge): EdgeRef(one.name, len(first) + at) for at, edge in enumerate(second)}
    edges = (*(one.edges[edge] for edge in first), *(other.edges[edge] for edge in second))
    notches = tuple(
        sorted(
            (numbers[EdgeRef(panel.name, edge)].edge, at)
            for panel in (one, other)
            for edge, at in panel.notches
            if EdgeRef(panel.name, edge) in numbers
        )
    )
    joined = replace(one, points=points, edges=edges, notches=notches)
    seams = tuple(
        replace(each, a=numbers.get(each.a, each.a), b=numbers.get(each.b, each.b))
        for number, each in enumerate(pattern.seams)
        if number != seam
    )
    panels = tuple(joined if panel.name == one.name else panel for panel in pattern.panels if panel.name != other.name)
    return reorder(forget_edges(replace(pattern, panels=panels, seams=seams), {one.name}))


def _check_seam(pattern: Pattern, number: int, places: list[Place]) -> None:
    """Raise `EditBad` for a seam along which its panels cannot be joined."""
    seam = pattern.seams[number]
    sides = [(pattern.panel(ref.panel), ref.edge) for ref in (seam.a, seam.b)]
    if seam.a.panel == seam.b.panel:
        raise EditBad(f"seam {number} is of one panel with itself; it stays.", *places, seam=number)
    if any(panel.edges[edge].kind != "line" for panel, edge in sides):
        raise EditBad(f"seam {number} is curved; straighten it first.", *places, seam=number)
    lengths = [edge_length(panel, edge) for panel, edge in sides]
    if abs(lengths[0] - lengths[1]) > PANEL_JOIN_TOLERANCE:
        message = f"the sides of seam {number} differ by {1e3 * abs(lengths[0] - lengths[1]):.1f} mm; make them equal."
        raise EditBad(message, *places, seam=number)
    names = {seam.a.panel, seam.b.panel}
    shared = [k for k, each in enumerate(pattern.seams) if {each.a.panel, each.b.panel} == names]
    if len(shared) > 1:
        others = ", ".join(str(k) for k in shared if k != number)
        raise EditBad(f"the panels of seam {number} are sewn along {others} too; they stay two.", *places, seam=number)


def _align_to_seam(one: Panel, edge: int, other: Panel, facing: int) -> np.ndarray:
    """Return another panel's control points [m] moved beside a panel, seam on seam, shape [n, 2]."""
    motion = align_chords(np.stack(chord(other, facing))[::-1], np.stack(chord(one, edge)))
    return motion.apply(other.points)
