"""Find the creases of a garment: seams, or folds of one piece, about which a part of it is turned over and pressed."""

from __future__ import annotations

import numpy as np

from ..geometry.connectivity import HalfEdges, find_components
from .curves import panel_area
from .garment import Garment
from .pattern import EdgeRef, Pattern

CREASE_LABEL = "fold."
"""Beginning of the labels of edges that are sewn along a crease."""

CREASE_ANGLE = np.deg2rad(165.0)
"""Angle by which a pressed crease turns the cloth at rest [rad]: a flat fold has 180 degrees, and a collar's cloth and
interfacing are a roll between its two sides."""


def is_crease(pattern: Pattern, ref: EdgeRef) -> bool:
    """Check whether an edge of a pattern is sewn along a crease."""
    return pattern.panel(ref.panel).edges[ref.edge].label.startswith(CREASE_LABEL)


def find_turned_panels(pattern: Pattern) -> frozenset[str]:
    """Return the names of the panels that are turned over: those that only creases join to the rest of the garment.

    Of the parts between the creases the largest is worn, and each of the others is turned.
    """
    names = [panel.name for panel in pattern.panels]
    flat = [seam for seam in pattern.seams if not is_crease(pattern, seam.a)]
    if len(flat) == len(pattern.seams):
        return frozenset()
    ends = np.array([[names.index(seam.a.panel), names.index(seam.b.panel)] for seam in flat]).reshape(-1, 2)
    count, part = find_components(len(names), ends[:, 0], ends[:, 1])
    areas = np.bincount(part, [panel_area(panel) for panel in pattern.panels], count)
    return frozenset(name for name, of in zip(names, part, strict=True) if of != int(areas.argmax()))


def turned_area(pattern: Pattern) -> float:
    """Return the area of the panels that are turned over [m2]."""
    turned = find_turned_panels(pattern)
    return sum(panel_area(panel) for panel in pattern.panels if panel.name in turned)


def mark_turned_faces(garment: Garment) -> np.ndarray:
    """Return which faces of a garment are of panels that are turned over, bool, shape [face_count]."""
    turned = find_turned_panels(garment.pattern)
    panels = np.array([panel.name in turned for panel in garment.pattern.panels])
    return np.asarray(panels[garment.panel_of_face])


def crease_edges(garment: Garment) -> np.ndarray:
    """Return the edges of a garment's mesh that lie on its creases, lower node first, shape [n, 2]."""
    lines = [garment.uv_node[line] for ref, line in garment.edge_uv.items() if is_crease(garment.pattern, ref)]
    pairs = [np.column_stack([line[:-1], line[1:]]) for line in lines]
    found: np.ndarray = np.unique(np.sort(np.concatenate([np.zeros((0, 2), np.int64), *pairs]), axis=1), axis=0)
    return found


def mark_edges(edges: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """Return which of some edges, shape [n, 2], are among the chosen ones, lower node first, shape [n]."""
    count = int(max(edges.max(initial=0), chosen.max(initial=0))) + 1
    ordered = np.sort(edges, axis=1)
    found: np.ndarray = np.isin(ordered[:, 0] * count + ordered[:, 1], chosen[:, 0] * count + chosen[:, 1])
    return found


def crease_angles(garment: Garment) -> np.ndarray | None:
    """Return the rest angle of each hinge of a garment [rad], shape [hinge_count]; None where it has no crease.

    The angle between the two normals is negative where the outsides of the cloth face each other.
    """
    edges = crease_edges(garment)
    if not len(edges):
        return None
    hinges = HalfEdges.of(garment.faces, len(garment.nodes)).hinge_vertices
    return np.where(mark_edges(hinges[:, :2], edges), -CREASE_ANGLE, 0.0)
