"""Find the cloth that a scan shows; the rest is inferred: from the base pattern, the physics, and the cloth around."""

from __future__ import annotations

import numpy as np

from ..garment.garment import Garment
from ..garment.shown_sides import find_shown_sides
from ..geometry.connectivity import HalfEdges
from ..geometry.geometry import face_areas
from ..geometry.rim import Rim
from ..geometry.surface import TriangleSurface


def find_seen_faces(garment: Garment, surface: TriangleSurface) -> np.ndarray:
    """Return the faces that a scan shows, bool, shape [face_count].

    Not shown is what turned cloth covers, where the scan has one layer, and what lies ahead of the scan's border: over
    a hole, beyond an end that another garment covers, or between the trunk and an arm.

    Args:
        garment: The garment, its nodes fitted to the scan [m].
        surface: The scan's surface.
    """
    half_edges = HalfEdges.of(surface.faces, len(surface.vertices))
    rim = Rim.of(half_edges, surface.faces, half_edges.border)
    closest = surface.closest(garment.nodes[garment.faces].mean(axis=1))
    sides = find_shown_sides(garment, surface, surface.vertex_normals)
    return np.asarray((sides != 0) & ~rim.is_ahead(surface, closest))


def find_seen_nodes(garment: Garment, seen: np.ndarray) -> np.ndarray:
    """Return the nodes of the faces that a scan shows, bool, shape [node_count].

    Args:
        garment: The garment.
        seen: The faces that the scan shows, bool, shape [face_count].
    """
    return np.asarray(np.bincount(garment.faces[seen].ravel(), minlength=len(garment.nodes)) > 0)


def measure_inferred_area(garment: Garment, seen: np.ndarray) -> dict[str, float]:
    """Return the share of each panel's area that is inferred, by the panel's name.

    Args:
        garment: The garment.
        seen: The faces that the scan shows, bool, shape [face_count].
    """
    areas, count = face_areas(garment.nodes, garment.faces), len(garment.pattern.panels)
    whole = np.bincount(garment.panel_of_face, areas, count)
    hidden = np.bincount(garment.panel_of_face, np.where(seen, 0.0, areas), count)
    names = [panel.name for panel in garment.pattern.panels]
    return {name: float(part / total) for name, part, total in zip(names, hidden, whole, strict=True) if total > 0.0}
