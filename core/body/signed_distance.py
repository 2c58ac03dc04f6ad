"""Where the body is: the one question that contact, clearance and measures ask, whatever answers it."""

from __future__ import annotations

from typing import Protocol

import numpy as np


class SignedDistance(Protocol):
    """A body by its signed distance, negative inside: a grid, the exposed skin of a mesh, or the shell of a pose."""

    def measure(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the signed distance of points and its gradient.

        Where the gradient is not of unit length, distance / |gradient| is the distance to first order. A body may show
        each point s surfaces, the nearest first: its answers have s n rows, those of the nearest surface first.

        Args:
            points: Positions [m], shape [n, 3].

        Returns:
            Distance [m], negative inside, shape [n]; gradient, outward, shape [n, 3].
        """
        ...
