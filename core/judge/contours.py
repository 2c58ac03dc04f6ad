"""Distances between the open contours of two surfaces."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..geometry.curves import ClosedCurve
from ..scan.contours.target import Contour

CONTOUR_SAMPLES = 500
"""Number of points along each loop: 2 mm apart on a wide hem, far less than the errors that matter."""


def loop_rms(first: np.ndarray, second: np.ndarray) -> float:
    """Measure the larger RMS distance [m] of two closed loops, from arc-length samples of each to the other."""
    one, other = ClosedCurve(first), ClosedCurve(second)
    forward = other.distance(one.resample(CONTOUR_SAMPLES))
    backward = one.distance(other.resample(CONTOUR_SAMPLES))
    return float(max(np.sqrt(np.mean(forward**2)), np.sqrt(np.mean(backward**2))))


def contour_rms(
    nodes: np.ndarray, contours: Sequence[Contour], truth_vertices: np.ndarray, truth_contours: Sequence[Contour]
) -> dict[str, float]:
    """Measure the RMS distance [m] of every trusted contour of the truth that ours has too, by name."""
    loops = {contour.name: nodes[contour.vertices] for contour in contours}
    return {
        contour.name: loop_rms(loops[contour.name], truth_vertices[contour.vertices])
        for contour in truth_contours
        if contour.trusted and contour.name in loops
    }
