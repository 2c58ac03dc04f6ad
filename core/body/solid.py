"""The volume that a body's mesh encloses, and the test for exposed skin."""

from __future__ import annotations

import numpy as np

from ..geometry.geometry import signed_volume

INSIDE_WINDING_NUMBER = 0.5
"""Winding number [1] above which a point is inside. Holes and overlapping parts change it near them only."""

EXPOSURE_TEST_OFFSET = 5e-4
"""Height above the skin at which a point of exposed skin must be outside [m]: the least distance of cloth."""


class Solid:
    """Find inside and outside of a mesh by the fast winding number (Barill et al. 2018), for repeated queries. Small
    holes and intersecting parts are tolerated; a mesh that is inside out is turned. `faces` are outward."""

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
        """Find which points of the skin [m], with unit normals, shapes [n, 3], are inside no other part, shape [n]."""
        return ~self.contains(points + EXPOSURE_TEST_OFFSET * normals)
