"""Signed distances to skin that changes in every step, with few tests for being inside."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...body.exposed import ExposedSurface

MIN_OUTSIDE_COSINE = 0.97
"""Cosine between the way from a point's foot to the point and the foot's normal above which the point is outside
without a further test. A point inside is behind its nearest skin, except in the sharpest folds: of 20,000 points around
a body 6 inside have more than 0.5, 1 has more than 0.9, none more than 0.95; of those outside one in ten has less."""


@dataclass(frozen=True)
class MovingSkin:
    """Describe a body's exposed skin in one pose. Testing by the winding number whether a point is inside costs more
    than its foot (17 against 12 ms for 4000 nodes), and nearly all cloth on a body is clearly outside."""

    surface: ExposedSurface

    def measure(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Compute the signed distance of points, negative inside, and its gradient; see `SignedDistance`."""
        found = self.surface.closest(points)
        offset = points - found.foot
        normals = self.surface.normals[found.face]
        doubtful = np.flatnonzero((offset * normals).sum(axis=1) < MIN_OUTSIDE_COSINE * found.distance)
        sign = np.ones(len(points))
        sign[doubtful] = np.where(self.surface.contains(points[doubtful]), -1.0, 1.0)
        # below a nanometre the difference of two positions of about 1 m has no accurate direction in float64
        is_far = found.distance > 1e-9
        normals[is_far] = offset[is_far] * (sign[is_far] / found.distance[is_far])[:, None]
        return sign * found.distance, normals
