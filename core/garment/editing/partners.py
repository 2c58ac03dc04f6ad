"""Partners that follow an edit: edges sewn to an edge, and mirror images of edges and control points."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..errors import Place
from ..pattern import EdgeRef, Panel, Pattern
from ..seams import equalise_seams
from ..symmetry import Symmetry, find_symmetry
from .errors import EditBad

Corner = tuple[str, int]
"""Panel's name, and index of a control point in it."""


def find_panel(pattern: Pattern, name: str) -> Panel:
    """Return a panel by its name.

    Raises:
        EditBad: where there is none.
    """
    try:
        return pattern.panel(name)
    except KeyError:
        known = ", ".join(panel.name for panel in pattern.panels)
        raise EditBad(f"there is no panel '{name[:60]}'; there are {known}.") from None


def check_number(panel: Panel, number: int) -> None:
    """Check that a panel has an edge or control point of a number.

    Raises:
        EditBad: where it has none.
    """
    if not 0 <= number < len(panel.points):
        message = f"panel '{panel.name}' has no edge or vertex {number}; it has 0 to {len(panel.points) - 1}."
        raise EditBad(message, Place(panel.name))


def mirror_corners(pattern: Pattern) -> dict[Corner, list[tuple[Corner, np.ndarray]]]:
    """Return the images of each control point, each with the matrix from a move of the point to that of the image."""
    found: dict[Corner, list[tuple[Corner, np.ndarray]]] = {}
    for mirror in find_symmetry(pattern).mirrors:
        source, target = pattern.panels[mirror.source].name, pattern.panels[mirror.target].name
        for j, i in enumerate(mirror.order.tolist()):
            found.setdefault((source, i), []).append(((target, j), mirror.rotation))
            found.setdefault((target, j), []).append(((source, i), mirror.rotation.T))
    return found


def mirror_edges(pattern: Pattern) -> dict[EdgeRef, set[EdgeRef]]:
    """Return the images of each edge; an image has the reverse direction."""
    found: dict[EdgeRef, set[EdgeRef]] = {}
    for mirror in find_symmetry(pattern).mirrors:
        source, target = pattern.panels[mirror.source].name, pattern.panels[mirror.target].name
        count = len(mirror.order)
        for j in range(count):
            one, other = EdgeRef(target, j), EdgeRef(source, int(mirror.order[j] - 1) % count)
            if one != other:
                found.setdefault(one, set()).add(other)
                found.setdefault(other, set()).add(one)
    return found


def restore_seam_lengths(
    edited: Pattern, before: Pattern, fixed: set[Corner], keep_symmetry: bool, keep_seams: bool
) -> Pattern:
    """Return an edited pattern with the sides of its seams made equal, if `keep_seams`.

    Args:
        edited: The pattern after an operation.
        before: The one before, of the same panels and seams, with the ratios of gathers.
        fixed: Control points that stay.
        keep_symmetry: Move mirror images alike.
        keep_seams: Make the seams equal; False returns the pattern as it is.
    """
    if not keep_seams:
        return edited
    free = replace(edited, symmetric=False)
    symmetry: Symmetry = find_symmetry(edited if keep_symmetry else free)
    return equalise_seams(edited, fixed=fixed, base=before, symmetry=symmetry)
