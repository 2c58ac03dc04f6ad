"""Signed distances to skin that is new in every step, with few questions about what is inside."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...body.exposed import ExposedSurface

MIN_OUTSIDE_COSINE = 0.97
"""Cosine of the angle between the direction from a point's foot to the point and the foot's normal, above which the
point is outside without a further test. A point inside lies behind its nearest skin, except in the sharpest folds: of
20,000 points around a body 6 inside it have more than 0.5, 1 has more than 0.9, none more than 0.95. One in ten of
those outside is tested further."""


@dataclass(frozen=True)
class MovingSkin:
    """Show a body's skin in the open for one pose.

    Whether a point is inside by the winding number costs more than its foot (17 against 12 ms for 4000 nodes), and of
    cloth on a body nearly all is plainly outside.

    Attributes:
        surface: The skin in the open.
    """

    surface: ExposedSurface

    def measure(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the signed distance of points, negative inside, and its gradient; see `SignedDistance`."""
        found = self.surface.closest(points)
        way = points - found.foot
        normals = self.surface.normals[found.face]
        doubtful = np.flatnonzero((way * normals).sum(axis=1) < MIN_OUTSIDE_COSINE * found.distance)
        sign = np.ones(len(points))
        sign[doubtful] = np.where(self.surface.contains(points[doubtful]), -1.0, 1.0)
        # below a nanometre the difference of two positions of about 1 m has no direction left in float64
        far = found.distance > 1e-9
        normals[far] = way[far] * (sign[far] / found.distance[far])[:, None]
        return sign * found.distance, normals
