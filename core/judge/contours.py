"""Distances between the open contours of two surfaces."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..geometry.curves import Curve
from ..scan.contours.target import Contour

CONTOUR_SAMPLES = 500
"""Number of points along each loop: 2 mm apart on a wide hem, far less than the errors that matter."""


def curve_rms(one: Curve, other: Curve) -> float:
    """Measure the larger RMS distance [m] of two curves, from arc-length samples of each to the other."""
    forward = other.distance(one.resample(CONTOUR_SAMPLES))
    backward = one.distance(other.resample(CONTOUR_SAMPLES))
    return float(max(np.sqrt(np.mean(forward**2)), np.sqrt(np.mean(backward**2))))


def contour_rms(
    nodes: np.ndarray, contours: Sequence[Contour], truth_vertices: np.ndarray, truth_contours: Sequence[Contour]
) -> dict[str, float]:
    """Measure the RMS distance [m] of every trusted contour of the truth that ours has too, by name."""
    curves = {contour.name: contour.curve(nodes) for contour in contours}
    return {
        contour.name: curve_rms(curves[contour.name], contour.curve(truth_vertices))
        for contour in truth_contours
        if contour.trusted and contour.name in curves
    }
