"""Measure whether a pattern's openings and lengths can be those of a garment for a human."""

from __future__ import annotations

import numpy as np

from ..garment.curves import flat_contours
from ..garment.pattern import Pattern

CONTOUR_LENGTH_RANGES = {
    "neck": (0.25, 1.60),
    "armhole": (0.20, 1.20),
    "cuff": (0.12, 1.20),
    "waist": (0.35, 2.00),
    "hem": (0.35, 12.0),
    "leg": (0.15, 2.50),
}
"""Smallest and largest flat length of each kind of open contour [m]: around a baby's neck, arm, wrist, waist and ankle;
around the shoulders, the largest waist in shops, or a full circle to the floor."""

PANEL_LENGTH_RANGE = (0.08, 2.20)
"""Smallest and largest length of a garment's longest panel [m], from a baby's skirt to a gown with a train."""


def measure_plausibility(pattern: Pattern) -> dict[str, float | None]:
    """Measure how far a pattern exceeds the measures of humans. `pattern.beyond_human` is the largest ratio by which
    the flat length of an open contour, or of the longest panel, is below its range or above it; up to 1 all are
    within."""
    longest = max(float(np.ptp(panel.points, axis=0).max()) for panel in pattern.panels)
    sizes = [(longest, PANEL_LENGTH_RANGE)]
    for name, length in flat_contours(pattern).items():
        known = CONTOUR_LENGTH_RANGES.get(name.partition(".")[0])
        if known is not None and length > 0.0:
            sizes.append((length, known))
    return {"pattern.beyond_human": max(max(low / size, size / high) for size, (low, high) in sizes)}
