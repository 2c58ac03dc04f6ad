"""Mesh a pattern again and transfer another mesh's drape to it."""

from __future__ import annotations

import numpy as np

from ...body.body import Body
from ...garment.garment import Garment
from ...garment.pattern import Pattern
from ...garment.resampling import resample
from ...garment.sewing import mesh_pattern
from ..drape.worn_contours import name_worn_contours


def remesh_and_transfer(pattern: Pattern, count: int, garment: Garment, nodes: np.ndarray, body: Body) -> Garment:
    """Mesh a pattern again and transfer the drape of another mesh of it, contours named.

    Meshed again, because triangles that are moved with many points become thin in narrow corners.

    Args:
        pattern: The pattern to mesh; panels and seams as `garment`'s.
        count: Approximate number of vertices.
        garment: A mesh of the same panels.
        nodes: Its positions [m], shape [node_count, 3].
        body: The wearer, on whom the contours are named.
    """
    mesh = mesh_pattern(pattern, count)
    placed = resample(garment, nodes, mesh)
    return mesh.at(placed, name_worn_contours(mesh, placed, body))
