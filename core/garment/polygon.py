"""Area and width of a flat outline."""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull


def polygon_area(polygon: np.ndarray) -> float:
    """Return the area [m2] of a polygon, shape [n, 2]; positive for counter-clockwise order."""
    x, y = (polygon - polygon[0]).T
    return float(0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def polygon_width(polygon: np.ndarray) -> float:
    """Return the smallest distance [m] between two parallel lines with a polygon, shape [n, 2], between them."""
    corners = polygon[ConvexHull(polygon).vertices]
    side = np.roll(corners, -1, axis=0) - corners
    side = side / np.linalg.norm(side, axis=1, keepdims=True)
    height = corners @ np.stack([-side[:, 1], side[:, 0]])
    return float(np.min(height.max(axis=0) - height.min(axis=0)))
