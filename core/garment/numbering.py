"""How a file numbers the edges and control points of a panel that was reordered when it was read."""

from __future__ import annotations

from dataclasses import dataclass, replace

from .errors import Place


@dataclass(frozen=True)
class Numbering:
    """Return how a file numbers a panel.

    Attributes:
        edges: The file's number of each edge of ours.
        vertices: The file's number of each control point of ours.
    """

    edges: tuple[int, ...]
    vertices: tuple[int, ...]


def renumber(place: Place, numbers: Numbering) -> Place:
    """Return a place with the file's numbers of its edge and control point."""
    edge = None if place.edge is None else numbers.edges[place.edge]
    return replace(place, edge=edge, vertex=None if place.vertex is None else numbers.vertices[place.vertex])
