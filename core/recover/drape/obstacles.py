"""The body as an obstacle while it is flat, or thinner than it is: front and back stay on their sides of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...body.signed_distance import SignedDistance


@dataclass(frozen=True)
class SquashedBody:
    """Describe a body whose depth is scaled about the plane z = middle.

    The level set d(x, y, middle + (z - middle) / scale) is zero on the squashed surface; its gradient is returned
    unscaled, so that distance / |gradient| is the distance to first order.
    """

    body: SignedDistance
    middle: float
    scale: float

    def measure(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the level set's values [m] and gradients, shapes [n] and [n, 3]."""
        mapped = points.copy()
        mapped[:, 2] = self.middle + (points[:, 2] - self.middle) / self.scale
        distance, gradient = self.body.measure(mapped)
        return distance, gradient * np.array([1.0, 1.0, 1.0 / self.scale])


@dataclass(frozen=True)
class FlatObstacle:
    """Describe the obstacle of the flat phase: front and back stay in their planes, seams outside the outline."""

    body: SignedDistance
    middle: float
    side: np.ndarray
    flatten: float

    def measure(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return distances [m] and gradients of the garment's nodes, shapes [n] and [n, 3]."""
        flat = np.column_stack([points[:, :2], np.full(len(points), self.middle)])
        distance, gradient = self.body.measure(flat)
        gradient[:, 2] = 0.0
        off_seam = np.abs(self.side) > 0.5
        distance[off_seam] = np.abs(points[off_seam, 2] - self.middle) - self.flatten
        gradient[off_seam] = np.sign(self.side[off_seam])[:, None] * np.array([0.0, 0.0, 1.0])
        return distance, gradient


@dataclass(frozen=True)
class TwoSidedObstacle:
    """Describe a body and its middle plane as an obstacle: front nodes stay before the plane, back nodes behind it.

    While the body is thin, a crease 1 cm deep would otherwise pass through the neck or the waist to the other side.
    Seams between front and back are in that plane and stay outside the body's `outline` in it: a thin body could only
    push them out of the plane, and a sleeve's upper seam would sink through the arm.
    """

    body: SignedDistance
    outline: SignedDistance | None
    middle: float
    side: np.ndarray

    def measure(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return distances [m] and gradients of the garment's nodes, shapes [n] and [n, 3]."""
        off_seam = np.abs(self.side) > 0.5
        on_seam = np.nonzero(~off_seam)[0]
        sign = np.sign(self.side)
        distance, gradient = self.body.measure(points)
        slope = np.maximum(np.linalg.norm(gradient, axis=1), 1.0)
        depth = sign * (points[:, 2] - self.middle)
        nearer = off_seam & (depth < distance / slope)
        distance[nearer] = depth[nearer]
        gradient[nearer] = sign[nearer, None] * np.array([0.0, 0.0, 1.0])
        if self.outline is not None and len(on_seam):
            distance[on_seam], gradient[on_seam] = self.outline.measure(points[on_seam])
            gradient[on_seam, 2] = 0.0
        return distance, gradient
