"""Mesh a pattern anew, transfer another mesh's drape to it, and hold it there by its waist."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..body import Body
from ..drape import tie_contour, waist_loop
from ..pattern import Garment, Pattern, mesh_pattern, resample
from ..segment import Target, name_contours

if TYPE_CHECKING:
    from ..simulate import Hold


def remesh_and_transfer(pattern: Pattern, count: int, garment: Garment, nodes: np.ndarray, body: Body) -> Garment:
    """Mesh a pattern anew and transfer the drape of another mesh of it, contours named.

    Meshed anew, because triangles that are moved along with many points get thin in narrow corners.

    Args:
        pattern: What to mesh; panels and seams as `garment`'s.
        count: Vertices, about.
        garment: A mesh of the same panels.
        nodes: Positions of that one [m], shape [node_count, 3].
        body: The wearer, on whom the contours are named.
    """
    mesh = mesh_pattern(pattern, count)
    placed = resample(garment, nodes, mesh)
    return mesh.at(placed, name_contours(placed, mesh.faces, body)[0])


def hold_waist(garment: Garment, target: Target | None = None) -> Hold | None:
    """Hold what hangs from the waist where it is, or by a target's waist; None for what hangs from the shoulders."""
    from ..simulate import Hold

    waist = waist_loop(garment)
    if waist is None:
        return None
    points, wanted = garment.nodes[waist], None if target is None else target.contour("waist")
    if target is not None and wanted is not None:
        points = tie_contour(points, target.vertices[wanted.vertices])
    return Hold(waist, points)
