"""The interface of a body for contact, clearance and measures: its signed distance."""

from __future__ import annotations

from typing import Protocol

import numpy as np


class SignedDistance(Protocol):
    """Describe a body by its signed distance, negative inside: a grid, a mesh's exposed skin, or a pose's shell."""

    def measure(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Compute the signed distance of points and its gradient.

        Where the gradient is not of unit length, distance / |gradient| is the distance to first order. A body may have
        s surfaces for each point: the result then has s n rows, those of the nearest surface first.

        Args:
            points: Positions [m], shape [n, 3].

        Returns:
            Distance [m], negative inside, shape [n]; gradient, outward, shape [n, 3].
        """
        ...
