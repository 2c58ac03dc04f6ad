"""Measure how far a garment's front lies ahead of its wearer, in cells as seen from in front."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_erosion, distance_transform_edt, map_coordinates

from ...body.body import Body
from ...scan.contours.target import Target

CELL_SIZE = 0.003
"""Width and height of a cell [m]: half an edge of a fine scan's mesh."""

MIN_AHEAD_COSINE = 0.5
"""Least cosine of a face's normal with the forward direction [1]: 60 degrees aside, a cell is two deep."""

FRONT_HALF_WIDTH, FRONT_TOP, FRONT_BOTTOM = 0.27, 0.05, -0.75
"""Extent of the front to both sides, above and below the neck joint [m]: shoulders, and below the hips."""


def front_frame(body: Body) -> np.ndarray:
    """Return the unit directions to the wearer's left, up and ahead as columns, shape [3, 3]."""
    lateral = body.sideways("shoulder")
    lateral = lateral / np.linalg.norm(lateral)
    up = np.array([0.0, 1.0, 0.0])
    return np.stack([lateral, up, np.cross(lateral, up)], axis=1)


@dataclass(frozen=True)
class FrontHeights:
    """Describe how far the outermost cloth lies ahead of the neck joint.

    Attributes:
        heights: By rows from above and columns from the wearer's right [m], shape [rows, columns]; continued from the
            nearest cell where no cloth is seen.
        known: Where cloth is seen, bool, shape [rows, columns].
    """

    heights: np.ndarray
    known: np.ndarray

    @classmethod
    def of(cls, target: Target, body: Body) -> FrontHeights | None:
        """Measure a target; None where it shows no front."""
        points = (target.vertices - body.joint("neck")) @ front_frame(body)
        corners = points[target.faces]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        doubled = np.linalg.norm(normals, axis=1)
        kept = (normals[:, 2] > MIN_AHEAD_COSINE * doubled) & (corners[:, :, 2].mean(axis=1) > 0.0)
        kept &= (np.abs(corners[:, :, 0]).max(axis=1) < FRONT_HALF_WIDTH - CELL_SIZE) & (
            (corners[:, :, 1].min(axis=1) > FRONT_BOTTOM) & (corners[:, :, 1].max(axis=1) < FRONT_TOP - CELL_SIZE)
        )
        if not kept.any():
            return None
        rows, columns = round((FRONT_TOP - FRONT_BOTTOM) / CELL_SIZE), round(2.0 * FRONT_HALF_WIDTH / CELL_SIZE)
        x, y, z = _sample_faces(corners[kept], np.sqrt(0.5 * doubled[kept])).T
        row = np.minimum(np.round((FRONT_TOP - y) / CELL_SIZE).astype(np.int64), rows - 1)
        column = np.round((x + FRONT_HALF_WIDTH) / CELL_SIZE).astype(np.int64)
        heights = np.full((rows, columns), -np.inf)
        np.maximum.at(heights, (row, column), z)
        known = np.isfinite(heights)
        nearest = distance_transform_edt(~known, return_distances=False, return_indices=True)
        return cls(heights[tuple(nearest)], binary_erosion(known, iterations=2))

    def mirror(self) -> FrontHeights:
        """Return the heights with left and right exchanged."""
        return FrontHeights(self.heights[:, ::-1], self.known[:, ::-1])

    def sample(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return heights [m], and whether they are known, at places to the left and above the neck joint [m]."""
        at = [(FRONT_TOP - y) / CELL_SIZE, (x + FRONT_HALF_WIDTH) / CELL_SIZE]
        heights = map_coordinates(self.heights, at, order=1, mode="nearest")
        known = map_coordinates(self.known.astype(np.float64), at, order=0, mode="constant") > 0.5
        return heights, known


def _sample_faces(corners: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Return points on faces, at least one in each cell that a face covers.

    Args:
        corners: Of the faces [m], shape [n, 3, 3].
        sizes: Roots of their areas [m], shape [n].
    """
    parts = np.ceil(sizes / (0.6 * CELL_SIZE)).astype(np.int64) + 1
    found = []
    for count in np.unique(parts):
        i, j = np.meshgrid(np.arange(count + 1), np.arange(count + 1))
        inside = i + j <= count
        shares = np.stack([i[inside], j[inside], count - i[inside] - j[inside]], axis=1) / count
        found.append(np.einsum("sk,nkd->nsd", shares, corners[parts == count]).reshape(-1, 3))
    return np.concatenate(found)
