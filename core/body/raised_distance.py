"""Move the zero level of a body's distance grid out by heights given on its skin, without sampling it anew."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..geometry.surface import TriangleSurface
from .body import Body
from .distance import DistanceGrid

RAISED_BAND_WIDTH = 0.03
"""Distance from the skin within which a height counts in full [m]: where a body estimated under cloth can be. It fades
over the same width again, so that distances stay monotonic for heights up to two thirds of it."""


@dataclass(frozen=True)
class RaisedDistance:
    """Describe the distance to a body whose skin is raised, to first order in the heights.

    d'(x) = d(x) - f(|d(x)|) h(p(x)), p the closest point of the skin. It is subtracted from the spline's coefficients
    instead of its values, which averages h over a cell.

    Attributes:
        grid: The distance d.
        places: Flat indices of the coefficients near the skin, shape [n].
        corners: Vertices of the skin around the closest point of each, shape [n, 3].
        weights: Its barycentric coordinates times f, shape [n, 3].
    """

    grid: DistanceGrid
    places: np.ndarray
    corners: np.ndarray
    weights: np.ndarray

    @classmethod
    def of(cls, body: Body, grid: DistanceGrid) -> RaisedDistance:
        """Prepare the grid of a body in its pose."""
        distance = np.abs(grid.coefficients).ravel()
        places = np.flatnonzero(distance < 2.0 * RAISED_BAND_WIDTH)
        index = np.stack(np.unravel_index(places, grid.coefficients.shape), axis=1)
        found = TriangleSurface(body.vertices, body.faces).closest(grid.origin + grid.spacing * index)
        fade = np.clip(2.0 - distance[places] / RAISED_BAND_WIDTH, 0.0, 1.0)
        smooth = fade * fade * (3.0 - 2.0 * fade)
        return cls(grid, places, np.asarray(body.faces)[found.face], smooth[:, None] * found.barycentric)

    def raise_by(self, heights: np.ndarray) -> DistanceGrid:
        """Return the grid for heights along the skin's normals [m], shape [vertex_count]."""
        coefficients = self.grid.coefficients.copy()
        coefficients.reshape(-1)[self.places] -= (self.weights * heights[self.corners]).sum(axis=1)
        return replace(self.grid, coefficients=coefficients)
