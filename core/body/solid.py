"""What a body's mesh encloses, and the skin of it that lies in the open."""

from __future__ import annotations

import numpy as np

from ..geometry.geometry import signed_volume

INSIDE_WINDING_NUMBER = 0.5
"""Winding number above which a point is inside. Holes and parts that overlap change it near them only."""

EXPOSURE_TEST_OFFSET = 5e-4
"""Height above the skin at which a point must be outside for the skin to be exposed [m]: the least distance that cloth
keeps. Nearer parts leave it no room."""


class Solid:
    """Find inside and outside by the winding number (the fast one, Barill et al. 2018), as often as is asked.

    Small holes and parts of a body that run into each other do no harm; a mesh that is inside out is turned.

    Attributes:
        vertices: Positions [m], shape [vertex_count, 3].
        faces: Outward, shape [face_count, 3].
    """

    def __init__(self, vertices: np.ndarray, faces: np.ndarray) -> None:
        import igl

        self.vertices = np.ascontiguousarray(vertices, dtype=np.float64)
        turned = faces[:, ::-1] if signed_volume(self.vertices, faces) < 0 else faces
        self.faces = np.ascontiguousarray(turned, dtype=np.int64)
        self._winding = igl.FastWindingNumberBVH()
        self._winding.init(self.vertices, self.faces, 2)

    def contains(self, points: np.ndarray) -> np.ndarray:
        """Return which points [m], shape [n, 3], are inside, shape [n]."""
        wound = self._winding.winding_number(np.ascontiguousarray(points, dtype=np.float64))
        return np.asarray(wound).reshape(-1) > INSIDE_WINDING_NUMBER

    def exposed(self, points: np.ndarray, normals: np.ndarray) -> np.ndarray:
        """Find which points of the skin [m], with unit normals, shapes [n, 3], no other part swallows, shape [n]."""
        return ~self.contains(points + EXPOSURE_TEST_OFFSET * normals)
