"""A file's numbering of the edges and control points of a panel that was reordered on reading."""

from __future__ import annotations

from dataclasses import dataclass, replace

from .errors import Place


@dataclass(frozen=True)
class Numbering:
    """Describe the file's numbers of each edge and of each control point of a panel."""

    edges: tuple[int, ...]
    vertices: tuple[int, ...]


def renumber(place: Place, numbers: Numbering) -> Place:
    """Return a place with the file's numbers of its edge and control point."""
    edge = None if place.edge is None else numbers.edges[place.edge]
    return replace(place, edge=edge, vertex=None if place.vertex is None else numbers.vertices[place.vertex])
