"""Add control points to open edges, so that grading can bend a hem or a waist."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from .curves import split_edge
from .pattern import Edge, EdgeRef, Panel, Pattern


def divide_edges(pattern: Pattern, contours: Collection[str], parts: int) -> Pattern:
    """Cut every edge on some open contours into equal parts, but not those of a vent, which are labelled; the
    outlines stay the same curves. A control point at each cut allows an arc of any depth: a straight skirt's hem is
    nearly a line, a full circle skirt's an arc of half a turn, which one chord with fixed handles cannot draw.

    Args:
        pattern: The pattern; edges to be divided are in no seam.
        contours: Names of open contours.
        parts: Parts of equal length that each edge is cut into.
    """
    numbers: dict[tuple[str, int], int] = {}
    panels = []
    for panel in pattern.panels:
        points: list[np.ndarray] = []
        edges: list[Edge] = []
        notches: list[tuple[int, float]] = []
        for i, edge in enumerate(panel.edges):
            numbers[panel.name, i] = len(edges)
            share = parts if edge.contour in contours and not edge.label else 1
            notches += [
                (len(edges) + min(int(at * share), share - 1), at * share - min(int(at * share), share - 1))
                for number, at in panel.notches
                if number == i
            ]
            cuts, pieces = _cut(panel, i, share)
            points += cuts
            edges += pieces
        panels.append(replace(panel, points=np.array(points), edges=tuple(edges), notches=tuple(notches)))

    def renumber(ref: EdgeRef) -> EdgeRef:
        return EdgeRef(ref.panel, numbers[ref.panel, ref.edge])

    seams = tuple(replace(seam, a=renumber(seam.a), b=renumber(seam.b)) for seam in pattern.seams)
    return replace(pattern, panels=tuple(panels), seams=seams)


def _cut(panel: Panel, index: int, parts: int) -> tuple[list[np.ndarray], list[Edge]]:
    """Return the start points and the pieces of one edge cut into equal parts."""
    edge, start = panel.edges[index], panel.points[index]
    end = panel.points[(index + 1) % len(panel.points)]
    points, pieces = [], []
    for left in range(parts, 1, -1):
        cut, piece, edge = split_edge(edge, 1.0 / left)
        points.append(start)
        pieces.append(piece)
        chord = end - start
        start = start + cut[0] * chord + cut[1] * np.array([-chord[1], chord[0]])
    return [*points, start], [*pieces, edge]
