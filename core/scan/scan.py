"""Describe the checked surface on which everything after the file works."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..geometry.geometry import face_areas
from ..geometry.surface import TriangleSurface


@dataclass(frozen=True)
class Scan:
    """Describe one checked triangle mesh in metres, y up, faces outward and counter-clockwise.

    Attributes:
        vertices: Positions [m], float64, shape [vertex_count, 3].
        faces: Vertex indices, int64, shape [face_count, 3].
        name: The file's stem.
        sha256: Hash of the file's bytes (hex); empty for a mesh made in memory.
        units: Unit of the file, a name of `UNITS`.
        up_axis: Axis of the file that became y, `y` or `z`.
        colours: RGB in 0..1, shape [vertex_count, 3], or None.
        labels: Integer label of each vertex, shape [vertex_count], or None.
        unseen: True at vertices of a cut-out garment with nothing seen beyond, shape [vertex_count]; None: unknown.
        hidden: True at vertices of a border beyond which the garment may go on, below another one or since nothing
            shows that it ends, shape [vertex_count]; None: nowhere.
        repairs: What was repaired, one short sentence each.
    """

    vertices: np.ndarray
    faces: np.ndarray
    name: str = "mesh"
    sha256: str = ""
    units: str = "m"
    up_axis: str = "y"
    colours: np.ndarray | None = None
    labels: np.ndarray | None = None
    repairs: tuple[str, ...] = ()
    unseen: np.ndarray | None = None
    hidden: np.ndarray | None = None

    @cached_property
    def surface(self) -> TriangleSurface:
        """Return the mesh for queries; its search tree, which takes seconds for a million faces, is built once."""
        return TriangleSurface(self.vertices, self.faces)


def describe_scan(scan: Scan) -> dict[str, Any]:
    """Return a mesh's name, hash, unit, axis, extent [m], counts, area [m2] and repairs as JSON values."""
    return {
        "name": scan.name,
        "sha256": scan.sha256,
        "units": scan.units,
        "up": scan.up_axis,
        "extent_m": [round(float(side), 4) for side in np.ptp(scan.vertices, axis=0)],
        "vertex_count": len(scan.vertices),
        "face_count": len(scan.faces),
        "area_m2": round(float(face_areas(scan.vertices, scan.faces).sum()), 4),
        "repairs": list(scan.repairs),
        "has_colours": scan.colours is not None,
        "has_labels": scan.labels is not None,
    }
